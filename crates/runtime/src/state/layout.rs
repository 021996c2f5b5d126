//! How the lists of a state lie one after the other, in memory, in files and in buffers of the GPU.

use std::ops::Range;

use crate::cloth::{Cloth, Rest, Tethers};
use crate::options::Solver;

/// A list of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Positions, the fourth component the inverse mass.
    Now,
    /// Positions one step before.
    Before,
    /// Positions at the end of the last good frame.
    Good,
    /// The low bits that positions are too coarse for.
    Lost,
    /// Triangles that are cut away.
    Holes,
    /// Rest lengths that cuts have left.
    Rest,
    /// Pin and length of each tether that cuts have left.
    Tethers,
}

impl Part {
    pub const ALL: [Part; 7] =
        [Part::Now, Part::Before, Part::Good, Part::Lost, Part::Holes, Part::Rest, Part::Tethers];
}

/// Which parts there are, in the order of [`Part::ALL`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    pub particles: usize,
    pub good: bool,
    pub lost: bool,
    /// Whether the cloth was cut: only then are there holes, and the parts below.
    pub cut: bool,
    pub rest: bool,
    /// Tethers per particle that follow cuts.
    pub slots: usize,
}

impl Layout {
    /// The layout of a cloth as it is now.
    pub fn of(cloth: &Cloth, tethers: &Tethers, solver: Solver) -> Self {
        let good = solver == Solver::Xpbd;
        let rest = cloth.is_cut() && !matches!(cloth.rest(), Rest::None);
        Layout {
            particles: cloth.len(),
            good,
            lost: good && cloth.is_exact(),
            cut: cloth.is_cut(),
            rest,
            slots: if rest { tethers.per_particle } else { 0 },
        }
    }

    /// Words of 32 bits per particle.
    fn each(&self, part: Part) -> usize {
        match part {
            Part::Now | Part::Before => 4,
            Part::Good => 4 * usize::from(self.good),
            Part::Lost => 4 * usize::from(self.lost),
            Part::Holes => usize::from(self.cut),
            Part::Rest => 4 * usize::from(self.rest),
            Part::Tethers => 2 * self.slots,
        }
    }

    /// Where a part lies, in words; empty where there is none.
    pub fn range(&self, part: Part) -> Range<usize> {
        let before = Part::ALL.iter().take_while(|p| **p != part);
        let first = before.map(|p| self.each(*p)).sum::<usize>() * self.particles;
        first..first + self.each(part) * self.particles
    }

    /// Words of all parts.
    pub fn words(&self) -> usize {
        self.range(Part::Tethers).end
    }
}
