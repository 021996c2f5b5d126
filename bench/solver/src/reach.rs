//! Goals of the solver: settings, the bars beside them, and whether they hold.

use crate::row::Row;

/// A run and what it is held against; what is none is not asked.
pub struct Bar {
    /// A built-in scene.
    pub scene: &'static str,
    /// Particles along a side.
    pub n: u32,
    /// A solver by name.
    pub solver: &'static str,
    /// Steps per frame.
    pub substeps: u32,
    /// Least milliseconds of a frame.
    ms: Option<f64>,
    /// Largest and mean stretch \[%\].
    stretch: [Option<f64>; 2],
}

/// RMS speed \[mm/s\] below which hanging cloth is at rest.
const REST: f64 = 1.0;
/// Deepest particle \[mm\] in the sphere.
const DEEPEST: f64 = 0.05;
/// Error of the period, and amplitude lost in one \[%\].
const SWING: [f64; 2] = [0.3, 1.5];
/// Share by which what is soft may differ from the truth, and the truth: largest stretch, lowest particle \[m\], energy \[J\].
const SOFT: (f64, [f64; 3]) = (0.01, [0.016987, -1.0022003, -0.9835831]);

const fn bar(scene: &'static str, n: u32, solver: &'static str, substeps: u32) -> Bar {
    Bar { scene, n, solver, substeps, ms: None, stretch: [None, None] }
}

const fn timed(bar: Bar, ms: f64, [most, mean]: [f64; 2]) -> Bar {
    Bar { ms: Some(ms), stretch: [Some(most), Some(mean)], ..bar }
}

const fn stretched(bar: Bar, most: f64) -> Bar {
    Bar { stretch: [Some(most), None], ..bar }
}

/// All of them.
pub const BARS: [Bar; 13] = [
    timed(bar("s1", 32, "xpbd+tethers", 3), 0.02, [1.5, 0.094]),
    timed(bar("s1", 64, "xpbd+tethers", 5), 0.1, [1.1, 0.13]),
    timed(bar("s1", 128, "xpbd+tethers+polish", 4), 0.5, [5.0, 0.05]),
    timed(bar("s1", 256, "xpbd+tethers+polish2", 8), 4.0, [5.0, 0.1]),
    timed(bar("s1", 128, "xpbd+pyramid2+iterations3", 7), 1.5, [18.0, 0.6]),
    timed(bar("s1", 128, "xpbd+pyramid3+polish4", 10), 1.2, [6.0, 0.1]),
    bar("s1k", 32, "xpbd+iterations40", 16),
    stretched(bar("s2", 128, "xpbd+polish2", 32), 30.0),
    stretched(bar("s2f", 128, "xpbd+polish8", 35), 150.0),
    bar("s3", 32, "xpbd", 16),
    bar("s3", 64, "xpbd", 32),
    bar("s3", 128, "xpbd", 64),
    bar("s3", 256, "xpbd", 128),
];

/// The first lines of the table.
pub const HEADER: &str =
    "| scene | N | solver | substeps | ms | figures | bars | held |\n|---|---|---|---|---|---|---|---|";

impl Bar {
    /// Every figure that is asked for, with what it must not pass.
    fn asked(&self, row: &Row) -> Vec<(&'static str, f64, f64)> {
        let f = &row.figures;
        let or = |x: Option<f64>| x.unwrap_or(f64::INFINITY);
        let mut all: Vec<(_, _, f64)> = self.ms.map(|most| ("ms", row.ms_min, most)).into_iter().collect();
        let stretch = [("stretch %", f.stretch_max), ("mean %", f.stretch_mean)];
        for ((name, of), most) in stretch.into_iter().zip(self.stretch) {
            all.extend(most.map(|most| (name, 100.0 * or(of), most)));
        }
        match self.scene {
            "s1" => all.push(("rest mm/s", or(f.rest_mm_s), REST)),
            "s1k" => {
                let hem = f.hem_mm.map(|mm| 1e-3 * mm - 1.0);
                let off = |x: Option<f64>, truth: f64| 100.0 * (or(x) / truth - 1.0).abs();
                let (share, [stretch, lowest, energy]) = SOFT;
                all.push(("stretch off by %", off(f.stretch_max, stretch), 100.0 * share));
                all.push(("hem off by %", off(hem, lowest), 100.0 * share));
                all.push(("energy off by %", off(f.energy_j, energy), 100.0 * share));
            }
            "s3" => {
                all.push(("period %", or(f.period_error_pct).abs(), SWING[0]));
                all.push(("loss %", or(f.amplitude_loss_pct).abs(), SWING[1]));
            }
            _ => {
                all.push(("penetration mm", or(f.penetration_mm), DEEPEST));
                all.push(("tunnelled", or(f.tunnelled), 0.0));
            }
        }
        all
    }

