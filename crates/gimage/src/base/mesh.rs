//! The indexed triangle mesh every stage of the preprocessor works on.

use std::collections::HashSet;

/// Marks a corner that has no value in a [`Channel`].
pub const NONE: u32 = u32::MAX;

/// A triangle mesh with attributes on its corners. Positions are in metres, right-handed, Y up.
///
/// Attributes are kept apart from positions: a vertex on a UV seam is one vertex here, with two texture coordinates on
/// its corners.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions \[m\].
    pub positions: Vec<[f64; 3]>,
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle, the index in [`Mesh::parts`] of where it came from.
    pub triangle_part: Vec<u32>,
    /// Where the triangles came from.
    pub parts: Vec<Part>,
    /// Corner attributes.
    pub channels: Vec<Channel>,
    /// The joints that `Joints` channels index.
    pub skeleton: Skeleton,
}

/// One primitive of the source file, as placed in the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// glTF node or OBJ object.
    pub node: String,
    /// glTF mesh or OBJ group.
    pub mesh: String,
    /// Index of the primitive in its mesh.
    pub primitive: u32,
    /// Material name, empty if there is none.
    pub material: String,
    /// Whether the file has parts of the same node and mesh with other materials, so that the material belongs to its name.
    pub has_siblings: bool,
    /// The number of the connected component that it is, where flags choose by number ([`crate::select::divided`]).
    pub component: Option<u32>,
    /// Largest distance \[m\] between numbers next to each other that the file could have stored for a coordinate, as it is placed; 0 if
    /// that is not known, as of text.
    pub step: f64,
    /// Width \[m\] of the cells of the grid to which the file has rounded positions (Draco, `KHR_mesh_quantization`), as it is placed; 0 if there
    /// is none. Primitives have grids of their own.
    pub grid: f64,
}

/// The meaning of the values of a [`Channel`].
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Semantic {
    /// Unit normal, width 3, in the space of the positions.
    Normal,
    /// Texture coordinate set `n`, width 2, glTF convention (v down).
    TexCoord(u32),
    /// Colour set `n`, width 4, linear 0..1.
    Color(u32),
    /// Joint indices set `n`, width 4, whole numbers indexing [`Skeleton::joints`].
    Joints(u32),
    /// Joint weights set `n`, width 4.
    Weights(u32),
    /// A custom attribute, by its name with the leading underscore.
    Custom(String),
}

/// One attribute, given at the corners of triangles by index, so that values shared by corners are stored once.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The meaning of the values.
    pub semantic: Semantic,
    /// Floats for each value, 1..=4 (custom attributes up to 16).
    pub width: usize,
    /// The values, `width` floats each.
    pub values: Vec<f32>,
    /// For corner `c` of triangle `t`, at `3 t + c`: the index of its value, or [`NONE`].
    pub corners: Vec<u32>,
}

impl Channel {
    /// The value at corner `c` of triangle `t`.
    pub fn at(&self, t: usize, c: usize) -> Option<&[f32]> {
        let k = self.corners[3 * t + c];
        (k != NONE).then(|| &self.values[k as usize * self.width..(k as usize + 1) * self.width])
    }
}

/// The joints a skinned mesh follows; empty if it is not skinned.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skeleton {
    /// The joints.
    pub joints: Vec<Joint>,
}

/// One joint of a [`Skeleton`].
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name of its node.
    pub name: String,
    /// Index of the nearest ancestor that is a joint too.
    pub parent: Option<u32>,
    /// Takes a position of the mesh (in world space, as stored here) to the joint's space; column-major.
    pub inverse_bind: [f64; 16],
    /// The joint's own transform to world space in the file's pose; column-major.
    pub world: [f64; 16],
}

impl Mesh {
    /// The corner positions of triangle `t` \[m\].
    pub fn corners(&self, t: usize) -> [[f64; 3]; 3] {
        self.triangles[t].map(|v| self.positions[v as usize])
    }

    /// The unit normal of triangle `t`; 0 without area.
    pub fn facing(&self, t: usize) -> [f64; 3] {
        let [a, b, c] = self.corners(t);
        let n = crate::base::vec3::cross(crate::base::vec3::sub(b, a), crate::base::vec3::sub(c, a));
        if crate::base::vec3::dot(n, n) > 0.0 { crate::base::vec3::normalize(n) } else { [0.0; 3] }
    }

    /// Area of triangle `t` \[m2\].
    pub fn triangle_area(&self, t: usize) -> f64 {
        let [a, b, c] = self.corners(t);
        0.5 * crate::base::vec3::norm(crate::base::vec3::cross(
            crate::base::vec3::sub(b, a),
            crate::base::vec3::sub(c, a),
        ))
    }

    /// The joints that move some of the triangles that `is_of` holds for.
    pub(crate) fn followed(&self, is_of: impl Fn(usize) -> bool) -> HashSet<u32> {
        let mut found = HashSet::new();
        let sets =
            (0..).map_while(|n| Some((self.channel(&Semantic::Joints(n))?, self.channel(&Semantic::Weights(n))?)));
        for (joints, weights) in sets {
            for t in (0..self.triangles.len()).filter(|t| is_of(*t)) {
                for (joints, weights) in (0..3).filter_map(|c| Some((joints.at(t, c)?, weights.at(t, c)?))) {
                    found.extend(joints.iter().zip(weights).filter(|(_, w)| **w > 0.0).map(|(joint, _)| *joint as u32));
                }
            }
        }
        found
    }

    /// The channel of a kind.
    pub fn channel(&self, semantic: &Semantic) -> Option<&Channel> {
        self.channels.iter().find(|c| &c.semantic == semantic)
    }

    /// Corners of the axis-aligned box around the vertices that triangles use, or `None` without triangles.
    pub fn bounds(&self) -> Option<([f64; 3], [f64; 3])> {
        let mut it = self.triangles.iter().flatten().map(|&v| self.positions[v as usize]);
        let first = it.next()?;
        Some(it.fold((first, first), |(mut lo, mut hi), p| {
            for k in 0..3 {
                lo[k] = lo[k].min(p[k]);
                hi[k] = hi[k].max(p[k]);
            }
            (lo, hi)
        }))
    }

    /// Length of the diagonal of [`Mesh::bounds`] \[m\], 0 without triangles.
    pub fn diagonal(&self) -> f64 {
        self.bounds().map_or(0.0, |(lo, hi)| crate::base::vec3::norm(crate::base::vec3::sub(hi, lo)))
    }
}
