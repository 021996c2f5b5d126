//! The solvers that are compared.

use gimage_runtime::{Options, Solver};

/// A solver with its settings.
#[derive(Clone, Copy)]
pub struct Variant {
    /// Its name in the table.
    pub name: &'static str,
    /// Which.
    pub solver: Solver,
    /// Tethers of a particle.
    pub tethers: u32,
    /// Steps from one run of the pyramid to the next; 0 is none.
    pub pyramid: u32,
}

/// All of them; a line in the plot each.
pub const VARIANTS: [Variant; 4] = [
    Variant { name: "classic", solver: Solver::Classic, tethers: 0, pyramid: 0 },
    Variant { name: "xpbd", solver: Solver::Xpbd, tethers: 0, pyramid: 0 },
    Variant { name: "xpbd+tethers", solver: Solver::Xpbd, tethers: 2, pyramid: 0 },
    Variant { name: "xpbd+pyramid", solver: Solver::Xpbd, tethers: 0, pyramid: 2 },
];

impl Variant {
    /// The settings for a number of substeps; what is not said here is as in `base`.
    pub fn options(&self, substeps: u32, base: &Options) -> Options {
        Options { solver: self.solver, tethers: self.tethers, pyramid: self.pyramid, substeps, ..base.clone() }
    }

    /// Whether a scene shows it: the classic solver knows no compliance, and what falls freely has no tethers,
    /// and a pyramid of limits knows no compliance either.
    pub fn can(&self, scene: &str) -> bool {
        let (soft, free) = (scene == "s1k", scene.starts_with("s2"));
        !(soft && self.solver == Solver::Classic || free && self.tethers > 0 || soft && self.pyramid > 0)
    }
}
