//! A walking figure in a T-shirt and a skirt: body, garments, skeleton, textures and animations in one file.

pub mod nets;

mod cape;
mod file;
mod gait;
mod png;
mod pose;
mod rig;
mod sit;
mod wear;

use file::{Look, Part};
use nets::{mesh, normals};
use rig::{Rig, four};

use crate::body::Body;
use crate::math::V3;
use crate::surface::Surface;

/// Side of the cells \[m\] of the mesh of the body.
const CELL: f64 = 0.018;
/// The box that is meshed.
const LOW: V3 = [-0.72, -0.036, -0.236];
const HIGH: V3 = [0.72, 1.836, 0.250];
/// The range of z and the height \[m\] that the texture of the body spans.
const DEPTH: [f64; 2] = [-0.2, 0.25];
const HEIGHT: f64 = 1.8;

/// The file `figure.glb`.
pub fn figure() -> Vec<u8> {
    file::write(&parts(&Rig::new()), rig::joints(), gait::clips())
}

/// The same figure in a cape too. No file of the repository holds it.
pub fn figure_in_cape() -> Vec<u8> {
    let rig = Rig::new();
    let mut parts = parts(&rig);
    let below: Vec<V3> = parts.iter().flat_map(|p| p.surface.positions.iter().map(|x| x.map(f64::from))).collect();
    parts.push(cape::cape(&rig, &below));
    file::write(&parts, rig::joints(), gait::clips())
}

/// Body, T-shirt and skirt.
fn parts(rig: &Rig) -> Vec<Part> {
    let [shirt, skirt] = std::thread::scope(|scope| {
        let makers = [wear::shirt as fn(&Rig) -> Part, wear::skirt];
        makers.map(|make| scope.spawn(move || make(rig))).map(|thread| thread.join().expect("a garment"))
    });
    vec![person(rig), shirt, skirt]
}

/// The body.
fn person(rig: &Rig) -> Part {
    let body = Body::person();
    let mesh = mesh(&body, LOW, HIGH, CELL);
    let grid = |p: &V3| p.map(|c| ((c * 1e5).round() / 1e5) as f32);
    let uv = |p: &V3| {
        let across = (p[2] - DEPTH[0]) / (DEPTH[1] - DEPTH[0]);
        // Textures repeat.
        [across, 1.0 - p[1] / HEIGHT].map(|c| c.clamp(0.01, 0.995) as f32)
    };
    let surface = Surface {
        positions: mesh.points.iter().map(grid).collect(),
        normals: normals(&body, &mesh).iter().map(|n| n.map(|c| c as f32)).collect(),
        uvs: mesh.points.iter().map(uv).collect(),
        indices: mesh.triangles.iter().flatten().map(|&i| i as u32).collect(),
        particle: (0..mesh.points.len()).collect(),
        metres_per_uv: HEIGHT,
    };
    let follows = mesh.points.iter().map(|p| four(&rig.weights(*p))).collect();
    Part { name: "Body", material: "skin", look: skin(), surface, follows }
}

/// Skin, hair and shoes, as seen from the side.
fn skin() -> Look {
    const WIDTH: usize = 64;
    const ROWS: usize = 256;
    let color = |k: usize| {
        let z = DEPTH[0] + (DEPTH[1] - DEPTH[0]) * ((k % WIDTH) as f64 + 0.5) / WIDTH as f64;
        let y = HEIGHT * (1.0 - ((k / WIDTH) as f64 + 0.5) / ROWS as f64);
        let forehead = 0.095 - 0.9 * (1.74 - y).max(0.0);
        let temple = if y < 1.68 { 0.02 } else { 0.1 };
        if y > 1.545 && z < f64::min(forehead, temple) - if y < 1.60 { 0.03 } else { 0.0 } {
            1
        } else if y < 0.088 {
            if y < 0.016 { 3 } else { 2 }
        } else {
            0
        }
    };
    let pixels: Vec<u8> = (0..WIDTH * ROWS).map(color).collect();
    let palette = [[255, 255, 255], [84, 70, 66], [72, 92, 150], [235, 240, 255]];
    Look { factor: [0.72, 0.45, 0.33], image: png::png(WIDTH, &pixels, &palette) }
}