    /// A line of the table for a run of this setting.
    pub fn line(&self, row: &Row) -> String {
        let asked = self.asked(row);
        let held = asked.iter().all(|(_, is, most)| is <= most);
        let short = |x: f64| format!("{:.3e}", x).parse().unwrap_or(x);
        let list = |of: &dyn Fn(&(&str, f64, f64)) -> String| asked.iter().map(of).collect::<Vec<_>>().join(", ");
        let figures = list(&|(name, is, _)| format!("{name} {}", short(*is)));
        let bars = list(&|(_, _, most)| most.to_string());
        let Row { scene, n, solver, substeps, .. } = row;
        let held = if held { "yes" } else { "no" };
        format!("| {scene} | {n} | {solver} | {substeps} | {:.4} | {figures} | {bars} | {held} |", row.time())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::Figures;

    fn row(figures: Figures) -> Row {
        let (scene, solver, backend) = ("s1".into(), "xpbd".into(), "cpu");
        Row { scene, n: 32, solver, substeps: 3, backend, frames: 600, ms_min: 0.0123, ms_median: 0.02, figures }
    }

    #[test]
    fn a_bar_holds_where_no_figure_passes_it() {
        let good =
            Figures { stretch_max: Some(0.0149), stretch_mean: Some(9e-4), rest_mm_s: Some(0.5), ..Figures::default() };
        let line = |f| BARS[0].line(&row(f));
        assert!(
            line(good).ends_with(
                "0.0123 | ms 0.0123, stretch % 1.49, mean % 0.09, rest mm/s 0.5 | 0.02, 1.5, 0.094, 1 | yes |"
            )
        );
        assert!(line(Figures { rest_mm_s: Some(1.1), ..good }).ends_with("no |"));
        assert!(line(Figures { stretch_max: Some(0.0151), ..good }).ends_with("no |"));
        assert!(line(Figures { stretch_mean: None, ..good }).ends_with("no |"));
        assert!(line(Figures { stretch_max: Some(f64::NAN), ..good }).ends_with("no |"));
    }

    #[test]
    fn what_is_soft_is_held_against_the_truth_and_swings_against_theirs() {
        let soft = BARS.iter().find(|b| b.scene == "s1k").unwrap();
        let truth =
            Figures { stretch_max: Some(0.0170), hem_mm: Some(-2.2), energy_j: Some(-0.984), ..Figures::default() };
        assert!(soft.line(&row(truth)).ends_with("yes |"));
        assert!(soft.line(&row(Figures { stretch_max: Some(0.0175), ..truth })).ends_with("no |"));
        let swing = BARS.iter().find(|b| b.scene == "s3").unwrap();
        let of = |period, loss| Figures {
            period_error_pct: Some(period),
            amplitude_loss_pct: Some(loss),
            ..Figures::default()
        };
        assert!(swing.line(&row(of(-0.2, 1.0))).ends_with("yes |"));
        assert!(swing.line(&row(of(-0.4, 1.0))).ends_with("no |") && swing.line(&row(of(0.2, 1.6))).ends_with("no |"));
        assert!(BARS.iter().all(|b| b.solver.parse::<crate::variant::Variant>().is_ok_and(|v| v.can(b.scene))));
    }
}
