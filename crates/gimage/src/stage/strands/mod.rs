//! Strands of a garment: drawstrings, cords and ties that hang from it as thin tubes, of one mesh with it. Texels are as wide as they are, so that cloth of
//! them frays; they ride on the garment instead, as buttons do.

mod close;
mod find;
mod report;

use crate::base::mesh::Mesh;
use crate::base::rebuild::rebuild;
use crate::options::{Choice, Range, stage_options};
use crate::record::Finding;

/// Whether strands are cloth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strands {
    /// They ride on the cloth.
    Ride,
    /// They are cloth.
    Keep,
}

impl Choice for Strands {
    const ALL: &'static [(&'static str, Self)] = &[("ride", Self::Ride), ("keep", Self::Keep)];
}

stage_options! {
    /// Options of [`leave_strands`].
    #[derive(Copy)]
    pub struct StrandsOptions of "strands" {
        /// Drawstrings and cords of one mesh with a garment: left out of the cloth and drawn on it (ride), or cloth (keep).
        pub strands: Strands = Strands::Ride => "strands" [""] Range::Any;
    }
}

/// A thin tube with one closed end that hangs from a garment.
#[derive(Clone, Debug, PartialEq)]
pub struct Strand {
    /// The node of the file that it belongs to.
    pub node: String,
    /// Its triangles in the mesh, ascending.
    pub triangles: Vec<u32>,
    /// Its area \[m2\].
    pub area: f64,
    /// How long it is \[m\], from triangle to triangle.
    pub length: f64,
    /// How far it is around \[m\] where it leaves the garment.
    pub around: f64,
    /// Half-edges of the garment around its root, in order: each ends where the next one begins.
    ring: Vec<u32>,
}

/// A mesh without strands.
#[derive(Clone, Debug, PartialEq)]
pub struct Stripped {
    /// The mesh. Triangles keep their order and attributes, and those that close the roots of strands follow; without a strand it is the same mesh.
    pub mesh: Mesh,
    /// The strands that are left out, by their first triangles in the mesh before.
    pub strands: Vec<Strand>,
    /// The strands, as a finding.
    pub finding: Option<Finding>,
}

/// Leaves strands out of a repaired mesh, and closes the garment where they were. Deterministic. O(n log n).
pub fn leave_strands(mut mesh: Mesh, options: &StrandsOptions) -> Stripped {
    let strands = if options.strands == Strands::Keep { Vec::new() } else { find::strands(&mesh) };
    let finding = report::finding(&strands);
    if strands.is_empty() {
        return Stripped { mesh, strands, finding };
    }
    let mut keep = vec![true; mesh.triangles.len()];
    strands.iter().flat_map(|strand| &strand.triangles).for_each(|t| keep[*t as usize] = false);
    close::close(&mut mesh, &keep, &strands);
    keep.resize(mesh.triangles.len(), true);
    Stripped { mesh: rebuild(mesh, &keep).0, strands, finding }
}

#[cfg(test)]
mod tests;
