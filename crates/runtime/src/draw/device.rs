//! Drawing with the host's device, into the host's render pass.

use std::collections::HashMap;
use std::num::NonZeroU64;

use bytemuck::{bytes_of, cast_slice};
use wgpu::{BindGroup, BindingResource, Buffer, BufferUsages};

use super::rows::{BodyRow, ViewRow};
use super::shader::{BODIES, MESH, PAINTS, TEXELS, UV, VIEW, Variant};
use super::surface::{self, Facet, Hidden, Paint};
use super::{Look, SolidLook, View, mesh, paints};
use crate::cloth::Cloth;
use crate::collider::{Collider, Shape};
use crate::error::{Error, Result};
use crate::gpu::{Ring, Span, filled};
use crate::handle::{ClothHandle, ClothRef};
use crate::layout::GridRow;
use crate::look::Looks;
use crate::shaders::Slot;
use crate::stepper::Stepper;

/// The target that a render pass draws into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Target {
    /// Format of the colour attachment. One that is not sRGB gets sRGB from the shader.
    pub color: wgpu::TextureFormat,
    /// Format of the depth attachment and when a fragment is in front: `Less`, or `Greater` for reversed depth.
    pub depth: Option<(wgpu::TextureFormat, wgpu::CompareFunction)>,
    /// Samples per pixel, 1 or 4.
    pub samples: u32,
}

/// Rows that can be in use before the encoder is submitted: a row a cloth and one for the colliders, each record.
const ROWS: u32 = 256;

/// Draws the cloths and colliders of one stepper. It keeps handles to the host's device and queue, and never submits.
pub struct Draw {
    device: wgpu::Device,
    queue: wgpu::Queue,
    target: Target,
    pipelines: HashMap<Variant, (wgpu::RenderPipeline, wgpu::BindGroupLayout)>,
    rows: Ring,
    looks: Looks,
    solid_look: SolidLook,
    cloths: HashMap<ClothHandle, DrawnCloth>,
    solids: Option<DrawnSolids>,
    surface: Option<DrawnSurface>,
    paints: Vec<Paint>,
    /// The paints as shaders read them, made when they are first needed.
    painted: Option<[Buffer; 2]>,
    /// Cloths and colliders that are left out.
    pub hidden: Hidden,
}

/// A cloth's own buffers and bindings, good for as long as the stepper's buffers are the same.
struct DrawnCloth {
    index: usize,
    source: Vec<Span>,
    variant: Variant,
    group: BindGroup,
    jump: f32,
}

struct DrawnSurface {
    vertices: u32,
    mesh: Buffer,
    group: BindGroup,
}

struct DrawnSolids {
    shapes: Vec<Shape>,
    ends: Vec<u32>,
    bodies: Buffer,
    group: BindGroup,
}

