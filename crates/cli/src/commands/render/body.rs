//! A character as it is drawn: the parts of its file that are not cloth, moved by its joints, and its clothes in the colours of the file.

use std::collections::HashMap;
use std::path::Path;

use gimage::import::{BaseColor, Character, ImportOptions, base_colors, import};
use gimage::mesh::{Mesh, Semantic};
use gimage::select::{Role, SelectOptions, roles};
use gimage_runtime::Cloth;
use gimage_runtime::draw::Facet;

use crate::exit::Failure;

/// Triangles of a character file, and the joints that they follow.
pub struct Body {
    points: Vec<[f64; 3]>,
    triangles: Vec<Triangle>,
    /// For each point its joints and their weights, of sum 1; none stays where it is.
    follows: Vec<Vec<(usize, f64)>>,
    /// The node of each joint, and its inverse bind matrix.
    joints: Vec<(usize, [f64; 16])>,
    /// For each cloth whose pieces are all parts of the file, its triangles in their colours.
    clothes: Vec<Option<Vec<Painted>>>,
}

/// A triangle of a cloth.
struct Painted {
    particles: [u32; 3],
    /// sRGB.
    color: [f32; 3],
}

struct Triangle {
    points: [usize; 3],
    normals: [[f64; 3]; 3],
    /// sRGB.
    color: [f32; 3],
}

impl Body {
    /// The parts of a file that a build with these options leaves out; `None` if there are none.
    pub fn read(
        path: &Path,
        (read, select): (&ImportOptions, &SelectOptions),
        character: &Character,
        cloths: &[Cloth],
    ) -> Result<Option<Self>, Failure> {
        let refused = |e: gimage::Error| Failure::refused(e.to_string());
        let mesh = import(path, read).map_err(refused)?.mesh;
        let is_drawn: Vec<bool> =
            roles(&mesh, select).map_err(refused)?.iter().map(|verdict| verdict.role != Role::Cloth).collect();
        let mut paints = Paints::new(base_colors(path, read).map_err(refused)?);
        let node = |name: &str| character.node(name).map_err(refused);
        let joint = |j: &gimage::mesh::Joint| Ok((node(&j.name)?, j.inverse_bind));
        let joints = mesh.skeleton.joints.iter().map(joint).collect::<Result<_, Failure>>()?;
        let normal = mesh.channel(&Semantic::Normal);
        let clothes = cloths.iter().map(|cloth| paints.cloth(&mesh, cloth)).collect();
        let (points, triangles) = (mesh.positions.clone(), Vec::new());
        let mut body = Body { points, triangles, follows: follows(&mesh), joints, clothes };
        for (t, part) in mesh.triangle_part.iter().enumerate().filter(|(_, part)| is_drawn[**part as usize]) {
            let face = face(mesh.corners(t));
            let own = |c: usize| Some(normal?.at(t, c)?.first_chunk::<3>()?.map(f64::from));
            body.triangles.push(Triangle {
                points: mesh.triangles[t].map(|v| v as usize),
                normals: [0, 1, 2].map(|c| own(c).unwrap_or(face)),
                color: paints.color(&mesh, t, &mesh.parts[*part as usize].material),
            });
        }
        let is_drawn = !body.triangles.is_empty() || body.clothes.iter().any(Option::is_some);
        Ok(is_drawn.then_some(body))
    }

    /// Where the triangles are for these transforms of the nodes to world space.
    pub fn facets(&self, worlds: &[[f64; 16]]) -> Vec<Facet> {
        let matrices: Vec<[f64; 16]> = self.joints.iter().map(|(node, bind)| product(&worlds[*node], bind)).collect();
        let blend = |own: &Vec<(usize, f64)>| {
            let sum = |k: usize| own.iter().map(|(j, w)| w * matrices[*j][k]).sum::<f64>();
            if own.is_empty() { STILL } else { std::array::from_fn(sum) }
        };
        let moves: Vec<[f64; 16]> = self.follows.iter().map(blend).collect();
        let facet = |t: &Triangle| Facet {
            corners: [0, 1, 2].map(|c| inset(&moves[t.points[c]], self.points[t.points[c]], t.normals[c])),
            normals: [0, 1, 2].map(|c| apply(&moves[t.points[c]], t.normals[c], 0.0)),
            color: t.color,
        };
        self.triangles.iter().map(facet).collect()
    }

    /// Whether a cloth is drawn in the colours of the file.
    pub fn wears(&self, cloth: usize) -> bool {
        self.clothes[cloth].is_some()
    }

    /// The triangles of a cloth in the colours of the file, where its particles are; none if it is not drawn so.
    pub fn worn(&self, cloth: usize, positions: &[[f32; 4]], normals: &[[f32; 4]]) -> Vec<Facet> {
        let three = |list: &[[f32; 4]], k: u32| list.get(k as usize).map_or([0.0; 3], |p| [p[0], p[1], p[2]]);
        let facet = |t: &Painted| Facet {
            corners: t.particles.map(|k| three(positions, k)),
            normals: t.particles.map(|k| three(normals, k)),
            color: t.color,
        };
        self.clothes[cloth].iter().flatten().map(facet).collect()
    }
}

const STILL: [f64; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

fn product(a: &[f64; 16], b: &[f64; 16]) -> [f64; 16] {
    std::array::from_fn(|n| (0..4).map(|k| a[4 * k + n % 4] * b[n / 4 * 4 + k]).sum())
}

fn apply(m: &[f64; 16], p: [f64; 3], w: f64) -> [f32; 3] {
    std::array::from_fn(|r| (m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r] * w) as f32)
}

