//! The settings of a stepper.

use crate::error::{Result, check};
use crate::quality::Quality;
use crate::tuning::Tuning;

/// Where the passes run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// The GPU if the host provides a device that passes its [`crate::self_check`], else the CPU.
    #[default]
    Auto,
    /// The GPU, also a device that fails its self-check; an error without a device.
    Gpu,
    /// The CPU. With a device too, positions are uploaded for drawing.
    Cpu,
}

/// The solver of springs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Solver {
    /// Verlet integration and relaxation in eight coloured passes, after C. Zeller, "Cloth Simulation on the GPU",
    /// SIGGRAPH 2005. The error falls with the square of the substeps; substeps do more than iterations. The baseline of
    /// comparisons: at the same error it takes three to ten times as long as `Xpbd`.
    Classic,
    /// Extended position-based dynamics: springs with a compliance in \[m/N\], one relaxation a substep, tethers to pins,
    /// swept contact. After M. Macklin, M. Mueller, N. Chentanez, "XPBD", MIG 2016, and M. Macklin et al., "Small Steps in
    /// Physics Simulation", SCA 2019.
    #[default]
    Xpbd,
}

/// Settings of a stepper.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Where the passes run. Default `Auto`.
    pub backend: Backend,
    /// The solver. Default `Xpbd`.
    pub solver: Solver,
    /// Time \[s\] of `substeps` steps, whatever the length of the host's frames. Default 1/60; 1e-6 to 1.
    pub step: f64,
    /// Number of steps in that time, each with all passes. Default `None`: chosen from the scene ([`crate::Choice`] has the
    /// rules). 1 to 4096; larger is stiffer, at proportional cost. If `quality` chooses the number, this is the initial one;
    /// [`crate::Stepper::substeps`] is the current one. Otherwise [`Solver::Xpbd`] uses enough substeps that no step is longer
    /// than [`crate::LONGEST`] (cloth without tethers: [`crate::LONGEST_FREE`]), with a warning
    /// ([`crate::Stepper::warnings`]). Steps below 1e-3 s at the start carry rounding errors over; below 1/16000 s cloth of a
    /// metre trembles in f32 nevertheless.
    pub substeps: Option<u32>,
    /// How the numbers of substeps and of rounds of polish are chosen from frame to frame. Default [`Quality::Fixed`].
    pub quality: Quality,
    /// Relaxations per step. Default 1; 1 to 4096; larger is stiffer and costs more, both less than with substeps. Membrane
    /// and bending of a [`crate::Material`] are always relaxed once per step: only substeps make them exact.
    pub iterations: u32,
    /// Most tethers of a particle, each to the nearest pin of another group of pins: no particle gets farther from its pins
    /// than along the surface. Default 4; 0 to 4; for [`Solver::Xpbd`] only. Cloth has no more than it has groups, two if these lie on a
    /// line, and one if it hangs from a row of pins with numbers that are chosen: further ones would hold nothing. They take most of the stretch away in few
    /// substeps, and shorten the period of a swing a little. Those of a bundle are used where they are enough, else they
    /// are found when the stepper is made ([`crate::Cloth::tethers`]). After a cut those stay whose way to the pin is whole, others grow to the way
    /// that is left ([`crate::Stepper::cut`]). Cloth of springs whose neighbours differ by more than [`crate::MOST_RATIO`] in
    /// mass or [`crate::MOST_LENGTHS`] in rest length gets 2 if 0 are requested, with a warning
    /// ([`crate::Stepper::warnings`]): springs alone do not hold it.
    pub tethers: u32,
    /// Further rounds of a relaxation: springs to the right and down, which stretch shows in, and not the
    /// diagonal ones, which take half of the time. Cloth in contact draws its tethers before each round, other cloth before the first
    /// and at the end. For [`Solver::Xpbd`] and cloth without a [`crate::Material`]; default
    /// `None`: chosen from the scene ([`crate::Choice`] has the rules), and then by [`Quality::Error`]
    /// ([`crate::Stepper::polish`] is the current number); 0 to 64. A number is kept. On tethers and without contact the first round
    /// takes about a third of a substep, each further one an eighth, as it does among several colliders. On
    /// cloth that lies on colliders, eight rounds leave a seventh of the stretch; cloth that hangs at rest by tethers needs one or two.
    pub polish: Option<u32>,
    /// Number of steps from one pass of length limits on coarser grids to the next, for [`Solver::Xpbd`]; 0 means never. Default
    /// 0; at most 4096. It keeps cloth together that no pin holds and that flies freely, and
    /// cloth that hangs at rest from points without tethers. Cloth that meets colliders has no such
    /// pass, because the limits ignore contact ([`crate::Warning::PyramidOnColliders`]), and a grid takes part only if it has a node at
    /// each group of pins that the cloth starts with ([`crate::Warning::PyramidOffPins`] if none has). Every other
    /// step is often enough: in every step, limits and springs work against one another, and cloth without damping takes up motion. No
    /// limit crosses a cut, and nothing is carried across one; both sides of a seam move alike on every grid; after a cut of
    /// any cloth only where both have a node at the same point.
    pub pyramid: u32,
    /// Distance \[m\] that particles keep from the surfaces of colliders. The particles are the middle of the cloth, so this is
    /// half its thickness, and keeps the drawn cloth outside of colliders. Default 0; 0 to 1; for cloth without a
    /// [`crate::Cloth::thickness`] of its own. Colliders grow by this amount, at no per-frame cost; a box stays a box,
    /// and an ellipsoid an ellipsoid.
    pub thickness: f32,
    /// Whether normals are computed at the end of a frame. Default true.
    pub normals: bool,
    /// Largest number of `step` times that one frame catches up; further time is dropped. Default 4; 1 to 1024.
    pub max_catch_up: u32,
    /// Number of threads of the CPU backend: 0 means one per core, 1 only the caller's. Default 0; at most 1024. Results do not depend on it. They
    /// share the rows of large cloths, of springs under [`Solver::Xpbd`] from some 300 x 300 particles on.
    pub threads: usize,
    /// Whether, on the GPU, cloths run their whole frame in one dispatch where they can: with [`Solver::Xpbd`], a size that
    /// fits the memory of a workgroup, and no [`crate::Cloth::contact`]. A frame with much work is more than one dispatch: 2^21 relaxations of a particle
    /// each, rounds of polishing included, or fewer on a software adapter; a cloth of which one step is more has no whole frames. Other
    /// cloth of that solver runs as many consecutive passes of a step in one dispatch as wait for nothing but their neighbours, by tiles
    /// (see [`crate::Tile`]): from the integration to the contact, or from the seams of a step to those of the next. Cloths whose frames
    /// have the same passes share these dispatches, cut ones only those of whole frames, and none with a pyramid. Tiles take 32 bytes per particle more, 16 more
    /// where steps are below 1e-3 s, and 16 more where springs with compliance are relaxed several times a step.
    /// Default true; results are those of separate passes. [`crate::device_limits`] asks for the room it takes.
    pub fused: bool,
    /// When cloth falls asleep automatically. Default none, at no cost.
    pub sleep: Option<Sleep>,
    /// Sizes of workgroups and of tiles on the GPU, as [`crate::Stepper::tune`] measures them. Default `None`: from the limits of the
    /// device. Results do not depend on them.
    pub tuning: Option<Tuning>,
}

