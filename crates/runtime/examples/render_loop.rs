//! How an engine uses the runtime: it owns device, queue and encoder; a frame's cloth passes and its own draw pass go
//! into one submission, and nothing is read back. Offscreen, so that it runs anywhere; with a window the colour view is
//! that of the surface. Without an adapter the same pictures are made on the CPU.
// An example speaks for itself.
#![allow(clippy::print_stdout)]

use std::error::Error;

use gimage_runtime::draw::{Camera, Draw, Look, Software, Target, View};
use gimage_runtime::scene::{Key, Motion, Pose, Script};
use gimage_runtime::{Collider, Flat, Options, Scene, Shape, Stepper, device_limits, read_back_picture, wgpu};

const SIZE: u32 = 128;
const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Runs 40 frames of uneven length and says how much of the last picture is cloth or ball.
pub fn main() -> Result<(), Box<dyn Error>> {
    let (scene, script) = scene()?;
    let camera = Camera { eye: [1.2, 0.6, 1.8], target: [0.0, -0.4, 0.0], fov: 0.7 };
    let view = View { background: [0.0; 3], ..View::new(&camera, 1.0) };
    let instance = wgpu::Instance::default();
    let pixels = match pollster::block_on(instance.request_adapter(&Default::default())) {
        Ok(adapter) => Engine::new(&adapter, scene)?.run(&script, &view)?,
        Err(error) => {
            println!("{error}: on the CPU");
            on_cpu(scene, &script, &view)?
        }
    };
    let drawn = pixels.iter().filter(|p| p[..3] != [0; 3]).count();
    let share = drawn as f64 / pixels.len() as f64;
    println!("{:.1} % of the picture is drawn", 100.0 * share);
    if (0.1..0.9).contains(&share) { Ok(()) } else { Err("the cloth should fill a good part of the picture".into()) }
}

/// A curtain, and a ball that swings through it.
fn scene() -> Result<(Scene, Script), gimage_runtime::Error> {
    let mut scene = Scene::new("curtain");
    let mut cloth = Flat { down: [0.0, -1.0, 0.0], origin: [-0.5, 0.0, 0.0], ..Flat::square("curtain", 33) }.cloth()?;
    (0..33).try_for_each(|k| cloth.set_pinned(k, true))?;
    cloth.damping = 1.0;
    scene.cloths.push(cloth);
    scene.colliders.push(Collider::new(Shape::Sphere { radius: 0.2 }, [0.0, -0.5, -0.6]));
    let at = |time, z| Key { time, pose: Pose { position: [0.0, -0.5, z], ..Pose::default() } };
    let swing = Motion::new(vec![at(0.0, -0.6), at(0.5, 0.3), at(1.0, -0.6)])?;
    Ok((scene, Script { colliders: vec![Some(swing)], ..Script::default() }))
}

/// State that an engine has anyway.
struct Engine {
    device: wgpu::Device,
    queue: wgpu::Queue,
    color: wgpu::Texture,
    depth: wgpu::TextureView,
    stepper: Stepper,
    draw: Draw,
}

impl Engine {
    fn new(adapter: &wgpu::Adapter, scene: Scene) -> Result<Self, Box<dyn Error>> {
        let wanted = wgpu::DeviceDescriptor { required_limits: device_limits(adapter), ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&wanted))?;
        let texture = |format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            })
        };
        let color = texture(COLOR, wgpu::TextureUsages::COPY_SRC);
        let depth = texture(DEPTH, wgpu::TextureUsages::empty()).create_view(&Default::default());
        let stepper = Stepper::new(scene, Options::default(), Some((&device, &queue)))?;
        let depth_test = Some((DEPTH, wgpu::CompareFunction::Less));
        let mut draw = Draw::new(&device, &queue, Target { color: COLOR, depth: depth_test, samples: 1 });
        draw.set_look(0, Look::plain([0.8, 0.3, 0.2]));
        Ok(Engine { device, queue, color, depth, stepper, draw })
    }

    fn run(mut self, script: &Script, view: &View) -> Result<Vec<[u8; 4]>, Box<dyn Error>> {
        let mut time = 0.0;
        for frame in 0..40 {
            // A display that is not in step with the simulation.
            let dt = if frame % 3 == 0 { 0.021 } else { 0.013 };
            script.frame(&mut self.stepper, time, dt)?;
            time += dt;
            let mut encoder = self.device.create_command_encoder(&Default::default());
            let progress = self.stepper.record(&mut encoder, dt)?;
            let color = self.color.create_view(&Default::default());
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &color,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.depth,
                    depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            // The engine's own draws go here too.
            self.draw.record(&mut pass, &self.stepper, view, progress.fraction)?;
            drop(pass);
            self.queue.submit([encoder.finish()]);
        }
        // Only to see that there is a picture; an engine presents it.
        Ok(read_back_picture(&self.device, &self.queue, &self.color)?)
    }
}

fn on_cpu(scene: Scene, script: &Script, view: &View) -> Result<Vec<[u8; 4]>, gimage_runtime::Error> {
    let mut stepper = Stepper::new(scene, Options::default(), None)?;
    let mut fraction = 1.0;
    for frame in 0..40 {
        let dt = 0.0155;
        script.frame(&mut stepper, f64::from(frame) * dt, dt)?;
        fraction = stepper.advance(dt)?.fraction;
    }
    Software::new(SIZE, SIZE, 1)?.picture(&stepper, view, fraction)
}
