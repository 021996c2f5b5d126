//! All integration tests in one program: it links once, and its tests share the cores to the end.

mod common;
#[path = "../../../tests/src/skip.rs"]
mod skip;

mod build;
mod character;
mod crossings;
mod doctor;
mod export;
mod gate;
mod list;
mod reading;
mod render;
mod simulate;
mod usage;
