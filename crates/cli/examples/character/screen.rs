//! A screen: a texture of 256 x 256 pixels with a depth buffer. In a window it is the texture of the surface.
use std::error::Error;

use gimage_runtime::draw::{Draw, Target, View};
use gimage_runtime::{Stepper, read_back_picture, wgpu};

const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Draws cloths and colliders.
pub struct Screen {
    color: wgpu::Texture,
    depth: wgpu::TextureView,
    draw: Draw,
}

impl Screen {
    /// A screen of a device.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let texture = |format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: 256, height: 256, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            })
        };
        let less = Some((DEPTH, wgpu::CompareFunction::Less));
        Screen {
            color: texture(COLOR, wgpu::TextureUsages::COPY_SRC),
            depth: texture(DEPTH, wgpu::TextureUsages::empty()).create_view(&Default::default()),
            draw: Draw::new(device, queue, Target { color: COLOR, depth: less, samples: 1 }),
        }
    }

    /// Draws everything on white.
    pub fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        stepper: &Stepper,
        view: &View,
        fraction: f32,
    ) -> Result<(), Box<dyn Error>> {
        let (load, store) = (wgpu::LoadOp::Clear(wgpu::Color::WHITE), wgpu::StoreOp::Store);
        let (ops, color) = (wgpu::Operations { load, store }, self.color.create_view(&Default::default()));
        let color = wgpu::RenderPassColorAttachment { view: &color, depth_slice: None, resolve_target: None, ops };
        let depth_ops = Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store });
        let depth = wgpu::RenderPassDepthStencilAttachment { view: &self.depth, depth_ops, stencil_ops: None };
        let (color_attachments, depth_stencil_attachment) = (&[Some(color)], Some(depth));
        let what = wgpu::RenderPassDescriptor { color_attachments, depth_stencil_attachment, ..Default::default() };
        Ok(self.draw.record(&mut encoder.begin_render_pass(&what), stepper, view, fraction)?)
    }

    /// Waits, and reads the picture back.
    pub fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<[u8; 4]>, Box<dyn Error>> {
        Ok(read_back_picture(device, queue, &self.color)?)
    }
}
