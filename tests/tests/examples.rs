//! The examples that take a bundle: the T-shirt from its file to the screen, on the GPU and on the CPU alone.

#[path = "../../crates/runtime/examples/bundle_to_screen.rs"]
mod bundle_to_screen;
#[path = "../../crates/runtime/examples/on_cpu.rs"]
mod on_cpu;

use crate::adapter;
use gimage_bundle::dir::write_dir;
use gimage_tests::{asset, build, pinned};

const FRAMES: u32 = 5;

/// The share of pixels that are not background.
fn drawn(pixels: &[[u8; 4]]) -> f64 {
    pixels.iter().filter(|p| p[..3] != [255; 3]).count() as f64 / pixels.len() as f64
}

#[test]
fn a_bundle_comes_to_the_screen_on_the_gpu_and_on_the_cpu() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tshirt.gim");
    let built = build(&asset("tshirt.glb"), &pinned(1024, &["above:1.4"])).unwrap();
    write_dir(&built.bundle, &path, false).unwrap();
    let cpu = on_cpu::run(&path, FRAMES).unwrap();
    assert!((0.15..0.85).contains(&drawn(&cpu)), "{} of the picture is drawn", drawn(&cpu));
    assert!(on_cpu::main().is_err(), "no bundle is given");
    assert!(on_cpu::run(&folder.path().join("none.gim"), 1).is_err());
    if adapter::device().is_none() {
        return;
    }
    assert!(bundle_to_screen::main().is_err(), "no bundle is given");
    let gpu = bundle_to_screen::run(&path, FRAMES).unwrap();
    // Edges may lie in the next pixel.
    let other = gpu.iter().zip(&cpu).filter(|(a, b)| (0..3).any(|c| a[c].abs_diff(b[c]) > 8)).count();
    let share = other as f64 / cpu.len() as f64;
    assert!(share < 0.01, "{share} of the pixels differ");
}
