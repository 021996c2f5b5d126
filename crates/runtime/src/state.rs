//! The state of a cloth in motion: everything from which a stepper continues with the same bits.

mod bytes;
mod layout;
mod snapshot;

pub(crate) use layout::{Layout, Part};
pub(crate) use snapshot::ControlState;
pub use snapshot::Snapshot;

use std::sync::Arc;

use bytemuck::cast_slice;

use crate::cloth::{Cloth, Rest, Tethers};
use crate::error::{Error, Result, StateProblem};
use crate::scene::Pose;

/// The state of a cloth between two frames, as plain arrays.
///
/// It has everything that a continuation with the same bits needs: positions now and one step before, the frame to return
/// to after a fault, the low bits that positions of a material are too coarse for, holes, rest lengths and tethers after cuts,
/// pins, and whether the cloth is asleep. It has neither the description of the cloth (grids, masses, seams, material) nor
/// colliders, wind and settings: the scene has them. [`Snapshot`] holds all cloths, and the clock.
///
/// 48 bytes per particle, 64 of a material; a cut adds 20, and 8 per tether. Copies of a state share them.
///
/// ```
/// use gimage_runtime::{ClothState, Flat, Options, Scene, Stepper};
///
/// let mut scene = Scene::new("falling");
/// scene.cloths.push(Flat::square("square", 9).cloth()?);
/// let mut stepper = Stepper::on_cpu(scene, Options::default())?;
/// stepper.advance(0.5)?;
/// let saved = stepper.state(0)?.to_bytes();
/// stepper.advance(0.5)?;
/// let fallen = stepper.positions(0).unwrap_or_default().to_vec();
///
/// let state = ClothState::from_bytes(&saved)?;
/// assert!(state.velocities()[40][1] < -0.1);
/// stepper.set_state(0, &state)?;
/// stepper.advance(0.5)?;
/// assert_eq!(stepper.positions(0).unwrap_or_default(), fallen);
/// # Ok::<(), gimage_runtime::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ClothState {
    pub(crate) head: Head,
    /// The parts of `head.layout`, one after the other.
    words: Arc<Vec<u32>>,
}

/// A state without its lists.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Head {
    /// Columns and rows of each grid.
    pub grids: Vec<[u32; 2]>,
    /// Length of the step between the previous positions and the positions \[s\].
    pub step: f64,
    pub asleep: bool,
    /// For how long it has been calm \[s\].
    pub calm: f64,
    /// Where teleports have moved the start.
    pub home: Pose,
    pub layout: Layout,
}

impl ClothState {
    pub(crate) fn new(head: Head, words: Vec<u32>) -> Self {
        ClothState { head, words: Arc::new(words) }
    }

    fn list(&self, part: Part) -> &[[f32; 4]] {
        cast_slice(&self.words[self.head.layout.range(part)])
    }

    /// Positions \[m\], one per texel of every grid; the fourth component is 1/mass, 0 for pinned, -1 for no particle.
    pub fn positions(&self) -> &[[f32; 4]] {
        self.list(Part::Now)
    }

    /// Positions one step before, in the same order.
    pub fn previous(&self) -> &[[f32; 4]] {
        self.list(Part::Before)
    }

    /// The length of that step \[s\].
    pub fn step(&self) -> f64 {
        self.head.step
    }

    /// Velocities \[m/s\] in the same order: displacement in the last step over its length; 0 where there is no particle.
    pub fn velocities(&self) -> Vec<[f32; 3]> {
        let of = |(p, b): (&[f32; 4], &[f32; 4])| match p[3] >= 0.0 {
            true => [0, 1, 2].map(|c| ((f64::from(p[c]) - f64::from(b[c])) / self.head.step) as f32),
            false => [0.0; 3],
        };
        self.positions().iter().zip(self.previous()).map(of).collect()
    }

    /// Triangles that cuts have taken away, as [`crate::ClothBuffers::holes`]; `None` for cloth that was never cut.
    pub fn holes(&self) -> Option<&[u32]> {
        self.head.layout.cut.then(|| &self.words[self.head.layout.range(Part::Holes)])
    }

    /// Whether the cloth is asleep.
    pub fn is_asleep(&self) -> bool {
        self.head.asleep
    }

    /// Replaces positions \[m\] and velocities \[m/s\], one each per texel of every grid; where there is no particle they
    /// have no meaning. Pins stay. The cloth is awake from here on. Duplicates of a seam particle should agree: the next
    /// step joins them. Errors on lists of another length.
    pub fn set_motion(&mut self, positions: &[[f32; 3]], velocities: &[[f32; 3]]) -> Result<()> {
        let expected = self.head.layout.particles;
        for (what, found) in [("positions", positions.len()), ("velocities", velocities.len())] {
            if found != expected {
                return Err(Error::Length { cloth: "of the state".into(), what, found, expected });
            }
        }
        let Head { layout, step, .. } = self.head;
        let (now, before) = (layout.range(Part::Now), layout.range(Part::Before));
        let words = Arc::make_mut(&mut self.words);
        for (k, (p, v)) in positions.iter().zip(velocities).enumerate() {
            for c in 0..3 {
                let was = f64::from(p[c]) - f64::from(v[c]) * step;
                words[now.start + 4 * k + c] = p[c].to_bits();
                words[before.start + 4 * k + c] = (was as f32).to_bits();
            }
        }
        let good = layout.range(Part::Good);
        if !good.is_empty() {
            words.copy_within(now, good.start);
        }
        words[layout.range(Part::Lost)].fill(0);
        (self.head.asleep, self.head.calm) = (false, 0.0);
        Ok(())
    }

