//! Caps across the openings of a worn garment: game assets close sleeves, waists and necks with a lid, which is not cloth.
//!
//! Sheets are triangles joined across edges flatter than [`SHARP_DEGREES`]; the largest sheet of a component is the garment. A cap is a set of other sheets
//! that hangs together, is a disk, meets the garment along its whole border, and has at most about twice the area of the opening that it closes: a lid,
//! with the rim and the turned-in hem around it, but not the shirt and the lining that an open jacket shows. A bone of the garment's joints that passes through it tells that a limb comes out there.

mod find;
mod report;

use crate::base::mesh::Mesh;
use crate::base::rebuild::rebuild;
use crate::options::{Choice, Range, stage_options};
use crate::record::Finding;

/// Which caps are left out of the cloth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Caps {
    /// Those through which a bone passes.
    Auto,
    /// All of them.
    Open,
    /// None.
    Keep,
}

impl Choice for Caps {
    const ALL: &'static [(&'static str, Self)] = &[("auto", Self::Auto), ("open", Self::Open), ("keep", Self::Keep)];
}

stage_options! {
    /// Options of [`open_caps`].
    #[derive(Copy)]
    pub struct CapsOptions of "caps" {
        /// Caps that close the sleeves, the waist or the neck of a garment: left out of the cloth where a bone passes through
        /// them (auto), all that look like one (open), or cloth (keep).
        pub caps: Caps = Caps::Auto => "caps" [""] Range::Any;
    }
}

/// A lid across an opening of a garment.
#[derive(Clone, Debug, PartialEq)]
pub struct Cap {
    /// The node of the file that it belongs to.
    pub node: String,
    /// Its triangles in the mesh, ascending.
    pub triangles: Vec<u32>,
    /// Its area \[m2\].
    pub area: f64,
    /// The length \[m\] of its border.
    pub length: f64,
    /// The joint at the end of the bone that passes through it, if one does.
    pub bone: Option<String>,
}

/// A mesh without caps.
#[derive(Clone, Debug, PartialEq)]
pub struct Opened {
    /// The mesh. Triangles keep their order and attributes; without a cap that is left out it is the same mesh.
    pub mesh: Mesh,
    /// The caps that are left out, by their first triangles in the mesh before.
    pub caps: Vec<Cap>,
    /// The caps, as a finding.
    pub finding: Option<Finding>,
}

/// Leaves caps out of a repaired mesh. Deterministic. O(n log n), and O(triangles of caps x bones).
pub fn open_caps(mesh: Mesh, options: &CapsOptions) -> Opened {
    if options.caps == Caps::Keep {
        return Opened { mesh, caps: Vec::new(), finding: None };
    }
    let mut caps = find::caps(&mesh);
    caps.retain(|cap| options.caps == Caps::Open || cap.bone.is_some());
    let finding = report::finding(&caps);
    if caps.is_empty() {
        return Opened { mesh, caps, finding };
    }
    let mut keep = vec![true; mesh.triangles.len()];
    caps.iter().flat_map(|cap| &cap.triangles).for_each(|t| keep[*t as usize] = false);
    Opened { mesh: rebuild(mesh, &keep).0, caps, finding }
}

#[cfg(test)]
mod tests;
