//! Reports the faults of a run, such as overflows, at its end; the exit code is then 1.

use std::collections::BTreeMap;

use gimage_runtime::{Fate, Finding, Health};
use serde_json::{Value, json};

use crate::commands::crossed::Crossed;
use crate::commands::engine::Engine;
use crate::exit::{Exit, Failure};
use crate::output::{Output, Tone};

/// Coordinates \[m\] beyond this count as an overflow, as in the runtime.
const FARTHEST: f32 = 1e8;

/// Extension of one spring in a hundred from which on triangles that cross are not counted.
const TORN_P99: f64 = 2.0;

/// Whether a particle has a position that is not finite or too far away.
pub fn is_lost(p: &[f32; 4]) -> bool {
    p[3] >= 0.0 && !p[..3].iter().all(|x| x.abs() <= FARTHEST)
}

/// Failures of one cloth.
#[derive(Clone, Debug, Default, PartialEq)]
struct Fault {
    /// Frames that the solver took back.
    frames: u64,
    /// End of the first of them \[s\]; not known on the GPU.
    first: Option<f64>,
    /// A particle at fault.
    particle: usize,
    /// Positions at the end that are not finite or too far away. The solver `xpbd` leaves none.
    lost: usize,
}

/// The faults of a run, by cloth.
#[derive(Debug, Default)]
pub struct Faults {
    of: BTreeMap<usize, Fault>,
    /// Findings of the stepper.
    findings: Vec<Finding>,
    /// Figures of each cloth at the end.
    pub health: Vec<Health>,
    /// Cloth that crosses at the end.
    pub crossed: Crossed,
}

impl Faults {
    /// Takes in what the last frame brought; call it after every frame.
    pub fn after_frame(&mut self, engine: &mut Engine) {
        for fault in engine.stepper.take_faults() {
            let entry = self.of.entry(fault.cloth).or_default();
            entry.frames += 1;
            entry.first.get_or_insert(fault.time);
            entry.particle = fault.particle;
        }
    }

    /// Looks at the cloths as they are at the end.
    pub fn at_end(&mut self, engine: &mut Engine) -> Result<(), Failure> {
        self.health = engine.examine()?;
        self.findings = engine.stepper.findings().to_vec();
        for cloth in 0..engine.stepper.scene().cloths.len() {
            if let Some((frames, particle)) = engine.taken_back(cloth)?.filter(|f| f.0 > 0) {
                let entry = self.of.entry(cloth).or_default();
                (entry.frames, entry.particle) = (frames, particle);
            }
            let positions = engine.positions(cloth)?;
            let lost = positions.iter().filter(|p| is_lost(p)).count();
            if let Some(first) = positions.iter().position(is_lost) {
                let entry = self.of.entry(cloth).or_default();
                (entry.lost, entry.particle) = (lost, first);
            }
        }
        // All triangles of cloth that is torn out of shape overlap.
        let is_torn = |health: &Health| health.stretch.is_some_and(|stretch| stretch.p99 > TORN_P99);
        if self.of.is_empty() && !self.health.iter().any(is_torn) {
            self.crossed = Crossed::at_end(engine)?;
        }
        Ok(())
    }

    /// How the run ends.
    pub fn exit(&self) -> Exit {
        if self.of.is_empty() && self.findings.is_empty() { Exit::Done } else { Exit::Findings }
    }

    /// One warning on stderr per cloth and finding, and a note of cloth that crosses; `frames` is how many there were.
    pub fn warn(&self, out: &Output, engine: &Engine, frames: usize) {
        for (&cloth, fault) in &self.of {
            let cloths = &engine.stepper.scene().cloths;
            let name = cloths.get(cloth).map_or("", |c| c.name());
            out.remark(Tone::Warning, "warning", &words(name, fault, frames));
        }
        self.findings.iter().for_each(|finding| out.remark(Tone::Warning, "warning", &finding.to_string()));
        self.crossed.words(engine.stepper.scene()).iter().for_each(|text| out.remark(Tone::Note, "note", text));
    }

    /// Kinds of findings of a cloth.
    pub fn count(&self, cloth: usize) -> usize {
        self.findings.iter().filter(|f| f.cloth == cloth).count() + usize::from(self.of.contains_key(&cloth))
    }

    /// The findings for `--json`.
    pub fn findings(&self) -> Value {
        let entry = |f: &Finding| {
            let kind = match f.fate {
                Fate::Stretched { .. } => "stretched",
                Fate::Left => "left",
                Fate::Falls => "falls",
                Fate::Tunnelled { .. } => "tunnelled",
                Fate::Crossed { .. } => "crossed",
                Fate::Slowed { .. } => "slowed",
                Fate::Squeezed { .. } => "squeezed",
                Fate::Thrown { .. } => "thrown",
                _ => "other",
            };
            let (piece, texel) = (f.place.as_ref().map(|p| &p.piece), f.place.as_ref().map(|p| p.texel));
            json!({"cloth": f.cloth, "piece": piece, "texel": texel, "time_s": f.time, "kind": kind, "text": f.to_string()})
        };
        self.findings.iter().map(entry).collect()
    }

    /// The same for `--json`.
    pub fn json(&self) -> Value {
        let entry = |(cloth, f): (&usize, &Fault)| {
            json!({"cloth": cloth, "frames_taken_back": f.frames, "first_s": f.first, "particle": f.particle,
                   "positions_not_finite": f.lost})
        };
        self.of.iter().map(entry).collect()
    }
}

fn words(name: &str, fault: &Fault, frames: usize) -> String {
    let hint = "use more --substeps, or smaller forces, speeds and stiffnesses";
    let &Fault { frames: back, first, particle, lost } = fault;
    if lost > 0 {
        let what = if lost == 1 { "position is" } else { "positions are" };
        return format!(
            "cloth '{name}': {lost} {what} not finite or farther than 1e8 m away at the end, for example that of particle {particle}; \
             {hint}, or use --solver xpbd, which contains overflows"
        );
    }
    let since = first.map_or_else(String::new, |t| format!(", the first at {t:.3} s"));
    format!(
        "cloth '{name}': {back} of {frames} frames overflowed{since}, for example at particle {particle}, and were taken back: the \
         cloth stands still in them; {hint}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_names_the_cloth_the_particle_and_the_way_out() {
        let held = Fault { frames: 600, first: Some(1.0 / 60.0), particle: 7, lost: 0 };
        let text = words("flag", &held, 600);
        assert!(text.contains("'flag': 600 of 600 frames") && text.contains("0.017 s") && text.contains("particle 7"));
        let text = words("flag", &Fault { lost: 1, ..held }, 600);
        assert!(text.contains("1 position is not finite") && text.contains("--solver xpbd"), "{text}");
    }
}
