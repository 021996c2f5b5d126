//! A garment on the CPU alone, drawn without a device: `--no-default-features --features threads` leaves wgpu out.
use std::{env, error::Error, path::Path};

use gimage_runtime::draw::{Camera, Software, View};
use gimage_runtime::{Cloth, Options, Scene, Stepper};

fn main() -> Result<(), Box<dyn Error>> {
    let path = env::args_os().nth(1).ok_or("usage: on_cpu BUNDLE")?;
    run(Path::new(&path), 60).map(drop)
}

/// Steps a garment for some frames, and returns a picture: 256 x 256 pixels, row by row from the top, RGBA.
pub fn run(bundle: &Path, frames: u32) -> Result<Vec<[u8; 4]>, Box<dyn Error>> {
    let cloth = Cloth::from_bundle("garment", &gimage_bundle::dir::read_dir(bundle)?)?;
    let (low, high) = cloth.bounds().ok_or("no particles")?;
    let scene = Scene { cloths: vec![cloth], ..Scene::new("on the CPU") };
    let mut stepper = Stepper::on_cpu(scene, Options::default())?;
    let mut fraction = 1.0;
    for _ in 0..frames {
        fraction = stepper.advance(1.0 / 60.0)?.fraction;
    }
    let view = View::new(&Camera::framing(low, high, [0.5, 0.2, 1.0], 0.6, 1.0), 1.0);
    Ok(Software::new(256, 256, 1)?.picture(&stepper, &view, fraction)?)
}
