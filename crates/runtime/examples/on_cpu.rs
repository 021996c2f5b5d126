//! A garment on the CPU alone, drawn without a device: `--no-default-features --features threads` leaves wgpu out.
use std::{env, error::Error, fs, path::Path};

use gimage_runtime::draw::{Camera, Software, View};
use gimage_runtime::{Cloth, Options, Scene, Stepper};

/// Reads a bundle and writes a picture; both paths are arguments.
pub fn main() -> Result<(), Box<dyn Error>> {
    let mut args = env::args_os().skip(1);
    let (Some(bundle), Some(picture)) = (args.next(), args.next()) else {
        return Err("usage: on_cpu BUNDLE PICTURE.ppm".into());
    };
    let rgb = run(Path::new(&bundle), 60)?.into_iter().flat_map(|p| [p[0], p[1], p[2]]);
    Ok(fs::write(picture, b"P6 256 256 255\n".iter().copied().chain(rgb).collect::<Vec<_>>())?)
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