/// How far \[m\] within its surface a body is drawn: cloth lies on colliders, which are that near to it at best.
const INSET: f64 = 0.004;

fn inset(m: &[f64; 16], p: [f64; 3], normal: [f64; 3]) -> [f32; 3] {
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-12);
    apply(m, [0, 1, 2].map(|c| p[c] - normal[c] * INSET / length), 1.0)
}

fn face([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// The joints of each vertex, from the first corner that has it.
fn follows(mesh: &Mesh) -> Vec<Vec<(usize, f64)>> {
    let mut out: Vec<Vec<(usize, f64)>> = vec![Vec::new(); mesh.positions.len()];
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
                own.extend(pairs.map(|(j, w)| (*j as usize, f64::from(*w))));
            }
            own.retain(|(joint, _)| *joint < mesh.skeleton.joints.len());
            let sum: f64 = own.iter().map(|(_, w)| w).sum();
            own.iter_mut().for_each(|(_, w)| *w /= sum);
        }
    }
    out
}

/// The materials of a file, with textures that are decoded when they are first used.
struct Paints {
    colors: Vec<BaseColor>,
    textures: HashMap<usize, Option<Texture>>,
}

/// Rows of linear pixels from the top.
struct Texture {
    width: usize,
    pixels: Vec<[f64; 3]>,
}

impl Paints {
    fn new(colors: Vec<BaseColor>) -> Self {
        Paints { colors, textures: HashMap::new() }
    }

    /// The triangles of a cloth in their colours; none unless each piece has the name of a part of the file.
    fn cloth(&mut self, mesh: &Mesh, cloth: &Cloth) -> Option<Vec<Painted>> {
        let uv = cloth.uv();
        let mut out = Vec::new();
        let indices = cloth.indices();
        for grid in cloth.grids() {
            let named = |p: &&gimage::mesh::Part| [&p.node, &p.mesh, &p.material].contains(&&grid.name);
            let material = mesh.parts.iter().find(named)?.material.clone();
            let range = grid.range();
            for t in indices.as_chunks::<3>().0.iter().filter(|t| range.contains(&(t[0] as usize))) {
                if t[0] == t[1] {
                    continue;
                }
                let corners = t.map(|k| uv.get(k as usize).copied().unwrap_or_default().map(f64::from));
                // Across a seam of the texture a triangle has the colour of one of its corners.
                let far = [1, 2].iter().any(|c| (0..2).any(|k| (corners[*c][k] - corners[0][k]).abs() > 0.5));
                let middle = [0, 1].map(|k| corners.iter().map(|uv| uv[k]).sum::<f64>() / 3.0);
                let at = if far { corners[0] } else { middle };
                out.push(Painted { particles: *t, color: self.at(&material, |_| Some(at)) });
            }
        }
        Some(out)
    }

    /// sRGB of a triangle: the colour of its material, times that of the texture in its middle. A pale grey without a material.
    fn color(&mut self, mesh: &Mesh, t: usize, material: &str) -> [f32; 3] {
        let middle = |set: u32| {
            let uv = mesh.channel(&Semantic::TexCoord(set))?;
            let corners = [uv.at(t, 0)?, uv.at(t, 1)?, uv.at(t, 2)?];
            Some([0, 1].map(|k| corners.iter().map(|uv| f64::from(uv[k])).sum::<f64>() / 3.0))
        };
        self.at(material, middle)
    }

    /// sRGB of a material where `uv` says, for its set of texture coordinates.
    fn at(&mut self, material: &str, uv: impl Fn(u32) -> Option<[f64; 2]>) -> [f32; 3] {
        let Some(index) = self.colors.iter().position(|c| c.material == material) else { return [0.75; 3] };
        let color = &self.colors[index];
        let texture = self.textures.entry(index).or_insert_with(|| Texture::decode(color.image.as_deref()?));
        let texel = texture.as_ref().zip(uv(color.tex_coord)).map_or([1.0; 3], |(texture, uv)| texture.at(uv));
        [0, 1, 2].map(|c| encoded(color.factor[c] * texel[c]))
    }
}

impl Texture {
    /// A PNG file of up to 4096 x 4096 pixels; no other kind is read.
    fn decode(bytes: &[u8]) -> Option<Self> {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
        decoder.set_transformations(png::Transformations::EXPAND | png::Transformations::STRIP_16);
        let mut reader = decoder.read_info().ok()?;
        let size = reader.output_buffer_size().filter(|n| *n <= 4 << 24)?;
        let mut data = vec![0; size];
        let info = reader.next_frame(&mut data).ok()?;
        let channels = info.color_type.samples();
        let pixel = |p: &[u8]| [0, 1, 2].map(|c| decoded(p[if channels < 3 { 0 } else { c }]));
        let pixels = data[..info.buffer_size()].chunks_exact(channels).map(pixel).collect();
        Some(Texture { width: info.width as usize, pixels })
    }

    /// The nearest pixel; the texture repeats.
    fn at(&self, uv: [f64; 2]) -> [f64; 3] {
        let size = [self.width, self.pixels.len() / self.width.max(1)];
        let [x, y] = [0, 1].map(|c| ((uv[c] - uv[c].floor()) * size[c] as f64) as usize);
        let index = y.min(size[1].saturating_sub(1)) * self.width + x.min(self.width.saturating_sub(1));
        self.pixels.get(index).copied().unwrap_or([1.0; 3])
    }
}

fn decoded(byte: u8) -> f64 {
    let c = f64::from(byte) / 255.0;
    if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

fn encoded(linear: f64) -> f32 {
    let c = linear.clamp(0.0, 1.0);
    (if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }) as f32
}
