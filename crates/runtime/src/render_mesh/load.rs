//! From `render.glb` to vertices that know their triangle of the cloth.

use std::sync::Arc;

use gimage_bundle::{Bundle, Frame, MapKind, Particle, RenderFile, RenderPrimitive, SurfacePoint, surface_normals};

use super::{Binding, Blended, Bound, RenderMesh, RenderPart};
use crate::cloth::Influence;
use crate::cpu::wrap::UNBOUND;
use crate::error::Result;
use crate::layout::{BlendRow, BoundRow};
use crate::number::real::with_w;

type Matrix = [f64; 16];

pub(super) fn load(bundle: &Bundle) -> Result<Option<RenderMesh>> {
    let (Some(bytes), Some(entry)) = (&bundle.render, &bundle.manifest.render) else { return Ok(None) };
    let file = RenderFile::parse(bytes)?;
    let cloth = Cloth::new(bundle)?;
    let (mut parts, mut uv, mut indices, mut rows) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut images, mut colors): (Vec<Vec<u8>>, Vec<[f32; 4]>) = Default::default();
    let primitives = file.primitives()?;
    let blends = cloth.blends.is_some() || primitives.iter().any(|p| !p.blends.is_empty());
    let mut blended = blends.then(|| Blended {
        sets: primitives.iter().map(|p| p.sets).max().unwrap_or(0).max(1),
        joints: bundle.manifest.skeleton.as_ref().map_or(0, |s| s.joints.len()).max(1),
        ..Blended::default()
    });
    for primitive in primitives {
        let (first, count, from) = (rows.len(), primitive.positions.len(), indices.len());
        let material = file.material(primitive.material);
        let bytes = material.base_image.and_then(|image| Some((image, file.image(image)?)));
        if let Some((image, bytes)) = bytes {
            images.resize(images.len().max(image + 1), Vec::new());
            if images[image].is_empty() {
                images[image] = bytes.to_vec();
            }
        }
        add(&cloth, &primitive, &entry.transform, &mut rows, blended.as_mut())?;
        // A mirrored part winds the other way.
        let columns = [0, 4, 8].map(|c| std::array::from_fn(|k| mul(&entry.transform, &primitive.world)[c + k]));
        let turn = |t: &[u32; 3]| if determinant(&columns) < 0.0 { [t[0], t[2], t[1]] } else { *t };
        let triangles = primitive.indices.as_chunks::<3>().0.iter().map(turn);
        indices.extend(triangles.flatten().map(|v| v + first as u32));
        uv.extend_from_slice(&primitive.uv);
        uv.resize(first + count, [0.0; 2]);
        if !primitive.colors.is_empty() {
            colors.resize(first, [1.0; 4]);
            colors.extend_from_slice(&primitive.colors);
        }
        parts.push(RenderPart {
            name: primitive.name,
            vertices: first..first + count,
            indices: from..indices.len(),
            material,
            material_index: primitive.material,
            is_bound: primitive.coords.iter().any(|c| c[0] >= 0.0),
        });
    }
    let image_names = (0..images.len()).map(|image| file.image_name(image)).collect();
    if !colors.is_empty() {
        colors.resize(rows.len(), [1.0; 4]);
    }
    let blended = blended.filter(|b| !b.rows.is_empty()).map(Arc::new);
    let code = |p: &Particle| if p.exists() { 1.0 } else { -1.0 };
    let rest = cloth.positions.iter().zip(&cloth.particles).map(|(p, of)| with_w(*p, code(of))).collect();
    let binding = Arc::new(Binding::new(Bound::new(rows, rest, cloth.normals)));
    Ok(Some(RenderMesh { parts, uv, colors, indices, images, image_names, binding, blended }))
}

/// The texels of a bundle at rest.
struct Cloth<'a> {
    bundle: &'a Bundle,
    particles: Vec<Particle>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    /// The map `blend`, if any texel is not on the cloth.
    blends: Option<Vec<f32>>,
}

impl<'a> Cloth<'a> {
    fn new(bundle: &'a Bundle) -> Result<Self> {
        let mut positions = Vec::new();
        for (index, piece) in bundle.manifest.pieces.iter().enumerate() {
            let image = bundle.image(index, &MapKind::Position);
            let at = |k: usize| image.and_then(|i| i.at(k).first_chunk().copied()).unwrap_or_default();
            positions.extend((0..piece.width as usize * piece.height as usize).map(at));
        }
        Ok(Cloth {
            bundle,
            particles: bundle.particles()?,
            positions,
            normals: surface_normals(bundle)?,
            blends: bundle.blends(),
        })
    }

    /// The triangle corners and barycentric weights of a coordinate; `None` where the piece has no surface.
    fn point(&self, [piece, u, v]: [f32; 3]) -> Option<([u32; 3], [f32; 2])> {
        let piece = self.bundle.manifest.pieces.get(piece as usize).filter(|_| piece.fract() == 0.0)?;
        let base = piece.first_particle;
        let exists = |k: u32| self.particles.get((base + k) as usize).is_some_and(|p| p.exists());
        let point = SurfacePoint::at((piece.width, piece.height), exists, [u, v])?;
        Some((point.texels.map(|k| base + k), point.weights))
    }

    /// The blend at a point of a triangle, 1 on the cloth.
    fn blend(&self, corners: [u32; 3], [s, t]: [f32; 2]) -> f32 {
        let Some(blends) = &self.blends else { return 1.0 };
        let [a, b, c] = corners.map(|k| blends.get(k as usize).copied().unwrap_or(1.0));
        (a + s * (b - a) + t * (c - a)).clamp(0.0, 1.0)
    }
}

