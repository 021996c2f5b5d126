//! All integration tests in one program: it links once, and its tests share the cores to the end.

mod support;

mod backstop;
mod blend;
mod classic;
mod clearing;
mod cloth;
mod findings;
mod material;
mod motion_limits;
mod plan;
mod safe;
mod stirred;
mod tapered;
mod untangle;
mod wrap;
mod wrap_cuts;
mod wrap_levels;
mod xpbd;

// Also, or only, on the GPU.
#[cfg(feature = "gpu")]
mod actions;
#[cfg(feature = "gpu")]
mod bounds;
#[cfg(feature = "gpu")]
mod coats;
#[cfg(feature = "gpu")]
mod collider_poses;
#[cfg(feature = "gpu")]
mod contact;
#[cfg(feature = "gpu")]
mod crumple;
#[cfg(feature = "gpu")]
mod cut;
#[cfg(feature = "gpu")]
mod cut_fused;
#[cfg(feature = "gpu")]
mod cut_tethers;
#[cfg(feature = "gpu")]
mod draw;
#[cfg(feature = "gpu")]
mod drawn_surface;
#[cfg(feature = "gpu")]
mod fused;
#[cfg(feature = "gpu")]
mod gpu;
#[cfg(feature = "gpu")]
mod in_a_game;
#[cfg(feature = "gpu")]
mod instances;
#[cfg(feature = "gpu")]
mod joints;
#[cfg(feature = "gpu")]
mod levels;
#[cfg(feature = "gpu")]
mod limits;
#[cfg(feature = "gpu")]
mod members;
#[cfg(feature = "gpu")]
mod mesh;
#[cfg(feature = "gpu")]
mod moving_frame;
#[cfg(feature = "gpu")]
mod pick;
#[cfg(feature = "gpu")]
mod pins;
#[cfg(feature = "gpu")]
mod prepare;
#[cfg(feature = "gpu")]
mod pyramid;
#[cfg(feature = "gpu")]
mod quality;
#[cfg(feature = "gpu")]
mod recording;
#[cfg(feature = "gpu")]
mod recover;
#[cfg(feature = "gpu")]
mod safe_gpu;
#[cfg(feature = "gpu")]
mod shared;
#[cfg(feature = "gpu")]
mod sleep;
#[cfg(feature = "gpu")]
mod state;
#[cfg(feature = "gpu")]
mod stitches;
#[cfg(feature = "gpu")]
mod surface;
#[cfg(feature = "gpu")]
mod surface_give;
#[cfg(feature = "gpu")]
mod surface_passing;
#[cfg(feature = "gpu")]
mod surface_pins;
#[cfg(feature = "gpu")]
mod surface_plates;
#[cfg(feature = "gpu")]
mod take_apart;
#[cfg(feature = "gpu")]
mod thickness;
#[cfg(feature = "gpu")]
mod tiles;
#[cfg(feature = "gpu")]
mod tune;
#[cfg(feature = "gpu")]
mod uploads;
