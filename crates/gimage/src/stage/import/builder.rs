//! Puts placed primitives together into one mesh.

use std::path::Path;

use super::ImportOptions;
use super::attributes::Attribute;
use super::findings::Findings;
use super::matrix::{self, Matrix};
use super::primitive::Raw;
use super::weights;
use crate::base::mesh::{Channel, Mesh, NONE, Part, Semantic};
use crate::error::{Error, Result};
use crate::record::Severity;

/// The joints that a primitive follows.
#[derive(Clone, Copy)]
pub(crate) enum Follows<'a> {
    /// None.
    Nothing,
    /// Those of its skin; the list takes their indices to those of the skeleton.
    Skin(&'a [u32]),
    /// One joint of the skeleton, rigidly.
    Joint(u32),
}

/// A mesh under construction.
pub(crate) struct Builder<'a> {
    path: &'a Path,
    options: &'a ImportOptions,
    mesh: Mesh,
    /// Vertices gone through, used or not.
    visited: usize,
}

impl<'a> Builder<'a> {
    pub fn new(path: &'a Path, options: &'a ImportOptions) -> Self {
        Self { path, options, mesh: Mesh::default(), visited: 0 }
    }

    /// Adds a primitive, placed by `world`. Returns the vertices of the primitive that became vertices of the mesh, ascending; they are the last
    /// of the mesh.
    pub fn place(
        &mut self,
        raw: &Raw,
        world: &Matrix,
        mut part: Part,
        follows: Follows,
        findings: &mut Findings,
    ) -> Result<Vec<u32>> {
        // Vertices that come to nothing, placed again and again, take time too.
        self.visited += raw.positions.len() / 3;
        check_size(self.path, self.options, self.visited / 64, 0)?;
        let placed: Vec<[f64; 3]> = (raw.positions.as_chunks::<3>().0.iter())
            .map(|p| matrix::point(world, p.map(f64::from)).map(|x| x * self.options.unit))
            .collect();
        let sound = |v: &u32| placed[*v as usize].iter().all(|x| x.is_finite());
        let mut triangles: Vec<[u32; 3]> = raw.triangles.iter().copied().filter(|t| t.iter().all(sound)).collect();
        let lost = raw.triangles.len() - triangles.len();
        let message = "Triangles with a vertex that has no finite position were left out.";
        findings.add(Severity::Repair, "non-finite-positions", lost, message, || {
            let bad = raw.triangles.iter().flatten().find(|v| !sound(v));
            format!("{}, vertex {}", raw.element, bad.copied().unwrap_or(0))
        });
        let used = compact(triangles.as_flattened_mut(), placed.len());
        if matrix::determinant(world) < 0.0 {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let (first, corner) = (self.mesh.positions.len(), 3 * self.mesh.triangles.len());
        check_size(self.path, self.options, first + used.len(), self.mesh.triangles.len() + triangles.len())?;
        let positions: Vec<[f64; 3]> = used.iter().map(|&v| placed[v as usize]).collect();
        let mut attributes: Vec<Attribute> = raw.attributes.iter().map(|a| gather(a, &used)).collect();
        let map = if let Follows::Skin(map) = follows { Some(map) } else { None };
        weights::settle(&mut attributes, map, &positions, &raw.element, findings);
        if let Follows::Joint(joint) = follows {
            let list = |x: f32| (0..positions.len()).flat_map(|_| [x, 0.0, 0.0, 0.0]).collect();
            attributes.push(Attribute { semantic: Semantic::Joints(0), width: 4, values: list(joint as f32) });
            attributes.push(Attribute { semantic: Semantic::Weights(0), width: 4, values: list(1.0) });
        }
        for a in &mut attributes {
            if a.semantic == Semantic::Normal {
                turn_normals(world, &mut a.values);
            }
            self.add_channel(a, &triangles, corner, &raw.element, findings);
        }
        self.mesh.positions.extend(positions);
        self.mesh.triangles.extend(triangles.iter().map(|t| t.map(|v| v + first as u32)));
        self.mesh.triangle_part.resize(self.mesh.triangles.len(), self.mesh.parts.len() as u32);
        part.step = step(&raw.positions, world) * self.options.unit;
        part.grid = widest(world, raw.grid) * self.options.unit;
        self.mesh.parts.push(part);
        Ok(used)
    }

    fn add_channel(
        &mut self,
        a: &Attribute,
        triangles: &[[u32; 3]],
        corner: usize,
        element: &str,
        findings: &mut Findings,
    ) {
        let channels = &mut self.mesh.channels;
        let at = channels.iter().position(|c| c.semantic == a.semantic).unwrap_or_else(|| {
            let (semantic, width) = (a.semantic.clone(), a.width);
            channels.push(Channel { semantic, width, values: Vec::new(), corners: Vec::new() });
            channels.len() - 1
        });
        let channel = &mut channels[at];
        if channel.width != a.width {
            let message =
                "A custom attribute changes its number of components within the file; only the first was kept.";
            findings.add(Severity::Warning, "custom-attribute-width", 1, message, || element.into());
            return;
        }
        channel.corners.resize(corner, NONE);
        let first = (channel.values.len() / a.width) as u32;
        let sound: Vec<bool> = a.values.chunks(a.width).map(|v| v.iter().all(|x| x.is_finite())).collect();
        let message = "Attribute values that are not finite, and normals without a direction, were left out.";
        let lost = sound.iter().filter(|s| !**s).count();
        findings.add(Severity::Repair, "attribute-values", lost, message, || format!("{element}, {:?}", a.semantic));
        // A value nothing refers to must still be a number.
        channel.values.extend(a.values.iter().map(|&v| if v.is_finite() { v } else { 0.0 }));
        let value = |&v: &u32| if sound[v as usize] { first + v } else { NONE };
        channel.corners.extend(triangles.as_flattened().iter().map(value));
    }

    /// The mesh, with channels in the order of their semantics.
    pub fn finish(mut self) -> Mesh {
        for channel in &mut self.mesh.channels {
            channel.corners.resize(3 * self.mesh.triangles.len(), NONE);
        }
        self.mesh.channels.retain(|c| c.corners.iter().any(|&k| k != NONE));
        self.mesh.channels.sort_by(|a, b| a.semantic.cmp(&b.semantic));
        self.mesh
    }
}

/// The largest distance between numbers next to each other among the coordinates of finite positions, once they are placed.
fn step(positions: &[f32], world: &Matrix) -> f64 {
    let largest = positions.iter().map(|x| x.abs()).filter(|x| x.is_finite()).fold(0.0, f32::max);
    widest(world, f64::from(largest.next_up()) - f64::from(largest))
}

/// A length once it is placed, in the direction in which it becomes longest; 0 if that is not finite.
fn widest(world: &Matrix, length: f64) -> f64 {
    let scale = |c: usize| (0..3).map(|r| world[4 * c + r].powi(2)).sum::<f64>().sqrt();
    let longest = length * [0, 1, 2].map(scale).into_iter().fold(0.0, f64::max);
    if longest.is_finite() { longest } else { 0.0 }
}

/// Refuses a mesh over the limits.
pub(crate) fn check_size(path: &Path, options: &ImportOptions, vertices: usize, triangles: usize) -> Result<()> {
    let what = |of: &str, need: usize, limit: usize| {
        Err(Error::TooLarge {
            what: format!("{}: the mesh", path.display()),
            need: format!("{need} {of}"),
            limit: limit.to_string(),
            hint: "import fewer pieces, or raise the limits of the import".into(),
        })
    };
    if vertices > options.max_vertices {
        return what("vertices", vertices, options.max_vertices);
    }
    if triangles > options.max_triangles.min(u32::MAX as usize / 3) {
        return what("triangles", triangles, options.max_triangles);
    }
    Ok(())
}

/// Renumbers vertices so that only the used ones remain, in their order; returns their old numbers.
pub(crate) fn compact(corners: &mut [u32], vertices: usize) -> Vec<u32> {
    let mut new = vec![NONE; vertices];
    corners.iter().for_each(|&v| new[v as usize] = 0);
    let mut used = Vec::new();
    for (v, n) in new.iter_mut().enumerate().filter(|(_, n)| **n != NONE) {
        *n = used.len() as u32;
        used.push(v as u32);
    }
    corners.iter_mut().for_each(|v| *v = new[*v as usize]);
    used
}

fn gather(a: &Attribute, used: &[u32]) -> Attribute {
    let value = |&v: &u32| &a.values[v as usize * a.width..(v as usize + 1) * a.width];
    Attribute { semantic: a.semantic.clone(), width: a.width, values: used.iter().flat_map(value).copied().collect() }
}

/// Turns normals along; one without a direction becomes NaN, which is not kept.
fn turn_normals(world: &Matrix, values: &mut [f32]) {
    use crate::base::vec3::{add, norm, scale};
    let columns = matrix::normal_columns(world);
    // Scaled so that tiny and huge transforms do not leave the range of numbers.
    let size = columns.iter().flatten().fold(0.0f64, |a, b| a.max(b.abs()));
    let columns = columns.map(|c| scale(c, 1.0 / size));
    for n in values.as_chunks_mut::<3>().0 {
        let [x, y, z] = n.map(f64::from);
        let turned = add(add(scale(columns[0], x), scale(columns[1], y)), scale(columns[2], z));
        *n = scale(turned, 1.0 / norm(turned)).map(|c| c as f32);
    }
}
