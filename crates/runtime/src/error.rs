//! Why a cloth could not be made, or a stepper could not run.

use gimage_bundle::LinkFault;

/// The names of the built-in scenes, which an error lists.
pub const BUILTIN: [&str; 5] = ["s1", "s1k", "s2", "s2f", "s3"];

/// The result of a call into the runtime.
pub type Result<T> = std::result::Result<T, Error>;

/// An error: what went wrong, where, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A bundle could not be understood.
    #[error(transparent)]
    Bundle(#[from] gimage_bundle::Error),
    /// A list does not have one entry per particle.
    #[error("cloth {cloth}: {found} {what} for {expected} particles; give one for each texel of every grid")]
    Length {
        /// The cloth by name.
        cloth: String,
        /// What is counted.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// A grid has no spring, or more texels than a bundle may have.
    #[error("cloth {cloth}: grid {grid} of {width} x {height} texels: {problem}")]
    Grid {
        /// The cloth by name.
        cloth: String,
        /// Index of the grid.
        grid: usize,
        /// Texels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// What is wrong.
        problem: &'static str,
    },
    /// A value of a particle makes no sense.
    #[error("cloth {cloth}: particle {index}: {problem}; build the bundle again")]
    Particle {
        /// The cloth by name.
        cloth: String,
        /// Index of the particle.
        index: usize,
        /// What is wrong.
        problem: &'static str,
    },
    /// A seam link does not close a ring.
    #[error("cloth {cloth}: particle {index}: faulty seam link ({fault:?}); `gimage validate` lists all of them")]
    Seam {
        /// The cloth by name.
        cloth: String,
        /// Index of the particle.
        index: u32,
        /// What is wrong with its link.
        fault: LinkFault,
    },
    /// A setting is outside its range.
    #[error("{what} is {value}; it must be {range}")]
    Setting {
        /// The setting.
        what: &'static str,
        /// What was given.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// No such cloth, particle or collider.
    #[error("there is no {what} {index}; there are {count}")]
    NoSuch {
        /// What was asked for.
        what: &'static str,
        /// Its index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// No such built-in scene.
    #[error("there is no scene {0:?}; built in are {list}", list = BUILTIN.join(", "))]
    NoScene(String),
    /// The call needs a device, and the stepper has none.
    #[error("{0} needs a GPU; none was given (install a Vulkan driver, such as mesa-vulkan-drivers, or use the CPU)")]
    NoGpu(&'static str),
    /// The call is only for the CPU backend.
    #[error("{0} is for the CPU backend; on the GPU use Stepper::record and submit the encoder")]
    GpuOnly(&'static str),
    /// A cloth does not fit the limits of the device.
    #[error("cloth {cloth}: its {buffer} takes {need} bytes, the device allows {limit}; split it or use the CPU")]
    Limit {
        /// The cloth by name.
        cloth: String,
        /// The buffer.
        buffer: &'static str,
        /// Bytes needed.
        need: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// A buffer could not be read back.
    #[error("reading back from the GPU failed: {0}")]
    ReadBack(String),
    /// Threads could not be started.
    #[error("no threads: {0}; ask for 1 thread")]
    Threads(String),
}

/// An error unless `value` is finite and `ok` holds.
pub(crate) fn check(what: &'static str, value: f64, range: &'static str, ok: impl Fn(f64) -> bool) -> Result<()> {
    if value.is_finite() && ok(value) { Ok(()) } else { Err(Error::Setting { what, value, range }) }
}
