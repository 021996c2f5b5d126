//! A garment in a browser: `examples/web/README.md` has the commands.

#[cfg(target_family = "wasm")]
mod garment;
mod scene;
#[cfg(target_family = "wasm")]
mod screen;

#[cfg(target_family = "wasm")]
pub use garment::Garment;
pub use scene::{STEP, scene};