/// Adds the vertices of a primitive.
fn add(
    cloth: &Cloth,
    primitive: &RenderPrimitive,
    transform: &Matrix,
    rows: &mut Vec<BoundRow>,
    mut blended: Option<&mut Blended>,
) -> Result<()> {
    let world = mul(transform, &primitive.world);
    let across = cofactors(&world);
    let normals = if primitive.normals.is_empty() { facets(primitive) } else { primitive.normals.clone() };
    for (v, p) in primitive.positions.iter().enumerate() {
        let turned = unit(apply(&across, normals[v].map(f64::from)));
        let [x, y, z, sign] = primitive.tangents.get(v).copied().unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let columns = [0, 4, 8].map(|c| [world[c], world[c + 1], world[c + 2]]);
        let along = unit(apply(&columns, [x, y, z].map(f64::from)));
        // A mirrored part has its bitangents on the other side.
        let sign = if determinant(&columns) < 0.0 { -sign } else { sign };
        let coord = primitive.coords.get(v).copied().filter(|c| c[0] >= 0.0);
        let row = match coord {
            None => {
                let at = apply(&columns, p.map(f64::from));
                let offset = std::array::from_fn(|k| (at[k] + world[12 + k]) as f32);
                BoundRow {
                    corners: [UNBOUND; 3],
                    weights: [0.0; 2],
                    offset,
                    normal: four(turned, 0.0),
                    tangent: four(along, sign),
                }
            }
            Some(coord) => {
                let (corners, weights) = cloth.point(coord).ok_or_else(|| gimage_bundle::Error::Render {
                    element: format!("mesh {}, primitive {}, vertex {v}", primitive.mesh, primitive.index),
                    problem: "it is not bound to a point of the surface".into(),
                })?;
                let share = cloth.blend(corners, weights) * primitive.blends.get(v).map_or(1.0, |x| x.clamp(0.0, 1.0));
                if let Some(blended) = blended.as_deref_mut().filter(|_| share < 1.0) {
                    let at = apply(&columns, p.map(f64::from));
                    blended.rows.push(BlendRow {
                        rest: std::array::from_fn(|k| (at[k] + world[12 + k]) as f32),
                        share,
                        normal: turned.map(|x| x as f32),
                        vertex: rows.len() as u32,
                        tangent: four(along, 0.0),
                    });
                    blended.follow(primitive, v)?;
                }
                let at = corners.map(|k| cloth.positions[k as usize]);
                let frame = Frame::new(at, corners.map(|k| cloth.normals[k as usize]), weights);
                let inward = |v: [f64; 3], w| four(frame.inward(v), w);
                let offset = primitive.offsets[v];
                BoundRow { corners, weights, offset, normal: inward(turned, 0.0), tangent: inward(along, sign) }
            }
        };
        rows.push(row);
    }
    Ok(())
}

impl Blended {
    /// Adds the joints of a vertex. Errors on joints that the bundle does not have.
    fn follow(&mut self, primitive: &RenderPrimitive, vertex: usize) -> Result<()> {
        let own = &primitive.influences[vertex * primitive.sets..(vertex + 1) * primitive.sets];
        for n in 0..self.sets {
            let (joints, weights) = own.get(n).copied().unwrap_or_default();
            if joints.iter().any(|j| *j as usize >= self.joints) {
                let problem = format!("it follows a joint that the bundle does not have; it has {}", self.joints);
                let element = format!("mesh {}, primitive {}, vertex {vertex}", primitive.mesh, primitive.index);
                return Err(gimage_bundle::Error::Render { element, problem }.into());
            }
            self.influences.push(Influence { joints, weights });
        }
        Ok(())
    }
}

/// Normals of a primitive that has none: the sum over the triangles of each vertex, weighed by area.
fn facets(primitive: &RenderPrimitive) -> Vec<[f32; 3]> {
    let mut sums = vec![[0.0f64; 3]; primitive.positions.len()];
    for t in primitive.indices.as_chunks::<3>().0 {
        let [a, b, c] = t.map(|v| primitive.positions[v as usize].map(f64::from));
        let (e, f): ([f64; 3], [f64; 3]) = (std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| c[k] - a[k]));
        let n = cross(e, f);
        t.iter().for_each(|&v| (0..3).for_each(|k| sums[v as usize][k] += n[k]));
    }
    sums.into_iter().map(|n| unit(n).map(|x| x as f32)).collect()
}

fn four([x, y, z]: [f64; 3], w: f32) -> [f32; 4] {
    [x as f32, y as f32, z as f32, w]
}

fn mul(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|n| (0..4).map(|k| a[4 * k + n % 4] * b[n / 4 * 4 + k]).sum())
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn determinant([a, b, c]: &[[f64; 3]; 3]) -> f64 {
    let n = cross(*b, *c);
    (0..3).map(|k| a[k] * n[k]).sum()
}

/// The matrix for normals up to a positive factor, as columns: the inverse transposed.
fn cofactors(m: &Matrix) -> [[f64; 3]; 3] {
    let columns = [0, 4, 8].map(|c| [m[c], m[c + 1], m[c + 2]]);
    let sign = if determinant(&columns) < 0.0 { -1.0 } else { 1.0 };
    let [a, b, c] = columns;
    [cross(b, c), cross(c, a), cross(a, b)].map(|n| n.map(|x| x * sign))
}

fn apply(columns: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| (0..3).map(|c| columns[c][k] * v[c]).sum())
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() { v.map(|x| x / length) } else { [0.0; 3] }
}
