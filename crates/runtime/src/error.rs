//! Why a cloth could not be made, or a stepper could not run.

use gimage_bundle::LinkFault;

use crate::handle::ClothHandle;

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
    #[error("cloth {cloth}: {found} {what} for {expected} particles; give one for each")]
    Length {
        /// The cloth by name.
        cloth: String,
        /// The kind of thing that is counted.
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
        /// The problem.
        problem: &'static str,
    },
    /// A value of a particle makes no sense.
    #[error("cloth {cloth}: particle {index}: {problem}; build the bundle again")]
    Particle {
        /// The cloth by name.
        cloth: String,
        /// Index of the particle.
        index: usize,
        /// The problem.
        problem: &'static str,
    },
    /// A seam link does not close a ring.
    #[error("cloth {cloth}: particle {index}: faulty seam link ({fault:?}); `gimage validate` lists all of them")]
    Seam {
        /// The cloth by name.
        cloth: String,
        /// Index of the particle.
        index: u32,
        /// The fault of its link.
        fault: LinkFault,
    },
    /// A setting is outside its range.
    #[error("{what} is {value}; it must be {range}")]
    Setting {
        /// The setting.
        what: &'static str,
        /// The value that was given.
        value: f64,
        /// The range that is allowed.
        range: &'static str,
    },
    /// No such cloth, particle or collider.
    #[error("there is no {what} {index}; there are {count}")]
    NoSuch {
        /// Its kind: a cloth, a particle, a collider.
        what: &'static str,
        /// The index that was given.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// The cloth of a handle is gone.
    #[error(
        "no cloth has the handle {0:?}: it was removed, or belongs to another stepper; drop the handle with its cloth"
    )]
    NoCloth(ClothHandle),
    /// An option cannot change while a stepper runs.
    #[error(
        "Options::{option} cannot change while a stepper runs; keep the value of Stepper::options, or make another stepper"
    )]
    FixedOption {
        /// The field of [`crate::Options`].
        option: &'static str,
    },
    /// A render mesh is bound to another cloth.
    #[error(
        "cloth {cloth}: the render mesh is bound to {expected} texels, the cloth has {found}; give the mesh of the bundle that the cloth was made from"
    )]
    RenderMesh {
        /// The cloth by name.
        cloth: String,
        /// Texels of the bundle.
        expected: usize,
        /// Texels of the cloth.
        found: usize,
    },
    /// A list of vertices has another length than the render mesh.
    #[error("{found} vertices for a render mesh of {expected}; pass the list of RenderMesh::deform")]
    RenderVertices {
        /// Vertices of the mesh.
        expected: usize,
        /// Vertices in the list.
        found: usize,
    },
    /// No piece of this name.
    #[error("cloth {cloth} has no piece {piece:?}; its pieces are {pieces}")]
    NoPiece {
        /// The cloth by name.
        cloth: String,
        /// The name that was given.
        piece: String,
        /// The names of its pieces.
        pieces: String,
    },
    /// The surface of a body breaks a rule.
    #[error("the surface of a body, element {index}: {problem}")]
    Surface {
        /// The vertex, triangle or joint.
        index: usize,
        /// The rule.
        problem: &'static str,
    },
    /// A cloth has no joints to follow.
    #[error(
        "cloth {cloth} has no joints: build it from a skinned file, so that every piece has maps `joints` and `weights`, or give it \
         some by Cloth::set_skin"
    )]
    NoSkin {
        /// The cloth by name.
        cloth: String,
    },
    /// A cloth does not follow joints.
    #[error("cloth {cloth} does not follow joints: {problem}")]
    Unfollowed {
        /// The cloth by name.
        cloth: String,
        /// The reason, and the remedy.
        problem: &'static str,
    },
    /// A particle is where the joints put it.
    #[error("cloth {cloth}: pinned particle {particle} follows joints; unpin it first, or move the joints")]
    Follows {
        /// The cloth by name.
        cloth: String,
        /// Index of the particle.
        particle: u32,
    },
    /// A list of joint matrices has another length than the skin.
    #[error("{found} joint matrices for {expected} joints; give one for each of Skin::joints")]
    Joints {
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// A joint matrix is NaN or infinite.
    #[error("the matrix of joint {index} ({joint}) is not finite; pass finite numbers")]
    JointNotFinite {
        /// Name of the joint.
        joint: String,
        /// Its index.
        index: usize,
    },
    /// A cloth has no coarser image.
    #[error("cloth {cloth} has no coarser image: {problem}")]
    Coarser {
        /// The cloth by name.
        cloth: String,
        /// The reason, and what to do.
        problem: &'static str,
    },
    /// A number of a particle is NaN or infinite.
    #[error("cloth {cloth}: the {what} of particle {index} is not finite; pass finite numbers")]
    NotFinite {
        /// The cloth by name.
        cloth: String,
        /// The quantity, such as a position.
        what: &'static str,
        /// Index of the particle.
        index: usize,
    },
    /// A state does not fit the cloth.
    #[error("cloth {cloth}: the state does not fit: {problem}")]
    State {
        /// The cloth by name.
        cloth: String,
        /// The difference, and how to resolve it.
        problem: StateProblem,
    },
    /// Bytes are not a state.
    #[error("the bytes are not a {what} of this version: {problem}; save it again")]
    StateBytes {
        /// The expected kind: a state or a snapshot.
        what: &'static str,
        /// The fault in the bytes.
        problem: &'static str,
    },
    /// A buffer cannot hold the data of a cloth.
    #[error("cloth {cloth}: {what} takes {need} bytes in a buffer with {usage}; the buffer has {found} bytes: {hint}")]
    Buffer {
        /// The cloth by name.
        cloth: String,
        /// The data.
        what: &'static str,
        /// Bytes needed.
        need: u64,
        /// Bytes found.
        found: u64,
        /// The usages needed.
        usage: &'static str,
        /// Advice for the caller.
        hint: &'static str,
    },
    /// The call is only for the GPU backend.
    #[error("{0} is for the GPU backend; on the CPU use {1}")]
    CpuBackend(&'static str, &'static str),
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
    /// The device is lost: a driver was reset or removed, or the host destroyed it.
    #[error("the GPU device is lost; make a new one and pass it to Stepper::recover")]
    DeviceLost,
    /// The device has no memory left.
    #[error(
        "the GPU has no memory left; free some, or add less; after a call that records, pass the device to Stepper::recover"
    )]
    OutOfMemory,
    /// The device refused a call, which is a fault of this crate or of the driver.
    #[error("the GPU device refused a call: {0}; update the driver, or use the CPU backend")]
    Device(String),
    /// The host has no memory left for a list.
    #[error("no memory for {need} bytes of {what}; check fewer cloths at a time")]
    Memory {
        /// The contents of the list.
        what: &'static str,
        /// Bytes needed.
        need: u64,
    },
    /// Threads could not be started.
    #[error("no threads: {0}; ask for 1 thread")]
    Threads(String),
}

