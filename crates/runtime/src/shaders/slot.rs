//! Bindings of shaders.

use bytemuck::cast_slice;

use crate::cloth::{Cloth, Compliance, Rest, Tethers};
use crate::cpu::fabric::meeting::others::MAX_OTHERS;
use crate::cpu::fabric::partners::MAX_PARTNERS;
use crate::layout::{FAULT_BYTES, FrameRow, GridRow, JobRow, LinkRow};
use crate::levels::joint;

macro_rules! slots {
    ($($slot:ident $name:literal,)*) => {
        /// A resource that can be bound. The number is the binding in every shader.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Slot { $($slot,)* }

        impl Slot {
            /// All of them.
            pub const ALL: &[Slot] = &[$(Slot::$slot,)*];

            pub fn name(self) -> &'static str {
                match self { $(Slot::$slot => $name,)* }
            }
        }
    };
}

slots! {
    Step "step",
    Grids "grids",
    Now "now",
    Before "before",
    Rest "rest",
    Starts "starts",
    Members "members",
    Solids "solids",
    Normals "normals",
    Field "field",
    Holes "holes",
    Action "action",
    Chosen "chosen",
    Candidates "candidates",
    Found "found",
    Partial "partial",
    Fastest "fastest",
    Soft "soft",
    Sums "sums",
    Tethers "tethers",
    Levels "levels",
    Nodes "nodes",
    Limits "limits",
    Faults "faults",
    Good "good",
    Weights "weights",
    Bends "bends",
    Moments "moments",
    Lost "lost",
    Cells "cells",
    Yielding "yielding",
    Frame "frame",
    Jobs "jobs",
    Strain "strain",
    Next "next",
    Passed "passed",
    Losing "losing",
    Summing "summing",
    Supports "supports",
    Holding "holding",
    Changes "changes",
    Mates "mates",
    Links "links",
    Ties "ties",
    Targets "targets",
    Bounds "bounds",
    Indices "indices",
    Tangents "tangents",
    Charts "charts",
    Lists "lists",
    Lasting "lasting",
    Scratch "scratch",
    Batch "batch",
    Part "part",
    Rings "rings",
    Drifts "drifts",
    Influences "influences",
    Skinned "skinned",
    Table "table",
    Origin "origin",
    OriginBefore "origin_before",
    Spare "spare",
    Beside "beside",
    Stitches "stitches",
    Pulls "pulls",
    BoundVertices "bound_vertices",
    Wrapped "wrapped",
    Kin "kin",
    Homes "homes",
    Boxes "boxes",
    Partners "partners",
    Pushes "pushes",
    Backs "backs",
    BackDrifts "back_drifts",
    BackInfluences "back_influences",
    BackSkinned "back_skinned",
    Blending "blending",
    Shadows "shadows",
    Others "others",
    Struck "struck",
    Shadow "shadow",
    Jumps "jumps",
    Covers "covers",
    MeshIndices "mesh_indices",
    LeftIndices "left_indices",
    Airs "airs",
    Goals "goals",
    Places "places",
    Bases "bases",
    Ways "ways",
    Faces "faces",
    Counts "counts",
    SurfacePlanes "surface_planes",
    SurfaceShape "surface_shape",
    SurfaceVertices "surface_vertices",
    SurfaceTriangles "surface_triangles",
    SurfaceBoxes "surface_boxes",
    SurfaceHints "surface_hints",
    Wearers "wearers",
    FoundPlanes "found_planes",
}

/// Bytes of a particle's planes at the surface of a body, and of what it knows of that surface; and of a vertex of the surface.
pub const PLANE_BYTES: usize = 2 * 4 * 16;
pub const HINT_BYTES: usize = 5 * 16;
pub const WEARER_BYTES: usize = 4 * 16;
pub const VERTEX_BYTES: usize = 4 * 16;

