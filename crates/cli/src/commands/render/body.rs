//! A character as it is drawn: the parts of its file that are not cloth, moved by its joints, and its clothes in the colours of the file.

use std::collections::HashMap;
use std::path::Path;

use gimage::import::{BaseColor, Character, ImportOptions, base_colors, import};
use gimage::mesh::{Mesh, Semantic};
use gimage::select::{Role, SelectOptions, divided, roles};
use gimage_runtime::draw::Facet;
use gimage_runtime::{Cloth, JointPoses, Skinning};
use rayon::prelude::*;

use super::covered;
use super::inward::{self, Around};
use super::paints::Paints;
use super::space::face;
use crate::exit::Failure;

/// Triangles of a character file, and the joints that they follow.
pub struct Body {
    /// Within the surface, where they are drawn.
    points: Vec<[f64; 3]>,
    triangles: Vec<Triangle>,
    /// For each point its joints and their weights, of sum 1; none stays where it is.
    follows: Vec<Vec<(u32, f64)>>,
    skinning: Skinning,
    /// The node of each joint, and its inverse bind matrix.
    joints: Vec<(usize, [f64; 16])>,
    /// For each cloth whose pieces are all parts of the file, its triangles in their colours.
    clothes: Vec<Option<Vec<Painted>>>,
}

/// A triangle of a cloth.
struct Painted {
    particles: [u32; 3],
    uv: [[f32; 2]; 3],
    paint: usize,
}

struct Triangle {
    points: [usize; 3],
    normals: [[f64; 3]; 3],
    uv: [[f32; 2]; 3],
    /// Linear.
    colors: [[f32; 4]; 3],
    paint: usize,
}

impl Body {
    /// The parts of a file that a build with these options leaves out, and these cloths in the paints of the file; `None` if there are none.
    pub fn read(
        path: &Path,
        (read, select): (&ImportOptions, &SelectOptions),
        character: &Character,
        (cloths, skinning): (&[Cloth], Skinning),
        paints: &mut Paints,
    ) -> Result<Option<Self>, Failure> {
        let refused = |e: gimage::Error| Failure::refused(e.to_string());
        let mesh = divided(import(path, read).map_err(refused)?.mesh, select);
        let is_drawn: Vec<bool> =
            roles(&mesh, select).map_err(refused)?.iter().map(|verdict| verdict.role != Role::Cloth).collect();
        let colors = base_colors(path, read).map_err(refused)?;
        let mut materials = Materials { colors, numbers: HashMap::new(), paints };
        let node = |name: &str| character.node(name).map_err(refused);
        let joint = |j: &gimage::mesh::Joint| Ok((node(&j.name)?, j.inverse_bind));
        let joints = mesh.skeleton.joints.iter().map(joint).collect::<Result<_, Failure>>()?;
        let (normal, color) = (mesh.channel(&Semantic::Normal), mesh.channel(&Semantic::Color(0)));
        let clothes = cloths.iter().map(|cloth| materials.cloth(&mesh, cloth)).collect();
        let ((points, hidden), triangles) = (inset(&mesh, &is_drawn), Vec::new());
        let mut body = Body { points, triangles, follows: follows(&mesh), skinning, joints, clothes };
        for (t, part) in mesh.triangle_part.iter().enumerate().filter(|(_, part)| is_drawn[**part as usize]) {
            if mesh.triangles[t].iter().all(|v| hidden[*v as usize]) {
                continue;
            }
            let face = face(mesh.corners(t));
            let own = |c: usize| Some(normal?.at(t, c)?.first_chunk::<3>()?.map(f64::from));
            let (paint, set) = materials.of(&mesh.parts[*part as usize].material);
            let uv = mesh.channel(&Semantic::TexCoord(set));
            let uv = |c: usize| uv?.at(t, c)?.first_chunk::<2>().map(|uv| materials.paints.uv(paint, *uv));
            let tint = |c: usize| color?.at(t, c)?.first_chunk::<4>().copied();
            body.triangles.push(Triangle {
                points: mesh.triangles[t].map(|v| v as usize),
                normals: [0, 1, 2].map(|c| own(c).unwrap_or(face)),
                uv: [0, 1, 2].map(|c| uv(c).unwrap_or_default()),
                colors: [0, 1, 2].map(|c| tint(c).unwrap_or([1.0; 4])),
                paint,
            });
        }
        let is_drawn = !body.triangles.is_empty() || body.clothes.iter().any(Option::is_some);
        Ok(is_drawn.then_some(body))
    }

    /// Where the triangles are for these transforms of the nodes to world space.
    pub fn facets(&self, worlds: &[[f64; 16]]) -> Vec<Facet> {
        let matrix = |(node, bind): &(usize, [f64; 16])| product(&worlds[*node], bind).map(|x| x as f32);
        let poses = JointPoses::new(self.skinning, &self.joints.iter().map(matrix).collect::<Vec<_>>());
        let place = |p: usize| poses.place(&self.follows[p], self.points[p]).map(|x| x as f32);
        let turn = |t: &Triangle, c: usize| poses.turn(&self.follows[t.points[c]], t.normals[c]).map(|x| x as f32);
        let facet = |t: &Triangle| Facet {
            corners: t.points.map(place),
            normals: [0, 1, 2].map(|c| turn(t, c)),
            uv: t.uv,
            colors: t.colors,
            paint: t.paint,
        };
        self.triangles.iter().map(facet).collect()
    }

    /// Whether a cloth is drawn in the colours of the file.
    pub fn wears(&self, cloth: usize) -> bool {
        self.clothes.get(cloth).is_some_and(Option::is_some)
    }

