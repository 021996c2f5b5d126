//! Drawing on a canvas, or into a texture.

use gimage_runtime::draw::{Camera, Draw, Target, View};
use gimage_runtime::{Error, Stepper, read_back_picture_async, wgpu};

const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Pixels of a side.
const SIDE: u32 = 512;

/// The canvas, or a texture in its place.
pub struct Screen {
    surface: Option<wgpu::Surface<'static>>,
    texture: wgpu::Texture,
    depth: wgpu::TextureView,
    draw: Draw,
    view: View,
}

impl Screen {
    /// For what lies in a box.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        adapter: &wgpu::Adapter,
        surface: Option<wgpu::Surface<'static>>,
        (low, high): ([f32; 3], [f32; 3]),
    ) -> Result<Self, String> {
        let mut color = wgpu::TextureFormat::Rgba8UnormSrgb;
        if let Some(surface) = &surface {
            let config =
                surface.get_default_config(adapter, SIDE, SIDE).ok_or("the adapter cannot draw on the canvas")?;
            surface.configure(device, &config);
            color = config.format;
        }
        let texture = |format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            })
        };
        let depth = texture(DEPTH, wgpu::TextureUsages::empty()).create_view(&Default::default());
        let less = Some((DEPTH, wgpu::CompareFunction::Less));
        let draw = Draw::new(device, queue, Target { color, depth: less, samples: 1 });
        let view = View::new(&Camera::framing(low, high, [0.5, 0.2, 1.0], 0.6, 1.0), 1.0);
        Ok(Screen { surface, texture: texture(color, wgpu::TextureUsages::COPY_SRC), depth, draw, view })
    }

    /// Records a picture. Returns what is to be presented after the submission.
    pub fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        stepper: &Stepper,
        fraction: f32,
    ) -> Result<Option<wgpu::SurfaceTexture>, Error> {
        let frame = match self.surface.as_ref().map(wgpu::Surface::get_current_texture) {
            None => None,
            Some(wgpu::CurrentSurfaceTexture::Success(t) | wgpu::CurrentSurfaceTexture::Suboptimal(t)) => Some(t),
            // The page is hidden: there is no picture in this frame.
            Some(_) => return Ok(None),
        };
        let color = frame.as_ref().map_or(&self.texture, |f| &f.texture).create_view(&Default::default());
        let (load, store) = (wgpu::LoadOp::Clear(wgpu::Color::WHITE), wgpu::StoreOp::Store);
        let ops = wgpu::Operations { load, store };
        let color = wgpu::RenderPassColorAttachment { view: &color, depth_slice: None, resolve_target: None, ops };
        let depth_ops = Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard });
        let depth = wgpu::RenderPassDepthStencilAttachment { view: &self.depth, depth_ops, stencil_ops: None };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(color)],
            depth_stencil_attachment: Some(depth),
            ..Default::default()
        });
        self.draw.record(&mut pass, stepper, &self.view, fraction)?;
        drop(pass);
        Ok(frame)
    }

    /// The last picture in the texture.
    pub async fn picture(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<[u8; 4]>, Error> {
        read_back_picture_async(device, queue, &self.texture).await
    }
}
