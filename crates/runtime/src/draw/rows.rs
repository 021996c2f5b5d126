//! Structs as the drawing shaders lay them out; a test compares every offset.

use bytemuck::{Pod, Zeroable};

use super::raster::decoded;
use super::{Look, View};
use crate::collider::{Collider, Shape};

/// `View` of shaders/part/view.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ViewRow {
    pub clip: [[f32; 4]; 4],
    pub eye: [f32; 3],
    pub fraction: f32,
    pub middle: [f32; 3],
    pub tiles: f32,
    pub background: [f32; 3],
    pub shade: f32,
    pub light: [f32; 3],
    pub jump: f32,
    pub front: [f32; 4],
    pub back: [f32; 4],
}

/// `Body` of shaders/part/drawn_solid.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BodyRow {
    pub rotation: [f32; 4],
    pub center: [f32; 3],
    pub fade: f32,
    pub color: [f32; 4],
}

/// `Paint` of shaders/draw_surface.wgsl.
#[cfg(any(test, feature = "gpu"))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PaintRow {
    pub color: [f32; 4],
    pub alpha: u32,
    pub cutoff: f32,
    pub wrap: u32,
    pub first: u32,
    pub levels: u32,
    pub pad_a: u32,
    pub pad_b: u32,
    pub pad_c: u32,
}

/// Towards the lamp in the camera's own frame: from the upper left, behind the eye.
const LAMP: [f32; 3] = [-0.48, 0.6, 0.64];
/// Tiles in a metre of a half-space's plane, and how much darker every other one is.
const FLOOR: [f32; 2] = [2.0, 0.07];

impl ViewRow {
    /// A cloth seen at `fraction` of a step.
    pub fn cloth(view: &View, look: &Look, jump: f32, fraction: f32) -> Self {
        let [tiles, shade] = look.checker;
        let [front, back] = [look.front, look.back].map(|c| {
            let [r, g, b] = c.map(decoded);
            [r, g, b, 1.0]
        });
        ViewRow { fraction, tiles, shade, jump, front, back, ..Self::solids(view) }
    }

    /// The colliders.
    pub fn solids(view: &View) -> Self {
        let axes = view.axes();
        let light = [0, 1, 2].map(|c| (0..3).map(|a| LAMP[a] * axes[a][c]).sum());
        ViewRow {
            clip: view.clip,
            eye: view.eye,
            fraction: 1.0,
            middle: view.target,
            tiles: FLOOR[0],
            background: view.background.map(decoded),
            shade: FLOOR[1],
            light,
            jump: 0.0,
            front: [1.0; 4],
            back: [1.0; 4],
        }
    }
}

impl BodyRow {
    /// A collider in a colour.
    pub fn new(collider: &Collider, color: [f32; 3]) -> Self {
        let floor = collider.shape == Shape::HalfSpace;
        let fade = if floor { super::mesh::FLOOR_RADIUS } else { 0.0 };
        // Floors are paler than what stands on them.
        let [r, g, b] = color.map(|c| decoded(if floor { 0.45 + 0.55 * c } else { c }));
        BodyRow { rotation: collider.rotation, center: collider.center, fade, color: [r, g, b, 1.0] }
    }
}