/// Conditions for a cloth to fall asleep. It wakes when it is changed, when gravity or wind changes, and when a collider may touch
/// it on its path; such a collider also starts the time of rest again. In wind it never falls asleep. On the GPU backend a cloth
/// among colliders costs two more dispatches each time it comes to rest, for the box around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sleep {
    /// Largest speed \[m/s\] of a particle at rest. Default 0.005; above 0; larger lets cloth sleep sooner, and freezes slow
    /// motion.
    pub speed: f64,
    /// Time \[s\] below that speed. Default 1; at least 0; larger lets cloth sleep later, and excludes slow reversals.
    pub after: f64,
}

impl Default for Sleep {
    fn default() -> Self {
        Sleep { speed: 0.005, after: 1.0 }
    }
}

impl Default for Options {
    fn default() -> Self {
        let (backend, solver) = (Backend::default(), Solver::default());
        Options {
            backend,
            solver,
            step: 1.0 / 60.0,
            substeps: None,
            quality: Quality::default(),
            iterations: 1,
            tethers: 4,
            polish: None,
            pyramid: 0,
            thickness: 0.0,
            normals: true,
            max_catch_up: 4,
            threads: 0,
            fused: true,
            sleep: None,
            tuning: None,
        }
    }
}

impl Options {
    /// Refuses numbers outside their ranges.
    pub fn check(&self) -> Result<()> {
        check("the step [s]", self.step, "1e-6 to 1", |s| (1e-6..=1.0).contains(&s))?;
        let count = |n: f64| (1.0..=4096.0).contains(&n);
        check("the number of substeps", self.substeps.unwrap_or(1).into(), "1 to 4096", count)?;
        check("the number of iterations", self.iterations.into(), "1 to 4096", count)?;
        check("the number of tethers", self.tethers.into(), "0 to 4", |n| n <= 4.0)?;
        check("the number of polishing rounds", self.polish.unwrap_or(0).into(), "0 to 64", |n| n <= 64.0)?;
        check("the number of steps between pyramids", self.pyramid.into(), "0 to 4096", |n| n <= 4096.0)?;
        check("the thickness [m]", self.thickness.into(), "0 to 1", |t| (0.0..=1.0).contains(&t))?;
        let catch_up = |n: f64| (1.0..=1024.0).contains(&n);
        check("the largest number of steps caught up", self.max_catch_up.into(), "1 to 1024", catch_up)?;
        check("the number of threads", self.threads as f64, "0 to 1024", |n| n <= 1024.0)?;
        self.quality.check()?;
        if let Some(Sleep { speed, after }) = self.sleep {
            check("the speed of sleep [m/s]", speed, "above 0", |s| s > 0.0)?;
            check("the time before sleep [s]", after, "at least 0", |t| t >= 0.0)?;
        }
        Ok(())
    }
}
