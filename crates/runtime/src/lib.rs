//! Simulates geometry images as cloth, on the GPU (wgpu) or on the CPU.
//!
//! A [`Cloth`] is made from a bundle, or flat. A [`Scene`] has cloths, colliders and wind. A [`Stepper`] steps a scene.
//!
//! The host owns device, queue and encoder. [`Stepper::record`] adds the passes of a frame to an encoder; it does not submit, wait
//! or read back. The only exception is the [`self_check`] of a device at its first use. Every pass has a twin on the CPU with the
//! same results to rounding.
//!
//! ```
//! use gimage_runtime::{Flat, Options, Scene, Stepper};
//!
//! let mut scene = Scene::new("falling");
//! scene.cloths.push(Flat::square("square", 9).cloth()?);
//! let mut stepper = Stepper::on_cpu(scene, Options::default())?;
//! for _ in 0..60 {
//!     stepper.advance(1.0 / 60.0)?;
//! }
//! let [_, y, _, _] = stepper.positions(0).unwrap_or_default()[0];
//! assert!((y + 4.9).abs() < 0.1, "fell to {y} m in 1 s");
//! # Ok::<(), gimage_runtime::Error>(())
//! ```
//!
//! The crate uses wgpu 30 and re-exports it as `wgpu`. A guide leads from a bundle to the screen:
//! [docs/screen.md](https://github.com/gimage/gimage/blob/main/docs/screen.md).
//!
//! Without the feature `gpu` (on by default) the crate does not compile wgpu: [`Stepper::on_cpu`] and the CPU backend remain.

// Plans of dispatches and the table of shaders have no reader in a build without `gpu`.
#![cfg_attr(not(feature = "gpu"), allow(dead_code))]

mod bounds;
mod choose;
mod clearing;
mod clock;
mod cloth;
mod coarser;
mod coat;
mod collider;
mod cpu;
pub mod crossings;
pub mod draw;
mod error;
mod findings;
mod fold;
mod form;
mod frame;
mod fused;
#[cfg(feature = "gpu")]
mod gpu;
#[cfg(not(feature = "gpu"))]
#[path = "gpu/absent.rs"]
mod gpu;
mod handle;
mod health;
mod layout;
mod levels;
mod limits;
mod look;
mod loops;
mod material;
mod measure;
mod memory;
mod mesh;
mod moving_frame;
mod number;
mod options;
mod passes;
mod pick;
mod plan;
mod quality;
#[cfg(feature = "reference")]
mod reference;
mod render_mesh;
pub mod scene;
mod shaders;
mod state;
mod step;
mod stepper;
mod tile;
mod tuning;
mod wind;
mod world;

pub use bounds::Bounds;
pub use choose::{Choice, Support};
pub use clearing::ClearedStart;
pub use clock::Progress;
pub use cloth::{
    Anchor, Backstop, BodySurface, Cloth, ClothContact, Compliance, ContactTier, Flat, Grid, Influence, JointPoses,
    MAX_STITCHES_AT_POINT, Mass, Particle, Parts, Rest, Select, Skin, SkinJoint, Skinning, Stitch, Tethers,
};
pub use coarser::Coarser;
pub use collider::{BODY_GROUP, BodyCollider, Collider, Shape};
pub use error::{Error, Result, StateProblem};
pub use findings::{Fate, Finding, MAX_LENGTH, MAX_P99, PieceTexel};
pub use form::{Chain, Form, Fused, Hold, Tile, TileShape, TileSpan};
#[cfg(feature = "gpu")]
pub use gpu::{
    Ahead, ClothBuffers, Compiled, PassTime, Preparation, Span, UploadCount, device_features, device_limits,
    read_back_async, read_back_picture_async, read_back_u32_async,
};
#[cfg(all(feature = "gpu", not(target_family = "wasm")))]
pub use gpu::{read_back, read_back_picture, read_back_u32};
pub use handle::{ClothHandle, ClothRef};
pub use health::{Health, Stretch};
pub use limits::{LONGEST, LONGEST_FREE, MOST_LENGTHS, MOST_RATIO, Warning};
pub use material::Material;
pub use measure::{Measures, measure};
pub use memory::Memory;
pub use moving_frame::{FrameMotion, Inertia, MovingFrame};
pub use number::real::Real;
pub use options::{Backend, Options, Sleep, Solver};
pub use passes::{Air, Kinds, Pass, Soft};
#[cfg(feature = "gpu")]
pub use pick::PickTicket;
pub use pick::{Hit, pick};
pub use plan::{Plan, PlannedPass};
pub use quality::Quality;
#[cfg(feature = "reference")]
pub use reference::Reference;
pub use render_mesh::{RenderMesh, RenderPart, RenderVertex};
pub use scene::Scene;
pub use state::{ClothState, Snapshot};
#[cfg(all(feature = "gpu", not(target_family = "wasm")))]
pub use stepper::self_check;
pub use stepper::{Drag, Stepper, TakenApart, level_at};
#[cfg(feature = "gpu")]
pub use stepper::{Mismatch, SavedState, SelfCheck, self_check_async};
pub use tuning::Tuning;
#[cfg(feature = "gpu")]
pub use wgpu;
pub use wind::{Wind, WindForce};
pub use world::Fault;
