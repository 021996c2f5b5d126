//! A square of cloth falls on a ball, without a window. Takes a GPU if there is one, else the CPU.
// An example speaks for itself.
#![allow(clippy::print_stdout)]

use std::error::Error;

use gimage_runtime::{Collider, Flat, Options, Scene, Shape, Stepper, device_limits, read_back, wgpu};

/// Prints where the cloth's middle came to rest.
pub fn main() -> Result<(), Box<dyn Error>> {
    let instance = wgpu::Instance::default();
    let adapter = pollster::block_on(instance.request_adapter(&Default::default())).ok();
    let device = |adapter: wgpu::Adapter| {
        let required_limits = device_limits(&adapter);
        pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor { required_limits, ..Default::default() }))
    };
    let gpu = adapter.map(device).transpose()?;

    let mut scene = Scene::new("square on a ball");
    scene.cloths.push(Flat { origin: [-0.5, 0.4, -0.5], ..Flat::square("square", 33) }.cloth()?);
    let ball = Collider::new(Shape::Sphere { radius: 0.3 }, [0.0; 3]);
    scene.colliders.push(Collider { friction: 0.5, ..ball });
    let mut stepper = Stepper::new(scene, Options::default(), gpu.as_ref().map(|(d, q)| (d, q)))?;

    for _ in 0..60 {
        let Some((device, queue)) = &gpu else {
            stepper.advance(1.0 / 60.0)?;
            continue;
        };
        let mut encoder = device.create_command_encoder(&Default::default());
        stepper.record(&mut encoder, 1.0 / 60.0)?;
        queue.submit([encoder.finish()]);
    }
    let positions = match (&gpu, stepper.buffers(0)) {
        (Some((device, queue)), Some(buffers)) => read_back(device, queue, &buffers.now)?,
        _ => stepper.positions(0).unwrap_or_default().to_vec(),
    };
    let [x, y, z, _] = positions[33 * 16 + 16];
    println!("after 1 s the middle is at {x:.3} {y:.3} {z:.3} m");
    if (y - 0.3).abs() < 0.01 { Ok(()) } else { Err("it should lie on the ball".into()) }
}