impl Draw {
    /// Makes no pipeline yet: each is made when it is first needed.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, target: Target) -> Self {
        Draw {
            rows: Ring::new(device, "views", size_of::<ViewRow>(), ROWS),
            device: device.clone(),
            queue: queue.clone(),
            target,
            pipelines: HashMap::new(),
            looks: Looks::default(),
            solid_look: SolidLook::default(),
            cloths: HashMap::new(),
            solids: None,
            surface: None,
            paints: Vec::new(),
            painted: None,
            hidden: Hidden::default(),
        }
    }

    /// How a cloth is drawn from now on; an index is that of the cloth when it is drawn. Texture coordinates are uploaded once.
    pub fn set_look(&mut self, cloth: impl Into<ClothRef>, look: Look) {
        let cloth = cloth.into();
        self.looks.set(cloth, look);
        self.cloths.retain(|handle, drawn| ![ClothRef::Index(drawn.index), (*handle).into()].contains(&cloth));
    }

    /// How colliders are drawn from now on.
    pub fn set_solid_look(&mut self, look: SolidLook) {
        self.solid_look = look;
        self.solids = None;
    }

    /// The paints of facets from the next [`Draw::set_surface`] on, which uploads them once: 48 bytes per paint and 16/3 bytes per pixel of their
    /// textures. Textures that do not fit a storage buffer of the device together begin with a smaller level.
    pub fn set_paints(&mut self, paints: Vec<Paint>) {
        self.paints = paints;
        (self.painted, self.surface) = (None, None);
    }

    /// Draws these triangles from now on, in place of those of the last call: an upload of 160 bytes per triangle, and one draw per record.
    pub fn set_surface(&mut self, facets: &[Facet]) {
        let rows = surface::rows(facets, self.paints.len());
        let vertices = 3 * rows.len() as u32;
        if let Some(drawn) = self.surface.as_ref().filter(|s| s.vertices == vertices) {
            self.queue.write_buffer(&drawn.mesh, 0, cast_slice(&rows));
            return;
        }
        self.surface = (vertices > 0).then(|| {
            let mesh = self.upload("surface", cast_slice(&rows));
            let [paints, texels] = self.painted();
            let bound = [(MESH, &mesh), (PAINTS, &paints), (TEXELS, &texels)];
            let bound = bound.map(|(binding, buffer)| (binding, buffer.as_entire_binding()));
            let group = self.group(Variant::Surface, bound.to_vec());
            DrawnSurface { vertices, mesh, group }
        });
    }

    fn painted(&mut self) -> [Buffer; 2] {
        if let Some(known) = &self.painted {
            return known.clone();
        }
        let limits = self.device.limits();
        let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let (rows, texels) = paints::rows(&self.paints, most);
        let made = [self.upload("paints", cast_slice(&rows)), self.upload("texels", cast_slice(&texels))];
        self.painted.insert(made).clone()
    }

    /// Draws every cloth, between its last two steps by `fraction` (see [`crate::Progress`]), and every collider. One
    /// draw a grid and one a collider; uploads 160 bytes per cloth and 48 bytes a collider. Up to 256 cloths and
    /// collider sets can be drawn before the encoder is submitted. Errors on a stepper without a device and on texture
    /// coordinates that do not fit their cloth.
    pub fn record(&mut self, pass: &mut wgpu::RenderPass, stepper: &Stepper, view: &View, fraction: f32) -> Result<()> {
        let handles = stepper.handles();
        self.looks.keep(handles);
        self.cloths.retain(|handle, _| handles.binary_search(handle).is_ok());
        for (index, (cloth, handle)) in stepper.scene().cloths.iter().zip(handles).enumerate() {
            if self.hidden.cloths.contains(&index) {
                continue;
            }
            let buffers = stepper.buffers(index).ok_or(Error::NoGpu("Draw::record"))?;
            let look = self.looks.of(index, *handle);
            let mut source = vec![buffers.now.clone(), buffers.before.clone(), buffers.normals.clone()];
            source.extend(buffers.holes.clone());
            if self.cloths.get(handle).is_none_or(|c| c.source != source || c.index != index) {
                let drawn = self.cloth(index, cloth, &look, source)?;
                self.cloths.insert(*handle, drawn);
            }
            let drawn = &self.cloths[handle];
            let row = ViewRow::cloth(view, &look, drawn.jump, fraction);
            let offset = self.rows.offset(&self.queue, bytes_of(&row));
            let Some((pipeline, _)) = self.pipelines.get(&drawn.variant) else { continue };
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &drawn.group, &[offset]);
            for (g, grid) in (0u32..).zip(cloth.grids()) {
                pass.draw(0..(grid.width - 1) * (grid.height - 1) * 6, g..g + 1);
            }
        }
        self.record_solids(pass, &stepper.scene().colliders, view);
        if let (Some(drawn), Some((pipeline, _))) = (&self.surface, self.pipelines.get(&Variant::Surface)) {
            let offset = self.rows.offset(&self.queue, bytes_of(&ViewRow::solids(view)));
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &drawn.group, &[offset]);
            pass.draw(0..drawn.vertices, 0..1);
        }
        Ok(())
    }

    fn record_solids(&mut self, pass: &mut wgpu::RenderPass, colliders: &[Collider], view: &View) {
        if colliders.is_empty() {
            return;
        }
        let shapes: Vec<_> = colliders.iter().map(|c| c.shape).collect();
        if self.solids.as_ref().is_none_or(|s| s.shapes != shapes) {
            self.solids = Some(self.meshes(shapes));
        }
        let (Some(solids), Some((pipeline, _))) = (&self.solids, self.pipelines.get(&Variant::Solids)) else { return };
        let bodies: Vec<_> = colliders.iter().map(|c| BodyRow::new(c, self.solid_look.color)).collect();
        self.queue.write_buffer(&solids.bodies, 0, cast_slice(&bodies));
        let offset = self.rows.offset(&self.queue, bytes_of(&ViewRow::solids(view)));
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &solids.group, &[offset]);
        let mut first = 0;
        for (c, end) in (0u32..).zip(&solids.ends) {
            if !self.hidden.colliders.contains(&(c as usize)) {
                pass.draw(first..*end, c..c + 1);
            }
            first = *end;
        }
    }

    fn cloth(&mut self, index: usize, cloth: &Cloth, look: &Look, source: Vec<Span>) -> Result<DrawnCloth> {
        let variant = Variant::Cloth { holes: source.len() > 3, uv: look.uv.is_some() };
        let row =
            |g: &crate::Grid| GridRow { first: g.first, width: g.width, height: g.height, soft: 0.0, rest: [0.0; 4] };
        let grids: Vec<_> = cloth.grids().iter().map(row).collect();
        let grids = self.upload("drawn grids", cast_slice(&grids));
        let mut bound = vec![(Slot::Grids as u32, grids.as_entire_binding())];
        let slots = [Slot::Now, Slot::Before, Slot::Normals, Slot::Holes].map(|s| s as u32);
        bound.extend(slots.into_iter().zip(source.iter().map(|s| BindingResource::Buffer(s.binding()))));
        let uv = look.uv.as_ref().map(|uv| {
            let (found, expected) = (uv.len(), cloth.len());
            let cloth = cloth.name().to_owned();
            let wrong = Error::Length { cloth, what: "texture coordinates", found, expected };
            if found == expected { Ok(self.upload("uv", cast_slice(uv))) } else { Err(wrong) }
        });
        let uv = uv.transpose()?;
        bound.extend(uv.iter().map(|b| (UV, b.as_entire_binding())));
        let group = self.group(variant, bound);
        let jump = look.jump(cloth.grids());
        Ok(DrawnCloth { index, variant, group, jump, source })
    }

    fn meshes(&mut self, shapes: Vec<Shape>) -> DrawnSolids {
        let (mut vertices, mut ends) = (Vec::new(), Vec::new());
        for shape in &shapes {
            vertices.extend(mesh::of(shape, self.solid_look.inset));
            ends.push(vertices.len() as u32);
        }
        let empty: BodyRow = bytemuck::Zeroable::zeroed();
        let bodies = self.upload("bodies", cast_slice(&vec![empty; shapes.len()]));
        let mesh = self.upload("meshes", cast_slice(&vertices));
        let group =
            self.group(Variant::Solids, vec![(BODIES, bodies.as_entire_binding()), (MESH, mesh.as_entire_binding())]);
        DrawnSolids { shapes, ends, bodies, group }
    }

    fn upload(&self, label: &str, contents: &[u8]) -> Buffer {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        filled(&self.device, label, contents, usage)
    }

    fn group(&mut self, variant: Variant, bound: Vec<(u32, BindingResource)>) -> BindGroup {
        let (_, layout) =
            self.pipelines.entry(variant).or_insert_with(|| pipeline(&self.device, &self.target, variant));
        let size = NonZeroU64::new(size_of::<ViewRow>() as u64);
        let view = wgpu::BufferBinding { buffer: &self.rows.buffer, offset: 0, size };
        let mut entries = vec![wgpu::BindGroupEntry { binding: VIEW, resource: BindingResource::Buffer(view) }];
        entries.extend(bound.into_iter().map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }));
        self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("draw"), layout, entries: &entries })
    }
}

