//! A disturbance, and what is asked of the cloth after it.

use gimage_runtime::{Cloth, Compliance, Flat, Options, Result, Scene, Solver, Stepper};

/// A solver that is tried.
#[derive(Clone, Copy)]
pub struct Tried {
    pub name: &'static str,
    pub solver: Solver,
    /// Tethers per particle.
    pub tethers: u32,
}

/// All of them.
pub const SOLVERS: [Tried; 3] = [
    Tried { name: "classic", solver: Solver::Classic, tethers: 0 },
    Tried { name: "xpbd", solver: Solver::Xpbd, tethers: 0 },
    Tried { name: "xpbd+tethers", solver: Solver::Xpbd, tethers: 2 },
];

/// For which solvers stretch is judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stretch {
    /// All.
    Judged,
    /// All, but against the longest spring at either end: for springs of very different lengths.
    OfLongest,
    /// Only with tethers: without them, so few steps cannot do it in any implementation.
    WithTethers,
    /// None: the material itself is longer, or the number format cannot hold the lengths.
    Open,
}

/// Requirements of a case, beyond that every position is finite throughout.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// The structural springs are within 5 % of their lengths 2 s after the disturbance.
    pub stretch: Stretch,
    /// RMS speed \[mm/s\] below this in the last second.
    pub rest: Option<f64>,
    /// No particle moves more than 1 mm between the second 15 of calm and the end.
    pub drift: bool,
    /// Momentum kept to 1e-4 of mass times RMS speed.
    pub momentum: bool,
    /// Energy never more than 1 % above the start, in units of weight times size, or of the energy at the start.
    pub energy: bool,
}

type Before = Box<dyn Fn(&mut Stepper, u32) -> Result<()>>;
type Once = Box<dyn Fn(&mut Stepper) -> Result<()>>;

/// A scene, what happens to it, and what is asked.
pub struct Case {
    pub name: String,
    pub scene: Scene,
    /// Time of a frame \[s\].
    pub step: f64,
    pub substeps: u32,
    /// How long it is disturbed \[s\].
    pub storm: f64,
    /// Before each frame of the storm, with its number.
    pub during: Before,
    /// When the storm ends.
    pub after: Once,
    /// How long it is left alone \[s\].
    pub calm: f64,
    pub asked: Asked,
    /// Whether it steps by itself, which only the CPU backend can.
    pub cpu_only: bool,
}

impl Case {
    /// A scene that is left alone for 15 s, 32 steps in each 1/60 s, and shall then be unstretched and at rest.
    pub fn new(name: impl Into<String>, scene: Scene) -> Self {
        let asked = Asked { stretch: Stretch::Judged, rest: Some(1.0), drift: false, momentum: false, energy: false };
        Case {
            name: name.into(),
            scene,
            step: 1.0 / 60.0,
            substeps: 32,
            storm: 0.0,
            during: Box::new(|_, _| Ok(())),
            after: Box::new(|_| Ok(())),
            calm: 15.0,
            asked,
            cpu_only: false,
        }
    }

    /// Disturbed for some seconds, before each frame.
    pub fn storm(self, seconds: f64, during: impl Fn(&mut Stepper, u32) -> Result<()> + 'static) -> Self {
        Case { storm: seconds, during: Box::new(during), ..self }
    }

    /// Sets the end of the disturbance.
    pub fn after(self, after: impl Fn(&mut Stepper) -> Result<()> + 'static) -> Self {
        Case { after: Box::new(after), ..self }
    }

    /// Other stretch asked.
    pub fn stretch(mut self, stretch: Stretch) -> Self {
        self.asked.stretch = stretch;
        self
    }

    /// The settings under a solver.
    pub fn options(&self, tried: Tried) -> Options {
        let Tried { solver, tethers, .. } = tried;
        Options {
            solver,
            tethers,
            step: self.step,
            substeps: Some(self.substeps),
            normals: false,
            threads: 1,
            ..Options::default()
        }
    }

    /// Whether a solver has anything of its own to show: compliance is for XPBD, tethers are for pinned cloth.
    pub fn tries(&self, tried: Tried) -> bool {
        let Tried { solver, tethers, .. } = tried;
        let soft = self.scene.cloths.iter().any(|c| c.compliance != Compliance::None);
        let pinned = self.scene.cloths.iter().any(|c| c.particles().iter().any(|p| p.is_pinned()));
        !(soft && solver == Solver::Classic || tethers > 0 && !pinned)
    }
}

/// Particles along a side.
pub const N: usize = 17;

/// A horizontal square of 1 m and 0.2 kg, damped at 2 /s, all free.
pub fn sheet() -> Result<Cloth> {
    let mut cloth = Flat::square("cloth", N as u32).cloth()?;
    cloth.damping = 2.0;
    Ok(cloth)
}

/// The same, held by two corners.
pub fn flag() -> Result<Cloth> {
    held(sheet()?)
}

/// Held by the ends of its first row.
pub fn held(mut cloth: Cloth) -> Result<Cloth> {
    cloth.set_pinned(0, true)?;
    cloth.set_pinned(N - 1, true)?;
    Ok(cloth)
}

/// Held by two corners and hanging already.
pub fn hanging(size: f32) -> Result<Cloth> {
    let flat = Flat { right: [size, 0.0, 0.0], down: [0.0, -size, 0.0], ..Flat::square("cloth", N as u32) };
    let mut cloth = held(flat.cloth()?)?;
    cloth.damping = 2.0;
    Ok(cloth)
}

/// One cloth under the earth's gravity.
pub fn scene(cloth: Cloth) -> Scene {
    Scene { cloths: vec![cloth], ..Scene::new("stress") }
}

/// The same with other settings.
pub fn tuned(mut cloth: Cloth, set: impl FnOnce(&mut Cloth)) -> Cloth {
    set(&mut cloth);
    cloth
}
