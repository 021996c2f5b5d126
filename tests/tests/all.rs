//! All integration tests in one program: it links once, and its tests share the cores to the end.

#![allow(clippy::print_stdout)]

#[path = "../../crates/runtime/tests/support/adapter.rs"]
mod adapter;
#[path = "support/drawn.rs"]
mod drawn;
#[path = "support/motion.rs"]
mod motion;

mod architecture;
mod assets;
mod bad;
mod bare_limbs;
mod blend;
mod character;
mod contents;
mod crossings;
mod determinism;
mod examples;
mod figure;
mod figure_in_cape;
mod flat;
mod garments;
mod golden;
mod known_issues;
mod loose_fit;
mod one_material;
mod parts;
mod placed;
mod plain_words;
mod random_meshes;
mod render_again;
mod render_mesh;
mod round_trip;
mod shells;
mod springs;
mod stitches;
mod strands;
mod subdivide;
mod tshirt_in_motion;
mod weld;
