//! Pictures from the GPU: a texture instead of a window, read back when it is done.

use gimage_runtime::draw::{Draw, Target, View};
use gimage_runtime::{Stepper, read_back_picture, wgpu};

use crate::exit::Failure;

const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
const SAMPLES: u32 = 4;

/// Textures of one size.
pub struct Offscreen {
    pub draw: Draw,
    device: wgpu::Device,
    queue: wgpu::Queue,
    samples: wgpu::TextureView,
    depth: wgpu::TextureView,
    picture: wgpu::Texture,
}

impl Offscreen {
    /// Errors where the device has no textures or buffers so large.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, (width, height): (u32, u32)) -> Result<Self, Failure> {
        let limits = device.limits();
        let stride = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(stride) * u64::from(height);
        if width.max(height) > limits.max_texture_dimension_2d || bytes > limits.max_buffer_size {
            let most = limits.max_texture_dimension_2d;
            return Err(Failure::refused(format!(
                "--size {width}x{height} is larger than the adapter supports (sides of {most}); use --backend cpu"
            )));
        }
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let texture = |format, sample_count, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some("picture"),
                size,
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let target = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let view = |texture: wgpu::Texture| texture.create_view(&Default::default());
        let less = wgpu::CompareFunction::Less;
        Ok(Offscreen {
            draw: Draw::new(device, queue, Target { color: COLOR, depth: Some((DEPTH, less)), samples: SAMPLES }),
            device: device.clone(),
            queue: queue.clone(),
            samples: view(texture(COLOR, SAMPLES, target)),
            depth: view(texture(DEPTH, SAMPLES, target)),
            picture: texture(COLOR, 1, target | wgpu::TextureUsages::COPY_SRC),
        })
    }

    /// Draws, waits and reads back: sRGB pixels, row by row from the top.
    pub fn paint(&mut self, stepper: &Stepper, view: &View, fraction: f32) -> Result<Vec<[u8; 4]>, Failure> {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let resolved = self.picture.create_view(&Default::default());
        let linear = |c: f32| f64::from(if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) });
        let [r, g, b] = view.background.map(linear);
        let clear = wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.samples,
                depth_slice: None,
                resolve_target: Some(&resolved),
                ops: wgpu::Operations { load: clear, store: wgpu::StoreOp::Discard },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        self.draw.record(&mut pass, stepper, view, fraction)?;
        drop(pass);
        self.queue.submit([encoder.finish()]);
        let mut pixels = read_back_picture(&self.device, &self.queue, &self.picture)?;
        pixels.iter_mut().for_each(|p| p[3] = 255);
        Ok(pixels)
    }
}
