//! Pictures: the GPU against the CPU, holes, texture coordinates; and the examples.

use crate::support::{self, FRAME, device};
use gimage_runtime::draw::{Camera, Draw, Look, Software, Target, View};
use gimage_runtime::*;

#[path = "../examples/headless.rs"]
mod headless;
#[path = "../examples/render_loop.rs"]
mod render_loop;

#[test]
fn the_headless_example_runs() {
    device();
    headless::main().unwrap();
}

#[test]
fn the_render_loop_runs() {
    device();
    render_loop::main().unwrap();
}

const SIZE: u32 = 64;

fn view() -> View {
    let camera = Camera { eye: [0.9, 1.2, 2.0], target: [0.5, -0.1, 0.5], fov: 0.8 };
    View { background: [0.1, 0.2, 0.3], ..View::new(&camera, 1.0) }
}

/// A square among all colliders, with a pattern and a corner cut off if asked for, and one whose buffers are the same.
fn prepared(cut: bool, gpu: Option<(&wgpu::Device, &wgpu::Queue)>) -> (Stepper, Look) {
    let mut scene = support::on_colliders(24);
    let other = Flat { origin: [0.1, 0.25, 0.1], right: [0.3, 0.1, 0.0], ..Flat::square("other", 7) };
    scene.cloths.push(other.cloth().unwrap());
    let grid = &scene.cloths[0].grids()[0];
    let uv = (0..grid.texels()).map(|k| [(k % 24) as f32 / 23.0, (k / 24) as f32 / 23.0]).collect();
    let look = Look { uv: Some(uv), checker: [4.0, 0.3], ..Look::plain([0.9, 0.4, 0.2]) };
    let backend = if gpu.is_some() { Backend::Gpu } else { Backend::Cpu };
    let options = Options { backend, substeps: Some(4), solver: Solver::Xpbd, ..Options::default() };
    let mut stepper = Stepper::new(scene, options, gpu).unwrap();
    if cut {
        stepper.cut([0.3, 3.0, 0.5], [0.3, -3.0, -3.0], [0.3, -3.0, 3.0]).unwrap();
    }
    (stepper, look)
}

fn on_cpu(cut: bool) -> Vec<[u8; 4]> {
    let (mut stepper, look) = prepared(cut, None);
    stepper.advance(FRAME).unwrap();
    let mut software = Software::new(SIZE, SIZE, 1).unwrap();
    software.set_look(0, look);
    software.picture(&stepper, &view(), 0.5).unwrap()
}

fn on_gpu(cut: bool, device: &wgpu::Device, queue: &wgpu::Queue) -> Vec<[u8; 4]> {
    let (mut stepper, look) = prepared(cut, Some((device, queue)));
    let texture = |format, samples, usage| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: samples,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    };
    // Not sRGB and with reversed depth: what the example does not do.
    let (color, depth) = (wgpu::TextureFormat::Rgba8Unorm, wgpu::TextureFormat::Depth24Plus);
    let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
    let picture = texture(color, 1, attachment | wgpu::TextureUsages::COPY_SRC);
    let samples = texture(color, 4, attachment).create_view(&Default::default());
    let depths = texture(depth, 4, attachment).create_view(&Default::default());
    let test = Some((depth, wgpu::CompareFunction::Greater));
    let mut draw = Draw::new(device, queue, Target { color, depth: test, samples: 4 });
    draw.set_look(0, look);
    let mut view = view();
    view.clip.iter_mut().for_each(|column| column[2] = column[3] - column[2]);
    let mut encoder = device.create_command_encoder(&Default::default());
    stepper.record(&mut encoder, FRAME).unwrap();
    let [r, g, b] = view.background.map(f64::from);
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &samples,
            depth_slice: None,
            resolve_target: Some(&picture.create_view(&Default::default())),
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
                store: wgpu::StoreOp::Discard,
            },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depths,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    draw.record(&mut pass, &stepper, &view, 0.5).unwrap();
    drop(pass);
    queue.submit([encoder.finish()]);
    read_back_picture(device, queue, &picture).unwrap()
}

fn differences(a: &[[u8; 4]], b: &[[u8; 4]]) -> (f64, f64) {
    let far = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap();
    let all: Vec<_> = a.iter().zip(b).map(far).collect();
    let mean = all.iter().map(|d| f64::from(*d)).sum::<f64>() / all.len() as f64;
    (mean, all.iter().filter(|d| **d > 12).count() as f64 / all.len() as f64)
}

#[test]
fn the_gpu_draws_what_the_cpu_draws() {
    let Some((device, queue)) = device() else { return };
    let pictures = [false, true].map(|cut| {
        let (there, here) = (on_gpu(cut, &device, &queue), on_cpu(cut));
        let (mean, large) = differences(&there, &here);
        eprintln!("cut {cut}: mean difference {mean:.3} of 255, {large:.4} of the pixels by more than 12");
        // The GPU resolves encoded samples here, so edges differ; the inside does not.
        assert!(mean < 3.0 && large < 0.08, "cut {cut}: {mean} {large}");
        here
    });
    let (mean, large) = differences(&pictures[0], &pictures[1]);
    assert!(mean > 0.3 && large > 0.01, "the cut does not show: {mean} {large}");
}

#[test]
fn pictures_do_not_depend_on_threads_and_bad_ones_are_refused() {
    let (mut stepper, look) = prepared(false, None);
    stepper.advance(FRAME).unwrap();
    let picture = |threads| {
        let mut software = Software::new(200, 150, threads).unwrap();
        software.set_look(0, look.clone());
        software.picture(&stepper, &view(), 0.5).unwrap()
    };
    assert!(picture(1) == picture(3));
    assert!(Software::new(0, 9, 1).is_err() && Software::new(9, 8193, 1).is_err());
    let mut software = Software::new(8, 8, 1).unwrap();
    software.set_look(0, Look { uv: Some(vec![[0.0; 2]; 3]), ..look });
    let error = software.picture(&stepper, &view(), 0.5).unwrap_err().to_string();
    assert!(error.contains("texture coordinates"), "{error}");
}

#[test]
fn a_camera_among_the_cloth_clips_it() {
    let (stepper, _) = prepared(false, None);
    let camera = Camera { eye: [0.5, 0.06, 0.5], target: [0.9, 0.0, 0.9], fov: 1.5 };
    let picture = Software::new(32, 32, 1).unwrap().picture(&stepper, &View::new(&camera, 1.0), 1.0).unwrap();
    assert!(picture.iter().any(|p| p[..3] != [255; 3]) && picture.iter().all(|p| p[3] == 255));
}