/// Why a state does not fit a cloth.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StateProblem {
    /// It has other grids.
    #[error("its grids are {found}, those of the cloth {expected}; load the state of a cloth with the same grids")]
    Grids {
        /// Sizes in the state, as `32 x 32, 8 x 16`.
        found: String,
        /// Sizes in the cloth.
        expected: String,
    },
    /// A particle exists in one of the two alone.
    #[error("particle {index} exists in only one of them; load the state of a cloth of the same bundle")]
    Particle {
        /// Index of the particle.
        index: usize,
    },
    /// It was cut with other tethers.
    #[error("it has {found} tethers per particle, the cloth {expected}; use the Options::tethers of the saved stepper")]
    Tethers {
        /// Tethers per particle in the state.
        found: usize,
        /// Tethers per particle of the cloth.
        expected: usize,
    },
    /// A tether ends at a particle that does not exist.
    #[error(
        "a tether of particle {index} ends at a particle that does not exist; save the state again, the file is damaged"
    )]
    Anchor {
        /// Index of the particle that is held.
        index: usize,
    },
    /// It has rest lengths and the cloth has none, or the other way round.
    #[error("only one of them has springs; load the state of a cloth of the same bundle")]
    Springs,
    /// A buffer on the GPU was saved with other steps.
    #[error(
        "it was saved after a step of {found} s, the last step here took {expected} s; read it with SavedState::read and \
         load it with Stepper::set_state"
    )]
    Step {
        /// Length of the step \[s\] before it was saved.
        found: f64,
        /// Length of the last step \[s\].
        expected: f64,
    },
    /// A buffer on the GPU was saved by another solver.
    #[error("it was saved by another solver; make the stepper with the same Options::solver")]
    Solver,
    /// A snapshot has another number of cloths.
    #[error("the snapshot has {found} cloths, the scene {expected}; restore it in the scene that it was taken of")]
    Cloths {
        /// Cloths in the snapshot.
        found: usize,
        /// Cloths in the scene.
        expected: usize,
    },
}

/// An error unless `value` is finite and `ok` holds.
pub(crate) fn check(what: &'static str, value: f64, range: &'static str, ok: impl Fn(f64) -> bool) -> Result<()> {
    if value.is_finite() && ok(value) { Ok(()) } else { Err(Error::Setting { what, value, range }) }
}