/// Lists that frames only read, and what they are lists of: a type of WGSL, or a struct that shaders declare. In whole frames they lie
/// in [`Slot::Lists`], whose first numbers, in this order, say where each begins.
pub const LISTED: [(Slot, Option<&str>); 22] = [
    (Slot::Jobs, None),
    (Slot::Grids, None),
    // Seam rings: ring r is members[starts[r]] up to, not including, members[starts[r + 1]].
    (Slot::Starts, Some("u32")),
    (Slot::Members, Some("u32")),
    (Slot::Rest, Some("vec4<f32>")),
    (Slot::Soft, Some("vec4<f32>")),
    (Slot::Tethers, Some("vec2<u32>")),
    (Slot::Weights, Some("vec4<f32>")),
    (Slot::Bends, Some("vec2<f32>")),
    (Slot::Cells, Some("vec4<f32>")),
    (Slot::Yielding, Some("vec4<f32>")),
    (Slot::Targets, Some("vec4<f32>")),
    (Slot::Holes, Some("u32")),
    // The seam ring of each particle, by its number in the cloth, all ones for none.
    (Slot::Rings, Some("u32")),
    // How fast each target moves, and 1 for a particle that follows joints while it is pinned, else 0.
    (Slot::Drifts, Some("vec4<f32>")),
    // Three rows per particle, see shaders/part/stitched.wgsl.
    (Slot::Stitches, Some("vec4<u32>")),
    // The spheres of backstops, centre and radius, and how fast each moves.
    (Slot::Backs, Some("vec4<f32>")),
    (Slot::BackDrifts, Some("vec4<f32>")),
    // Two planes per particle of cloth on the surface of a body, see shaders/surface_contact.wgsl.
    (Slot::SurfacePlanes, Some("vec4<f32>")),
    // Heads and rows of coarser grids (shaders/part/level.wgsl), their limits, and what ties their nodes.
    (Slot::Levels, Some("vec4<u32>")),
    (Slot::Limits, Some("vec4<f32>")),
    (Slot::Ties, Some("vec4<u32>")),
];

impl Slot {
    /// Bytes of the entries that each texel of a cloth has in a list that shaders only read, if a particle has a number of tethers. None
    /// for other slots, and where the cloth has no such list.
    pub fn row(self, cloth: &Cloth, tethers: usize) -> Option<usize> {
        let there = |yes: bool, bytes: usize| yes.then_some(bytes);
        match self {
            Slot::Rest => there(matches!(cloth.rest(), Rest::Image(_)), 16),
            Slot::Soft => there(matches!(cloth.compliance, Compliance::Image(_)), 16),
            Slot::Cells => there(cloth.membrane().is_some(), 32),
            Slot::Weights => there(cloth.bending().is_some(), 16),
            Slot::Bends => there(cloth.bending().is_some(), 8),
            Slot::Tethers => there(tethers > 0, 8 * tethers),
            Slot::Targets => there(cloth.is_aimed(), 16),
            Slot::Drifts => there(cloth.follows_joints(), 16),
            Slot::Backs => there(cloth.backstops.is_some(), 16),
            Slot::BackDrifts => there(cloth.backstops.is_some() && cloth.follows_joints(), 16),
            Slot::SurfacePlanes => there(cloth.body().is_some(), PLANE_BYTES),
            Slot::Holes => there(cloth.is_cut(), 4),
            Slot::Stitches => there(cloth.sewing().is_some(), 48),
            Slot::Rings => there(cloth.ring_count() > 0, 4),
            _ => None,
        }
    }

    /// Vectors of four per particle in a list of these that frames or calls of a host change.
    pub fn vectors(self) -> u64 {
        if self == Slot::SurfacePlanes { PLANE_BYTES as u64 / 16 } else { 1 }
    }

