//! A dressed character plays an animation: docs/characters.md. Its screen, which a game has anyway, is in screen.rs.
use std::{env, error::Error, fs, path::Path};

use gimage::import::{Character, ImportOptions};
use gimage_runtime::draw::{Camera, View};
use gimage_runtime::{BodyCollider, Cloth, Options, Scene, Stepper, device_limits, wgpu};

mod screen;

/// Reads a bundle and an animation of its character, and writes a picture.
pub fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = env::args().skip(1).collect();
    let [bundle, character, animation, picture] = &args[..] else {
        return Err("usage: character BUNDLE CHARACTER ANIMATION PICTURE.ppm".into());
    };
    let rgb = run(bundle.as_ref(), character.as_ref(), animation, 180)?.into_iter().flat_map(|p| [p[0], p[1], p[2]]);
    Ok(fs::write(picture, b"P6 256 256 255\n".iter().copied().chain(rgb).collect::<Vec<_>>())?)
}

/// Plays some frames of 1/60 s, and returns the last: 256 x 256 pixels.
pub fn run(bundle: &Path, file: &Path, animation: &str, frames: u32) -> Result<Vec<[u8; 4]>, Box<dyn Error>> {
    let adapter = pollster::block_on(wgpu::Instance::default().request_adapter(&Default::default()))?;
    let wanted = wgpu::DeviceDescriptor { required_limits: device_limits(&adapter), ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&wanted))?;

    let bundle = gimage_bundle::dir::read_dir(bundle)?;
    let mut cloth = Cloth::from_bundle("clothes", &bundle)?;
    let skin = cloth.skin().ok_or("the bundle has no joints")?.clone();
    // In a game the engine has the joints. The first second leads from the pose of the skins, where clothes fit, into the animation.
    let character = Character::read(file, animation, &ImportOptions::default())?;
    let nodes = skin.joints().iter().map(|j| character.node(&j.name)).collect::<Result<Vec<_>, _>>()?;
    let joints = |time: f64| {
        let worlds = character.worlds_between(time - 1.0, time.min(1.0));
        skin.matrices(&nodes.iter().map(|n| worlds[*n].map(|x| x as f32)).collect::<Vec<_>>())
    };

    cloth.follow_joints(&joints(0.0)?)?;
    let (low, high) = cloth.bounds().ok_or("no particles")?;
    let body = BodyCollider::of_bundle(&bundle);
    let colliders = body.iter().map(|part| part.collider).collect();
    let scene = Scene { cloths: vec![cloth], colliders, ..Scene::new("character") };
    let mut stepper = Stepper::new(scene, Options::default(), Some((&device, &queue)))?;
    let mut screen = screen::Screen::new(&device, &queue);
    let view = View::new(&Camera::framing(low, high, [0.5, 0.2, 1.0], 0.9, 1.0), 1.0);
    for frame in 1..=frames {
        let matrices = joints(f64::from(frame) / 60.0)?;
        stepper.set_joints(0, &matrices)?;
        stepper.move_body(0, 0, &body, &matrices)?;
        let mut encoder = device.create_command_encoder(&Default::default());
        let progress = stepper.record(&mut encoder, 1.0 / 60.0)?;
        screen.draw(&mut encoder, &stepper, &view, progress.fraction)?;
        queue.submit([encoder.finish()]);
        stepper.settle()?;
    }
    screen.read(&device, &queue)
}
