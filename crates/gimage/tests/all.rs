//! All integration tests in one program: it links once, and its tests share the cores to the end.

#![allow(clippy::print_stdout)]

#[path = "../../../tests/src/skip.rs"]
mod skip;
mod support;

mod compression;
mod import_garments;
mod import_gltf;
mod import_obj;
mod motion;
mod pins;
mod repair_garments;