    /// The triangles of a cloth in the colours of the file, where its particles are; none if it is not drawn so.
    pub fn worn(&self, cloth: usize, positions: &[[f32; 4]], normals: &[[f32; 4]]) -> Vec<Facet> {
        let three = |list: &[[f32; 4]], k: u32| list.get(k as usize).map_or([0.0; 3], |p| [p[0], p[1], p[2]]);
        let facet = |t: &Painted| Facet {
            corners: t.particles.map(|k| three(positions, k)),
            normals: t.particles.map(|k| three(normals, k)),
            uv: t.uv,
            colors: [[1.0; 4]; 3],
            paint: t.paint,
        };
        self.clothes.get(cloth).into_iter().flatten().flatten().map(facet).collect()
    }
}

fn product(a: &[f64; 16], b: &[f64; 16]) -> [f64; 16] {
    std::array::from_fn(|n| (0..4).map(|k| a[4 * k + n % 4] * b[n / 4 * 4 + k]).sum())
}

/// The vertices of a mesh, moved into the body whose parts are drawn, and whether clothes hide them.
fn inset(mesh: &Mesh, is_drawn: &[bool]) -> (Vec<[f64; 3]>, Vec<bool>) {
    let of_body = |part: u32| is_drawn.get(part as usize).is_some_and(|drawn| *drawn);
    let mut is_of_body = vec![false; mesh.positions.len()];
    for (triangle, _) in mesh.triangles.iter().zip(&mesh.triangle_part).filter(|(_, part)| of_body(**part)) {
        triangle.iter().for_each(|v| is_of_body[*v as usize] = true);
    }
    let around = inward::normals(mesh, of_body);
    let all = || mesh.positions.par_iter().zip(&is_of_body);
    let normals: Vec<Option<[f64; 3]>> = all().map(|(p, of_body)| of_body.then(|| around.mean(p))).collect();
    let depths = covered::depths(mesh, |part| !of_body(part), &normals);
    let mut smooth = Around::new();
    for ((p, depth), _) in mesh.positions.iter().zip(&depths).zip(&is_of_body).filter(|(_, of_body)| **of_body) {
        smooth.add(p, 1.0, [depth.min(covered::DEEP)]);
    }
    let moved = |(p, normal): (&[f64; 3], &Option<[f64; 3]>)| {
        let [depth] = smooth.mean(p);
        normal.map_or(*p, |normal| [0, 1, 2].map(|k| p[k] - normal[k] * depth))
    };
    (mesh.positions.par_iter().zip(&normals).map(moved).collect(), depths.iter().map(|d| d.is_infinite()).collect())
}

/// The joints of each vertex, from the first corner that has it.
fn follows(mesh: &Mesh) -> Vec<Vec<(u32, f64)>> {
    let mut out: Vec<Vec<(u32, f64)>> = vec![Vec::new(); mesh.positions.len()];
    let sets: Vec<_> = (0..)
        .map_while(|n| Some((mesh.channel(&Semantic::Joints(n))?, mesh.channel(&Semantic::Weights(n))?)))
        .collect();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for (c, vertex) in triangle.iter().enumerate() {
            let own = &mut out[*vertex as usize];
            if !own.is_empty() {
                continue;
            }
            for (joints, weights) in &sets {
                let (Some(joints), Some(weights)) = (joints.at(t, c), weights.at(t, c)) else { continue };
                let pairs = joints.iter().zip(weights).filter(|(_, w)| **w > 0.0);
                own.extend(pairs.map(|(j, w)| (*j as u32, f64::from(*w))));
            }
            own.retain(|(joint, _)| (*joint as usize) < mesh.skeleton.joints.len());
            let sum: f64 = own.iter().map(|(_, w)| w).sum();
            own.iter_mut().for_each(|(_, w)| *w /= sum);
        }
    }
    out
}

/// The paints of the materials of a file, made when they are first used.
struct Materials<'a, 'b> {
    colors: Vec<BaseColor>,
    numbers: HashMap<usize, usize>,
    paints: &'a mut Paints<'b>,
}

impl Materials<'_, '_> {
    /// The paint of a material and its set of texture coordinates; paint 0 without a material.
    fn of(&mut self, material: &str) -> (usize, u32) {
        let Some(index) = self.colors.iter().position(|c| c.material == material) else { return (0, 0) };
        let color = &self.colors[index];
        (*self.numbers.entry(index).or_insert_with(|| self.paints.of_file(color)), color.tex_coord)
    }

    /// The triangles of a cloth in the paints of its parts; none unless each piece has the name of a part of the file.
    fn cloth(&mut self, mesh: &Mesh, cloth: &Cloth) -> Option<Vec<Painted>> {
        let uv = cloth.uv();
        let mut out = Vec::new();
        let indices = cloth.indices();
        for grid in cloth.grids() {
            let named = |p: &&gimage::mesh::Part| [&p.node, &p.mesh, &p.material].contains(&&grid.name);
            let material = &mesh.parts.iter().find(named)?.material;
            let (paint, _) = self.of(material);
            let range = grid.range();
            for t in indices.as_chunks::<3>().0.iter().filter(|t| range.contains(&(t[0] as usize))) {
                if t[0] == t[1] {
                    continue;
                }
                let corners = t.map(|k| uv.get(k as usize).copied().unwrap_or_default());
                // Across a seam of the texture a triangle has the colour of one of its corners.
                let far = [1, 2].iter().any(|c| (0..2).any(|k| (corners[*c][k] - corners[0][k]).abs() > 0.5));
                let corners = if far { [corners[0]; 3] } else { corners };
                out.push(Painted { particles: *t, uv: corners.map(|uv| self.paints.uv(paint, uv)), paint });
            }
        }
        Some(out)
    }
}