    /// The entries of all texels in such a list, before any cut; without those that frames or calls of a host change.
    pub fn texels(self, cloth: &Cloth, held: &Tethers) -> Vec<u8> {
        let list = |data: &[[f32; 4]]| cast_slice(data).to_vec();
        match self {
            Slot::Rest => {
                if let Rest::Image(rest) = cloth.rest() {
                    list(rest)
                } else {
                    Vec::new()
                }
            }
            Slot::Soft => {
                if let Compliance::Image(soft) = &cloth.compliance {
                    list(soft)
                } else {
                    Vec::new()
                }
            }
            Slot::Cells => cloth.membrane().map(|m| list(&m.cells)).unwrap_or_default(),
            Slot::Weights => cloth.bending().map(|b| list(&b.weights)).unwrap_or_default(),
            Slot::Bends => {
                let rows = cloth.bending().into_iter().flat_map(|b| b.compliance.iter().copied().zip(b.bounds(cloth)));
                cast_slice(&rows.map(|(compliance, bound)| [compliance, bound]).collect::<Vec<_>>()).to_vec()
            }
            Slot::Tethers => {
                let end = |a: &crate::Anchor| if a.exists() { a.particle } else { u32::MAX };
                let rows: Vec<_> = held.anchors.iter().map(|a| [end(a), a.distance.to_bits()]).collect();
                cast_slice(&rows).to_vec()
            }
            Slot::Holes => vec![0; 4 * cloth.len()],
            Slot::Rings => cast_slice(&rings(cloth)).to_vec(),
            Slot::Stitches => cloth.sewing().map(|s| cast_slice(&s.rows()).to_vec()).unwrap_or_default(),
            _ => Vec::new(),
        }
    }

