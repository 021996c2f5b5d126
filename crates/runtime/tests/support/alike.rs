//! Comparisons of the forms of the GPU backend. They give the same bits, unless the adapter contracts: it may compute a * b + c with one
//! rounding in one shader and with two in another. Then results are compared within bounds.
//!
//! `GIMAGE_TOLERANCE=1` compares within bounds on every adapter. `GIMAGE_TOLERANCE=nudge` also moves the start of cloth in separate passes by a
//! unit in the last place, as an adapter that contracts does in each step.

use std::ops::Index;
use std::sync::OnceLock;

use gimage_runtime::*;

use super::run::Device;

/// Largest difference of positions \[m\] after [`super::run::Run::frames`] that counts as alike if the adapter contracts. Starts a
/// unit in the last place apart lead to 0.04 m among colliders that cloth starts in, and to 3e-4 m in the mean.
pub const ALIKE_M: f32 = 0.1;
/// The same for the mean over all particles. Few particles amplify rounding: those at edges of colliders.
pub const ALIKE_MEAN_M: f32 = 1e-3;
/// The same for the mean of unit normals.
pub const ALIKE_MEAN_NORMAL: f32 = 1e-2;

/// Positions now and before and normals of a cloth, as bits.
#[derive(Clone, Debug)]
pub struct Bits {
    lists: [Vec<[u32; 4]>; 3],
    tolerant: bool,
}

impl Bits {
    pub fn new(lists: [Vec<[f32; 4]>; 3], device: &Device) -> Self {
        let lists = lists.map(|list| list.into_iter().map(|p| p.map(f32::to_bits)).collect());
        Bits { lists, tolerant: tolerates(device) }
    }

    /// The first list that differs, and by how much.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let names = ["positions", "previous positions", "normals"];
        let mut lists = names.iter().zip(self.lists.iter().zip(&other.lists));
        lists.find_map(|(name, (a, b))| {
            if a == b {
                return None;
            }
            let first = a.iter().zip(b).position(|(a, b)| a != b);
            let (most, mean) = differences(a, b);
            let (limit, limit_mean) =
                if *name == "normals" { (3.0, ALIKE_MEAN_NORMAL) } else { (ALIKE_M, ALIKE_MEAN_M) };
            let alike = self.tolerant && a.len() == b.len() && most <= limit && mean <= limit_mean;
            (!alike).then(|| format!("{name} from particle {first:?} on: {most:e} at most, {mean:e} in the mean"))
        })
    }
}

impl PartialEq for Bits {
    fn eq(&self, other: &Self) -> bool {
        let difference = self.difference(other);
        difference.iter().for_each(|text| eprintln!("{text}"));
        difference.is_none()
    }
}

impl Index<usize> for Bits {
    type Output = Vec<[u32; 4]>;

    fn index(&self, list: usize) -> &Self::Output {
        &self.lists[list]
    }
}

/// The largest difference of a component, and the mean over all; not finite where a component is not.
fn differences(a: &[[u32; 4]], b: &[[u32; 4]]) -> (f32, f32) {
    let all = a.iter().flatten().zip(b.iter().flatten());
    let each: Vec<f32> = all.map(|(a, b)| (f32::from_bits(*a) - f32::from_bits(*b)).abs()).collect();
    let mean = each.iter().sum::<f32>() / each.len().max(1) as f32;
    let most = each.iter().fold(0.0, |most: f32, x| if x.is_nan() { f32::INFINITY } else { most.max(*x) });
    (most, if mean.is_nan() { f32::INFINITY } else { mean })
}

fn setting() -> Option<String> {
    std::env::var("GIMAGE_TOLERANCE").ok().filter(|value| !["", "0"].contains(&value.as_str()))
}

/// Whether results are compared within bounds.
pub fn tolerates(device: &Device) -> bool {
    static FOUND: OnceLock<bool> = OnceLock::new();
    *FOUND.get_or_init(|| {
        let contracts = contracts(device);
        let tolerant = contracts || setting().is_some();
        if tolerant {
            eprintln!("results are compared within bounds: the adapter contracts: {contracts}");
        }
        tolerant
    })
}

/// The largest difference \[m\] of the backends after a step: `limit`, or ten times as much if the adapter contracts.
pub fn rounding(device: &Device, limit: f32) -> f32 {
    if tolerates(device) { 10.0 * limit } else { limit }
}

/// A scene that starts a unit in the last place apart, if that is asked for.
pub fn nudged(mut scene: Scene, fused: bool) -> Scene {
    if !fused && setting().as_deref() == Some("nudge") {
        for cloth in &mut scene.cloths {
            let moved = cloth.positions().iter().map(|p| p.map(|x| x * (1.0 + f32::EPSILON))).collect();
            cloth.place(moved).unwrap();
        }
    }
    scene
}

/// The product of the first two numbers is 1 + 2^-11 + 2^-24, which rounds to the third.
const NUMBERS: [f32; 4] = [1.0 + 1.0 / 4096.0, 1.0 + 1.0 / 4096.0, 1.0 + 1.0 / 2048.0, 0.0];

/// Whether an adapter contracts a * b + c in any of the ways in which shaders write it.
pub fn contracts((device, queue): &Device) -> bool {
    let source = "@group(0) @binding(0) var<storage, read_write> x: array<vec4<f32>>;\n\
        @compute @workgroup_size(1) fn main() {\n\
          let a = x[0];\n\
          let sum = vec3<f32>(-a.z, 0.0, 0.0) + a.xyz * a.y;\n\
          x[1] = vec4<f32>(a.x * a.y - a.z, a.z - a.x * a.y, dot(vec2<f32>(a.x, -a.z), vec2<f32>(a.y, 1.0)), sum.x);\n\
        }";
    let source = wgpu::ShaderSource::Wgsl(source.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let descriptor = wgpu::BufferDescriptor { label: None, size: 32, usage, mapped_at_creation: false };
    let buffer = device.create_buffer(&descriptor);
    queue.write_buffer(&buffer, 0, &NUMBERS.map(f32::to_le_bytes).concat());
    let entries = [wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }];
    let layout = &pipeline.get_bind_group_layout(0);
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(1, 1, 1);
    drop(pass);
    queue.submit([encoder.finish()]);
    // Rounded twice, each of them is 0.
    read_back(device, queue, &buffer.into()).unwrap()[1].iter().any(|x| *x != 0.0)
}
