//! The stages of a build, in order. Each takes plain data and returns plain data; [`crate::pipeline::build`] composes them.

// A file.

pub mod import;

pub mod select;

pub mod repair;

pub mod shell;

pub mod component;

pub mod contents;

pub mod caps;

pub mod colliders;
pub mod strands;

// Each connected component: a surface.

pub mod cut;

pub mod border;

pub mod layout;

pub mod parameterize;

pub mod sample;

pub mod image;

pub mod split;

// All images.

pub mod hold;

pub mod blend;

pub mod assemble;

pub mod stitch;

pub mod measure;

pub mod gate;

pub mod render;

// The way back, from a bundle.

pub mod reconstruct;

pub mod export;