    /// The pinned particles.
    pub(crate) fn pinned(&self) -> Vec<u32> {
        let positions = self.positions();
        (0..positions.len() as u32).filter(|k| positions[*k as usize][3] == 0.0).collect()
    }

    /// Refuses what a cloth with these tethers cannot take.
    pub(crate) fn check(&self, cloth: &Cloth, tethers: &Tethers) -> Result<()> {
        self.head.check(cloth, tethers)?;
        let particles = cloth.particles().iter().zip(self.positions());
        if let Some(index) = particles.clone().position(|(p, at)| p.exists() != (at[3] >= 0.0)) {
            return Err(Error::State { cloth: cloth.name().into(), problem: StateProblem::Particle { index } });
        }
        let parts = [
            (Part::Now, "position"),
            (Part::Before, "previous position"),
            (Part::Good, "last good position"),
            (Part::Lost, "low bits of the position"),
        ];
        for (part, what) in parts {
            let wrong = |(p, at): (&crate::Particle, &[f32; 4])| p.exists() && !at[..3].iter().all(|x| x.is_finite());
            let all = cloth.particles().iter().zip(self.list(part));
            if let Some((index, _)) = all.enumerate().find(|(_, pair)| wrong(*pair)) {
                return Err(Error::NotFinite { cloth: cloth.name().into(), what, index });
            }
        }
        if let Some(index) = self.list(Part::Rest).iter().position(|rest| !rest.iter().all(|x| x.is_finite())) {
            return Err(Error::NotFinite { cloth: cloth.name().into(), what: "rest length", index });
        }
        let held: &[[u32; 2]] = cast_slice(&self.words[self.head.layout.range(Part::Tethers)]);
        let missing = |anchor: u32| anchor != u32::MAX && anchor as usize >= cloth.len();
        if let Some(n) = held.iter().position(|[anchor, _]| missing(*anchor)) {
            let index = n / self.head.layout.slots;
            return Err(Error::State { cloth: cloth.name().into(), problem: StateProblem::Anchor { index } });
        }
        Ok(())
    }

    /// The lists in another layout, with these inverse masses, for a stepper whose last step took `step` \[s\]. A part that the
    /// state lacks begins as that of a cloth at rest.
    pub(crate) fn fit(&self, layout: &Layout, inverse_masses: &[f32], step: f64) -> Vec<u32> {
        let (now, before) = (self.positions(), self.previous());
        let mut words = Vec::with_capacity(layout.words());
        for part in Part::ALL.iter().filter(|part| !layout.range(**part).is_empty()) {
            let own = &self.words[self.head.layout.range(*part)];
            match part {
                Part::Now | Part::Before => {
                    let scaled = self.head.step != step && *part == Part::Before;
                    for (k, w) in inverse_masses.iter().enumerate() {
                        let [x, y, z, _] = if scaled {
                            let by = |c: usize| f64::from(now[k][c]) - f64::from(before[k][c]);
                            let was = |c: usize| (f64::from(now[k][c]) - by(c) * step / self.head.step) as f32;
                            [was(0), was(1), was(2), 0.0]
                        } else {
                            if *part == Part::Now { now[k] } else { before[k] }
                        };
                        words.extend([x, y, z, *w].map(f32::to_bits));
                    }
                }
                Part::Good if own.is_empty() => words.extend_from_slice(&self.words[self.head.layout.range(Part::Now)]),
                _ if own.is_empty() => words.resize(words.len() + layout.range(*part).len(), 0),
                _ => words.extend_from_slice(own),
            }
        }
        words
    }
}

impl Head {
    /// Refuses what a cloth with these tethers cannot take.
    pub fn check(&self, cloth: &Cloth, tethers: &Tethers) -> Result<()> {
        let refuse = |problem| Err(Error::State { cloth: cloth.name().into(), problem });
        let grids: Vec<_> = cloth.grids().iter().map(|g| [g.width, g.height]).collect();
        let list = |grids: &[[u32; 2]]| {
            let sizes: Vec<_> = grids.iter().map(|[w, h]| format!("{w} x {h}")).collect();
            sizes.join(", ")
        };
        if self.grids != grids {
            return refuse(StateProblem::Grids { found: list(&self.grids), expected: list(&grids) });
        }
        let rest = !matches!(cloth.rest(), Rest::None);
        let slots = if rest { tethers.per_particle } else { 0 };
        match self.layout {
            Layout { cut: true, rest: found, .. } if found != rest => refuse(StateProblem::Springs),
            Layout { cut: true, slots: found, .. } if found != slots => {
                refuse(StateProblem::Tethers { found, expected: slots })
            }
            _ => Ok(()),
        }
    }
}
