//! Structs as shaders lay them out; a test compares every offset.

use bytemuck::{Pod, Zeroable};

use crate::collider::solid::Solid;
use crate::step::Step;

/// `Step` of shaders/part/step.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct StepRow {
    pub gravity: [f32; 3],
    pub keep: f32,
    pub wind: [f32; 3],
    pub scale: f32,
    pub drift: [f32; 3],
    pub response: f32,
    pub turn: f32,
    pub fineness: f32,
    pub longest: f32,
    pub dt: f32,
    pub rate: f32,
    pub drag: f32,
    pub lift: f32,
    pub left: f32,
}

/// `Grid` of shaders/part/grid.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GridRow {
    pub first: u32,
    pub width: u32,
    pub height: u32,
    /// Compliance \[m/N\]; of hard springs the bound of diagonals.
    pub soft: f32,
    pub rest: [f32; 4],
}

/// `Solid` of shaders/part/solid.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct SolidRow {
    pub center: [f32; 3],
    pub kind: u32,
    pub size: [f32; 3],
    pub friction: f32,
    pub rotation: [f32; 4],
    pub velocity: [f32; 3],
    pub unused1: u32,
    pub spin: [f32; 3],
    pub unused2: u32,
}

/// A vertex of a bound mesh, as shaders/wrap.wgsl reads it.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BoundRow {
    /// Particles of the cloth.
    pub corners: [u32; 3],
    /// Of the second and the third corner.
    pub weights: [f32; 2],
    /// In the frame \[m\]; the position of a vertex that is not bound.
    pub offset: [f32; 3],
    /// In the frame; in the space of the cloth for a vertex that is not bound.
    pub normal: [f32; 4],
    /// Likewise; w is the sign of the bitangent.
    pub tangent: [f32; 4],
}

/// How far a vertex of a bound mesh would jump as its cloth changes its level, in its frame on the new one, as shaders/wrap.wgsl reads it; fourth
/// components are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct JumpRow {
    /// \[m\]
    pub position: [f32; 4],
    /// The difference of the unit normals, and of the unit tangents.
    pub normal: [f32; 4],
    pub tangent: [f32; 4],
}

/// A vertex of a bound mesh between the skin and the cloth, as shaders/blend.wgsl reads it before its joints.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BlendRow {
    /// Where it is at rest \[m\].
    pub rest: [f32; 3],
    /// 0 on the skin, below 1.
    pub share: f32,
    /// At rest.
    pub normal: [f32; 3],
    /// Its number in the mesh.
    pub vertex: u32,
    /// At rest; w is not used.
    pub tangent: [f32; 4],
}

/// A vertex as it is drawn: 48 bytes, the same on the CPU and in the buffer of [`crate::Stepper::record_wrap`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RenderVertex {
    /// Position \[m\] in the space of the cloth; the fourth number is 1.
    pub position: [f32; 4],
    /// Unit normal; the fourth number is 0.
    pub normal: [f32; 4],
    /// Unit tangent, 0 if the file has none; the fourth number is the sign of the bitangent.
    pub tangent: [f32; 4],
}

/// Groups of steps that moving colliders tell apart in a frame.
pub const POSES: u32 = 128;

/// `Frame` of shaders/part/jobs.wgsl.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct FrameRow {
    pub steps: u32,
    pub rounds: u32,
    pub together: u32,
    pub solids: u32,
    /// Steps of a dispatch, but for the last.
    pub most: u32,
    /// Steps from one with the passes on coarser grids to the next.
    pub pyramid: u32,
    pub unused: [u32; 2],
    pub rows: [StepRow; POSES as usize + 1],
}

/// `Job` of shaders/part/jobs.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct JobRow {
    pub first: u32,
    pub count: u32,
    pub grid: u32,
    pub grids: u32,
    pub ring: u32,
    pub rings: u32,
    pub row: u32,
    pub solid: u32,
    pub keep: [f32; 2],
    pub longest: [f32; 2],
    pub hold: u32,
    /// Where its images begin in lists by texels, which instances of a cloth share; a multiple of 64, as `first`.
    pub image: u32,
    /// Colliders that it meets.
    pub solids: u32,
    /// Most coarser levels of a grid; 0 without a pyramid.
    pub levels: u32,
    /// Acceleration and wind in its frame of reference.
    pub gravity: [f32; 4],
    pub wind: [f32; 4],
}

/// `Link` of shaders/part/links.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LinkRow {
    pub follows: u32,
    pub mass: f32,
}

/// The counters of a cloth in the buffer `faults`, which belongs to every frame of XPBD. Shaders know each by its index
/// (`FAULT_...`, see crates/runtime/src/shaders/constants.rs).
#[repr(C)]
pub struct FaultRow {
    /// Particles at fault in the last frame.
    pub particles: u32,
    /// Frames taken back.
    pub frames: u32,
    /// One more than the last particle at fault.
    pub last: u32,
    pub unused: u32,
    /// The largest squared displacement of a whole frame, as the bits of an f32.
    pub speed: u32,
    /// The largest stretch of a whole frame, as the bits of an f32.
    pub strain: u32,
}

/// Bytes of [`FaultRow`] and what a host may bind beside it.
pub const FAULT_BYTES: usize = 32;
/// Distance of the counters of two cloths that share buffers \[u32\]: that of bindings.
pub const FAULT_STRIDE: u32 = 64;
/// Where the notes of a workgroup without room in its memory begin, behind the counters.
pub const FAULT_NOTES: u32 = 8;

impl From<&Step<f64>> for StepRow {
    fn from(step: &Step<f64>) -> Self {
        let Step { gravity, keep, wind, scale, drift, response, turn, fineness, longest, dt, rate, drag, lift, left } =
            step.cast::<f32>();
        StepRow { gravity, keep, wind, scale, drift, response, turn, fineness, longest, dt, rate, drag, lift, left }
    }
}

impl From<Solid<f32>> for SolidRow {
    fn from(solid: Solid<f32>) -> Self {
        let Solid { center, kind, size, friction, rotation, velocity, spin, .. } = solid;
        SolidRow { center, kind, size, friction, rotation, velocity, unused1: 0, spin, unused2: 0 }
    }
}
