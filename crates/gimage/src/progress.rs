//! Progress of a build, and its cancellation.

/// The stages of a build, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// Fitting solids to the body, of [`crate::pipeline::dress`] alone.
    Colliders,
    /// Reading the file.
    Import,
    /// Repairing the mesh to a manifold.
    Repair,
    /// Opening caps, and making one layer of each thin shell.
    Shell,
    /// Separating pieces from accessories.
    Component,
    /// Cutting, laying out, parameterising and resampling; one step a piece.
    Image,
    /// Attributes, springs, masses, pins; one step a piece.
    Maps,
    /// Tying pieces together.
    Stitch,
    /// Measuring the result against the source.
    Measure,
    /// Binding the mesh of the source to the pieces.
    Render,
    /// Compressing and hashing.
    Encode,
}

impl Stage {
    /// Its name, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Colliders => "colliders",
            Stage::Import => "import",
            Stage::Repair => "repair",
            Stage::Shell => "shell",
            Stage::Component => "component",
            Stage::Image => "image",
            Stage::Maps => "maps",
            Stage::Stitch => "stitch",
            Stage::Measure => "measure",
            Stage::Render => "render",
            Stage::Encode => "encode",
        }
    }
}

/// Receives the progress of a build. All methods may be called from any thread.
pub trait Progress: Sync {
    /// A stage begins, of `steps` steps.
    fn begin(&self, stage: Stage, steps: u64) {
        let _ = (stage, steps);
    }
    /// One step of the stage is done.
    fn step(&self, stage: Stage) {
        let _ = stage;
    }
    /// Asked between steps; `true` ends the build with [`crate::Error::Cancelled`].
    fn cancelled(&self) -> bool {
        false
    }
}

/// Ignores progress.
#[derive(Clone, Copy, Debug, Default)]
pub struct Quiet;

impl Progress for Quiet {}