fn pipeline(device: &wgpu::Device, target: &Target, variant: Variant) -> (wgpu::RenderPipeline, wgpu::BindGroupLayout) {
    let label = Some("draw");
    let size = NonZeroU64::new(size_of::<ViewRow>() as u64);
    let uniform = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: true,
        min_binding_size: size,
    };
    let storage = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only: true },
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let entry = |binding, ty, visibility| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
    let mut entries = vec![entry(VIEW, uniform, wgpu::ShaderStages::VERTEX_FRAGMENT)];
    let stage = |binding: &u32| match *binding {
        PAINTS | TEXELS => wgpu::ShaderStages::FRAGMENT,
        _ => wgpu::ShaderStages::VERTEX,
    };
    entries.extend(variant.storage().iter().map(|binding| entry(*binding, storage, stage(binding))));
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
    let source = wgpu::ShaderSource::Wgsl(variant.files().concat().into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &[Some(&layout)],
        ..Default::default()
    });
    // The GLSL of naga 30 for a mask of samples does not compile.
    let whole = variant == Variant::Surface && device.adapter_info().backend == wgpu::Backend::Gl;
    let constants = [("encode", f64::from(u8::from(!target.color.is_srgb()))), ("samples", f64::from(target.samples))];
    // Only surfaces ask for the number of samples.
    let constants = if variant == Variant::Surface { &constants[..] } else { &constants[..1] };
    let fragment_options = wgpu::PipelineCompilationOptions { constants, ..Default::default() };
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label,
        layout: Some(&pipeline_layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        // Both sides are drawn, and the fragment shader asks which it is.
        primitive: wgpu::PrimitiveState { cull_mode: None, ..Default::default() },
        depth_stencil: target.depth.map(|(format, compare)| wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(true),
            depth_compare: Some(compare),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: target.samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(if whole { "fragment_whole" } else { "fragment" }),
            compilation_options: fragment_options,
            targets: &[Some(target.color.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    (pipeline, layout)
}