    /// Vectors of four that 64 texels have in a list that instances of a cloth share, as an expression of WGSL; none for other lists.
    pub fn shared_by_64(self) -> Option<&'static str> {
        match self {
            Slot::Rest | Slot::Soft | Slot::Weights => Some("64u"),
            Slot::Cells => Some("128u"),
            Slot::Bends => Some("32u"),
            Slot::Rings => Some("16u"),
            Slot::Stitches => Some("192u"),
            Slot::Tethers => Some("32u * slots"),
            _ => None,
        }
    }

    /// Bytes of the buffer for a cloth.
    pub fn bytes(self, cloth: &Cloth, tethers: usize, colliders: usize) -> u64 {
        let (starts, members) = cloth.rings();
        let bytes = match self {
            Slot::Step => 64 + 16,
            Slot::Batch | Slot::Part => 16,
            Slot::Grids => cloth.grids().len() * 32,
            Slot::Now | Slot::Before | Slot::Rest | Slot::Normals | Slot::Field | Slot::Soft | Slot::Sums => {
                cloth.len() * 16
            }
            Slot::Tethers => cloth.len() * tethers * 8,
            Slot::Holes | Slot::Rings => cloth.len() * 4,
            Slot::Starts => starts.len() * 4,
            Slot::Members => members.len() * 4,
            Slot::Solids => colliders * 80,
            // Of which a pass of its own uses the first 16 bytes.
            Slot::Faults => FAULT_BYTES,
            Slot::Frame => size_of::<FrameRow>(),
            Slot::Jobs => size_of::<JobRow>(),
            Slot::Lists => listed(cloth, tethers, cloth.len()),
            Slot::Lasting => cloth.len() * 16 * (1 + usize::from(cloth.is_exact())),
            Slot::Good | Slot::Weights | Slot::Moments | Slot::Lost => cloth.len() * 16,
            Slot::Next | Slot::Passed | Slot::Losing | Slot::Summing => cloth.len() * 16,
            Slot::Airs | Slot::Targets | Slot::Drifts | Slot::Pulls | Slot::Backs | Slot::BackDrifts => {
                cloth.len() * 16
            }
            Slot::Stitches => cloth.len() * 48,
            Slot::Skinned | Slot::BackSkinned => cloth.len() * 32,
            Slot::Influences | Slot::BackInfluences => {
                cloth.skin().map_or(0, |skin| cloth.len() * 16 * (1 + 2 * skin.sets))
            }
            Slot::Bends => cloth.len() * 8,
            Slot::Cells => cloth.len() * 32,
            Slot::Yielding => 16,
            Slot::Levels => crate::levels::rows(cloth).0 * 16,
            Slot::Nodes => crate::levels::rows(cloth).1 * 32,
            Slot::Limits => crate::levels::rows(cloth).1 * 16,
            Slot::Links => (cloth.len() + crate::levels::rows(cloth).1) * size_of::<LinkRow>(),
            Slot::Ties => crate::levels::ties::rows(&crate::levels::ties::ties(cloth), |_, _| 0).len() * 16,
            Slot::Partial => cloth.len().div_ceil(64) * 4,
            Slot::Fastest | Slot::Strain => 4,
            // As many lists as the shader has there, see `Source::scratch`.
            Slot::Scratch => cloth.len() * 16,
            Slot::Homes => cloth.len() * 16,
            Slot::Kin => crate::levels::boxes::kin(cloth, 0.0).len() * 4,
            Slot::Boxes => crate::levels::boxes::count(cloth) * 32,
            Slot::Partners => cloth.len() * MAX_PARTNERS * 8,
            Slot::Pushes => cloth.len() * 32,
            // Of which a cloth has a part, in buffers of all cloths with contact.
            Slot::Shadows | Slot::Shadow => cloth.len() * 32,
            Slot::Others => cloth.len() * MAX_OTHERS * 16,
            Slot::Struck => 4,
            Slot::Goals | Slot::Places | Slot::Bases | Slot::Ways => cloth.len() * 16,
            Slot::Faces => cloth.len() * 4,
            Slot::Counts => joint::COUNTS * 4,
            Slot::SurfacePlanes | Slot::FoundPlanes => cloth.len() * PLANE_BYTES,
            Slot::SurfaceHints => cloth.len() * HINT_BYTES,
            Slot::Wearers => cloth.len() * WEARER_BYTES,
            Slot::SurfaceShape => cloth.body().map_or(0, |s| s.vertices() * 32 * (1 + cloth.body_sets())),
            Slot::SurfaceVertices => cloth.body().map_or(0, |s| s.vertices() * VERTEX_BYTES),
            Slot::SurfaceTriangles => cloth.body().map_or(0, |s| s.words() * 4),
            Slot::SurfaceBoxes => cloth.body().map_or(0, |s| s.patches() * 48),
            // Made when they are asked for; no frame binds them.
            Slot::Action | Slot::Chosen | Slot::Candidates | Slot::Found => 0,
            Slot::Bounds | Slot::Indices | Slot::Tangents | Slot::Charts => 0,
            Slot::BoundVertices | Slot::Wrapped | Slot::Blending | Slot::Jumps => 0,
            Slot::Covers | Slot::MeshIndices | Slot::LeftIndices => 0,
            Slot::Table | Slot::Origin | Slot::OriginBefore | Slot::Spare | Slot::Beside => 0,
            Slot::Supports | Slot::Holding | Slot::Changes | Slot::Mates => 0,
        };
        bytes as u64
    }
}

/// The seam ring of each particle, `u32::MAX` where there is none.
fn rings(cloth: &Cloth) -> Vec<u32> {
    let (starts, members) = cloth.rings();
    let mut rings = vec![u32::MAX; cloth.len()];
    for (ends, ring) in starts.windows(2).zip(0..) {
        members[ends[0] as usize..ends[1] as usize].iter().for_each(|k| rings[*k as usize] = ring);
    }
    rings
}

/// Bytes of the lists that whole frames of a cloth read, its job included, with room for `places` particles of which each has a number
/// of tethers.
pub fn listed(cloth: &Cloth, tethers: usize, places: usize) -> usize {
    let (starts, members) = cloth.rings();
    let each: usize = LISTED.iter().filter_map(|(slot, _)| slot.row(cloth, tethers)).sum();
    let rings = if cloth.ring_count() > 0 { 4 * (starts.len() + members.len()) } else { 0 };
    size_of::<JobRow>() + cloth.grids().len() * size_of::<GridRow>() + rings + places * each
}
