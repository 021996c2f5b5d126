//! From a bundle to the screen: docs/screen.md. The screen is a texture here; in a window it is that of the surface.
use std::{env, error::Error, fs, path::Path};

use gimage_runtime::draw::{Camera, Draw, Target, View};
use gimage_runtime::wgpu::{self, CompareFunction, TextureFormat};
use gimage_runtime::{Cloth, Options, Scene, Stepper, device_limits, read_back_picture};

const COLOR: TextureFormat = TextureFormat::Rgba8UnormSrgb;
const DEPTH: (TextureFormat, CompareFunction) = (TextureFormat::Depth32Float, CompareFunction::Less);

/// Reads a bundle and writes a picture; both paths are arguments.
pub fn main() -> Result<(), Box<dyn Error>> {
    let (Some(bundle), Some(picture)) = (env::args_os().nth(1), env::args_os().nth(2)) else {
        return Err("usage: bundle_to_screen BUNDLE PICTURE.ppm".into());
    };
    let rgb = run(Path::new(&bundle), 60)?.into_iter().flat_map(|p| [p[0], p[1], p[2]]);
    Ok(fs::write(picture, b"P6 256 256 255\n".iter().copied().chain(rgb).collect::<Vec<_>>())?)
}

/// Draws some frames of a garment, and returns the last: 256 x 256 pixels.
pub fn run(bundle: &Path, frames: u32) -> Result<Vec<[u8; 4]>, Box<dyn Error>> {
    let adapter = pollster::block_on(wgpu::Instance::default().request_adapter(&Default::default()))?;
    let wanted = wgpu::DeviceDescriptor { required_limits: device_limits(&adapter), ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&wanted))?;
    let cloth = Cloth::from_bundle("garment", &gimage_bundle::dir::read_dir(bundle)?)?;
    let (low, high) = cloth.bounds().ok_or("no particles")?;
    let scene = Scene { cloths: vec![cloth], ..Scene::new("bundle to screen") };
    let mut stepper = Stepper::new(scene, Options::default(), Some((&device, &queue)))?;

    let texture = |format, usage| wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 256, height: 256, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
        view_formats: &[],
    };
    let screen = device.create_texture(&texture(COLOR, wgpu::TextureUsages::COPY_SRC));
    let depth = device.create_texture(&texture(DEPTH.0, wgpu::TextureUsages::empty())).create_view(&Default::default());
    let mut draw = Draw::new(&device, &queue, Target { color: COLOR, depth: Some(DEPTH), samples: 1 });
    let view = View::new(&Camera::framing(low, high, [0.5, 0.2, 1.0], 0.6, 1.0), 1.0);

    for _ in 0..frames {
        let mut encoder = device.create_command_encoder(&Default::default());
        let progress = stepper.record(&mut encoder, 1.0 / 60.0)?;
        let (load, store) = (wgpu::LoadOp::Clear(wgpu::Color::WHITE), wgpu::StoreOp::Store);
        let (ops, color) = (wgpu::Operations { load, store }, screen.create_view(&Default::default()));
        let color = wgpu::RenderPassColorAttachment { view: &color, depth_slice: None, resolve_target: None, ops };
        let depth_ops = Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store });
        let depth = wgpu::RenderPassDepthStencilAttachment { view: &depth, depth_ops, stencil_ops: None };
        let (color_attachments, depth_stencil_attachment) = (&[Some(color)], Some(depth));
        let what = wgpu::RenderPassDescriptor { color_attachments, depth_stencil_attachment, ..Default::default() };
        draw.record(&mut encoder.begin_render_pass(&what), &stepper, &view, progress.fraction)?;
        queue.submit([encoder.finish()]);
        stepper.settle()?;
    }
    Ok(read_back_picture(&device, &queue, &screen)?)
}
