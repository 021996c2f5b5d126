//! The CPU backend: the twin of every pass, one file each, with the stem of the shader.
//!
//! Twins are generic over f32, which steps, and f64, which measures rounding. They do the operations of the shaders in
//! the same order. Large grids are shared out by rows or by rows of pairs, never by the number of threads, so every
//! number of threads gives the same bits.

mod act;

pub(crate) mod aside;
pub(crate) mod blend;
pub(crate) mod body;
pub(crate) mod bounds;
pub(crate) mod colliders;
pub(crate) mod contact;
pub(crate) mod cut;
pub(crate) mod cut_springs;
pub(crate) mod cut_tethers;
pub(crate) mod fabric;
pub(crate) mod facets;
pub(crate) mod fastest;
pub(crate) mod fused;
pub(crate) mod guard;
pub(crate) mod gust;
pub(crate) mod indices;
pub(crate) mod inertia;
pub(crate) mod integrate;
pub(crate) mod interpolate;
#[cfg(test)]
pub(crate) mod joint;
pub(crate) mod jump;
pub(crate) mod lazy;
pub(crate) mod neighbours;
pub(crate) mod normals;
pub(crate) mod pick;
pub(crate) mod pick_nearest;
pub(crate) mod place;
pub(crate) mod prolong;
pub(crate) mod restore;
pub(crate) mod restrict;
pub(crate) mod route;
pub(crate) mod rows;
pub(crate) mod save;
pub(crate) mod seam_normals;
pub(crate) mod seams;
pub(crate) mod sheet;
mod skin;
pub(crate) mod speed;
pub(crate) mod springs;
pub(crate) mod start;
pub(crate) mod strain;
pub(crate) mod surface;
pub(crate) mod tangents;
pub(crate) mod transform;
pub(crate) mod truncation;
pub(crate) mod untangle;
pub(crate) mod wind;
pub(crate) mod wrap;
pub(crate) mod wrap_indices;
