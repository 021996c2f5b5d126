//! Runs a case under a solver, and judges.

use gimage_bench_host::{Gpu, Host};
use gimage_runtime::{Result, Warning};

use crate::case::{Case, Stretch, Tried};
use crate::figures::{Gauge, V3, distance, norm};

/// The outcome of a case.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Frame after which positions were not finite, and how many were not.
    pub broke: Option<(u32, usize)>,
    /// Frame after which all were numbers again, for good.
    pub mended: Option<u32>,
    /// The stretch farthest from 0, at the end of 2 s of calm.
    pub stretch: f64,
    /// RMS speed \[mm/s\] in the last second.
    pub rest: f64,
    /// The same in the middle of the calm: larger where motion dies down, alike where it goes on.
    pub rest_before: f64,
    /// Farthest way \[mm\] of a particle from the second 15 of calm to the end.
    pub drift: f64,
    /// Largest change of momentum over what mass and speed allow.
    pub momentum: f64,
    /// Largest gain of energy, in units of the case.
    pub energy: f64,
    /// Settings that the solver changed because they are beyond its limits.
    pub limited: Vec<&'static str>,
    /// Requirements that do not hold.
    pub failures: Vec<String>,
}

/// Seconds of calm after which stretch is judged, and over which it is averaged.
const RECOVERY: [f64; 2] = [2.0, 0.25];

/// Runs it.
pub fn drive(case: &Case, solver: Tried, gpu: Option<&Gpu>) -> Outcome {
    let mut out = Outcome::default();
    if let Err(error) = run(case, solver, gpu, &mut out) {
        out.failures.push(format!("refused: {error}"));
    }
    out
}

fn run(case: &Case, solver: Tried, gpu: Option<&Gpu>, out: &mut Outcome) -> Result<()> {
    let options = case.options(solver);
    let mut host = Host::new(case.scene.clone(), options, gpu)?;
    let stepper = &host.stepper;
    out.limited = stepper.warnings().iter().map(word).collect();
    // Of the cloth as it is stepped: masses may have been changed.
    let gauge = Gauge::new(&stepper.scene().cloths[0], case.scene.gravity);
    let frames = |seconds: f64| (seconds / case.step).ceil() as u32;
    let (storm, calm) = (frames(case.storm), frames(case.calm));
    let dt = case.step / f64::from(stepper.substeps());
    let mut last = wide(&host.now()?);
    let start = gauge.energy(&last, &wide(&host.before()?), dt);
    let begin = gauge.momentum(&wide(&host.before()?), &last, dt);
    let unit = if gauge.scale > 0.0 { gauge.scale } else { start };
    let (mut stretches, mut speeds, mut kept) = (Vec::new(), [Vec::new(), Vec::new()], Vec::new());
    let (mut changed, mut bustle) = (0f64, 0f64);
    for frame in 0..storm + calm {
        if frame < storm {
            (case.during)(&mut host.stepper, frame)?;
        } else if frame == storm {
            (case.after)(&mut host.stepper)?;
        }
        host.frame(case.step)?;
        let now = wide(&host.now()?);
        let lost = now.iter().filter(|p| p.iter().any(|x| !x.is_finite())).count();
        if lost > 0 {
            out.broke = out.broke.or(Some((frame, lost)));
            out.mended = None;
        } else if out.broke.is_some() {
            out.mended = out.mended.or(Some(frame));
        }
        let seconds = f64::from(frame + 1 - storm.min(frame + 1)) * case.step;
        if frame >= storm && seconds <= RECOVERY[0] + 1e-9 && seconds > RECOVERY[0] - RECOVERY[1] {
            stretches.push(match case.asked.stretch {
                Stretch::OfLongest => gauge.stretch_of_longest(&now),
                _ => gauge.stretch(&now),
            });
        }
        for (speeds, end) in speeds.iter_mut().zip([storm + calm, storm + calm / 2]) {
            if frame < end && frame + frames(1.0) >= end {
                speeds.push(gauge.speed2(&last, &now, case.step));
            }
        }
        if kept.is_empty() && seconds >= 15.0 {
            kept.clone_from(&now);
        }
        if case.asked.momentum {
            let p = gauge.momentum(&last, &now, case.step);
            changed = changed.max(norm([0, 1, 2].map(|c| p[c] - begin[c])));
            bustle = bustle.max(gauge.bustle(&last, &now, case.step));
        }
        if case.asked.energy {
            let energy = gauge.energy(&now, &wide(&host.before()?), dt);
            out.energy = worse(out.energy, (energy - start) / unit);
        }
        last = now;
    }
    out.stretch = stretches.iter().fold(0.0, |sum, s| sum + s.abs()) / stretches.len() as f64;
    out.stretch = out.stretch.copysign(stretches.last().copied().unwrap_or(0.0));
    [out.rest, out.rest_before] = speeds.map(|s| 1e3 * (s.iter().sum::<f64>() / s.len() as f64).sqrt());
    out.drift = 1e3 * kept.iter().zip(&last).map(|(a, b)| distance(*a, *b)).fold(0.0, worse);
    out.momentum = if changed == 0.0 { 0.0 } else { changed / bustle };
    judge(case, solver.tethers > 0, out);
    Ok(())
}

/// The places of particles in f64.
fn wide(positions: &[[f32; 4]]) -> Vec<V3> {
    positions.iter().map(|p| [0, 1, 2].map(|c| f64::from(p[c]))).collect()
}

fn word(warning: &Warning) -> &'static str {
    match warning {
        Warning::Masses { .. } => "masses",
        Warning::Tethers { .. } => "tethers",
        Warning::Substeps { .. } => "substeps",
        Warning::Turns { .. } => "turns",
        Warning::Soft { .. } => "soft",
        Warning::Limp { .. } => "limp",
        Warning::Pyramid { .. } => "pyramid",
        _ => "other",
    }
}

/// The larger one; NaN is the largest.
fn worse(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

fn judge(case: &Case, tethers: bool, out: &mut Outcome) {
    // Written so that NaN fails.
    let within = |x: f64, most: f64| x.abs() < most;
    let mut fail = |words: String| out.failures.push(words);
    if let Some((frame, count)) = out.broke {
        let after = match out.mended {
            Some(mended) => format!(", mended after frame {mended}"),
            None => ", never mended".into(),
        };
        fail(format!("{count} not finite after frame {frame}{after}"));
    }
    let judged = match case.asked.stretch {
        Stretch::Judged | Stretch::OfLongest => true,
        Stretch::WithTethers => tethers,
        Stretch::Open => false,
    };
    if judged && !within(out.stretch, 0.05) {
        fail(format!("stretch {:+.3} %", 100.0 * out.stretch));
    }
    if case.asked.rest.is_some_and(|most| !within(out.rest, most)) {
        fail(format!("at rest {:.3} mm/s", out.rest));
    }
    if case.asked.drift && !within(out.drift, 1.0) {
        fail(format!("drift {:.3} mm", out.drift));
    }
    if case.asked.momentum && !within(out.momentum, 1e-4) {
        fail(format!("momentum {:.1e}", out.momentum));
    }
    if case.asked.energy && (out.energy > 0.01 || out.energy.is_nan()) {
        fail(format!("energy {:+.3} %", 100.0 * out.energy));
    }
}
