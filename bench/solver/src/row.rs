//! The table.

use std::fmt::Write;

use crate::score::Figures;

/// One run.
#[derive(Clone, Debug)]
pub struct Row {
    /// A built-in scene.
    pub scene: String,
    /// Particles along a side.
    pub n: u32,
    /// Name of the solver.
    pub solver: String,
    /// Steps per frame.
    pub substeps: u32,
    /// `cpu` or `gpu`.
    pub backend: &'static str,
    /// Frames that were timed.
    pub frames: usize,
    /// Least milliseconds of a frame.
    pub ms_min: f64,
    /// Median of the same.
    pub ms_median: f64,
    /// The errors.
    pub figures: Figures,
}

/// The first line.
pub const HEADER: &str = "scene,n,solver,substeps,backend,frames,ms_min,ms_median,exploded,stretch_max,stretch_mean,\
                          hem_mm,position_rms_mm,rest_mm_s,energy_j,penetration_mm,tunnelled,period_error_pct,\
                          amplitude_loss_pct";

impl Row {
    /// Its line, without the end; what does not apply is left empty.
    pub fn line(&self) -> String {
        let Row { scene, n, solver, substeps, backend, frames, ms_min, ms_median, figures: f } = self;
        let mut line = format!("{scene},{n},{solver},{substeps},{backend},{frames},{ms_min:.4},{ms_median:.4}");
        let _ = write!(line, ",{}", u8::from(f.exploded));
        let all = [
            f.stretch_max,
            f.stretch_mean,
            f.hem_mm,
            f.position_rms_mm,
            f.rest_mm_s,
            f.energy_j,
            f.penetration_mm,
            f.tunnelled,
            f.period_error_pct,
            f.amplitude_loss_pct,
        ];
        for value in all {
            let _ = match value {
                Some(value) => write!(line, ",{}", short(value)),
                None => write!(line, ","),
            };
        }
        line
    }

    /// The time that counts \[ms\]: the least where every frame has the same work, the median where cloth falls on a ball, as
    /// frames before it are cheaper.
    pub fn time(&self) -> f64 {
        if self.scene.starts_with("s2") { self.ms_median } else { self.ms_min }
    }
}

/// Six digits.
fn short(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_a_value_a_column() {
        let figures = Figures { stretch_max: Some(0.123456789), tunnelled: Some(0.0), ..Figures::default() };
        let (scene, solver, backend) = ("s2".into(), "xpbd".into(), "cpu");
        let row = Row { scene, n: 32, solver, substeps: 4, backend, frames: 9, ms_min: 0.1, ms_median: 0.2, figures };
        assert_eq!(row.line(), "s2,32,xpbd,4,cpu,9,0.1000,0.2000,0,0.123457,,,,,,,0,,");
        assert_eq!(row.line().matches(',').count(), HEADER.matches(',').count());
    }
}
