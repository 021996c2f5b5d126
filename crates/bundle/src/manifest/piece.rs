//! The entry of a piece in the manifest.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Quality;

/// One piece: one connected surface on one grid.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PieceEntry {
    /// Its original name; file names are derived from it.
    pub name: String,
    /// Texels in a row, at least 2.
    pub width: u32,
    /// Rows, at least 2.
    pub height: u32,
    /// Bundle-wide index of texel (0, 0).
    pub first_particle: u32,
    /// File of each map, by the map's name. Filled in on encoding.
    pub maps: BTreeMap<String, String>,
    /// Values that are the same at every particle.
    #[serde(default)]
    pub constants: Constants,
    /// Counts of the contents of the images.
    #[serde(default)]
    pub counts: Counts,
    /// How well the piece matches the source.
    #[serde(default, skip_serializing_if = "Quality::is_empty")]
    pub quality: Quality,
    /// The cut that made the surface a disk.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cut: Option<Cut>,
    /// The surface before it was cut.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<Surface>,
    /// The thin shell that the surface is the layer of, if it was modelled with a thickness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shell: Option<ShellEntry>,
    /// All attempts in order, if the first image did not pass; else empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ladder: Vec<RungEntry>,
    /// Index of the component that it is a part of, if one was split into several pieces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part_of: Option<u32>,
}

/// A thin shell: fabric modelled as two facing sheets, of which one layer is the piece.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ShellEntry {
    /// `mid`: halfway between both sheets; `outer`: the outer sheet.
    pub layer: String,
    /// Median distance of the two sheets \[m\].
    pub thickness: f64,
    /// Distances \[m\] that 5 % and 95 % of the area lie below.
    pub thickness_range: [f64; 2],
    /// Share of the area that has an opposite sheet.
    pub share: f64,
    /// Triangles of the other sheet and the rim, which no image has; 0 if another piece of the same shell counts them.
    pub bound_triangles: u32,
    /// Their area \[m^2\].
    pub bound_area: f64,
}

impl ShellEntry {
    /// Distance \[m\] that the layer keeps from other surfaces, so that the fabric does not enter them: half of its thickness, or
    /// all of it for the outer sheet.
    pub fn clearance(&self) -> f64 {
        if self.layer == "outer" { self.thickness } else { 0.5 * self.thickness }
    }
}

/// One attempt to make the image of a piece, and its result.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RungEntry {
    /// How the attempt differs: `first`, `whole-mesh`, `next-cut`, ...
    pub rung: String,
    /// A lower bound of its PSNR \[dB\]; none if the attempt gave no image.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f64>,
    /// Its image is the one in the bundle.
    pub kept: bool,
}

/// A connected surface that several pieces are the parts of; seam rings lead from piece to piece.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ComponentEntry {
    /// Its name.
    pub name: String,
    /// The surface that its pieces weld to.
    pub surface: Surface,
}

/// Values that are the same at every particle of a piece and so need no image.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Constants {
    /// Rest lengths \[m\] right, down, down-right, up-right, in place of a rest map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest: Option<[f32; 4]>,
    /// Particle mass \[kg\], in place of a mass map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<f32>,
    /// Largest distance \[m\] of a particle from its position at rest, in place of a limit map; negative means no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<f32>,
    /// Area density \[kg/m^2\] that the masses were made from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Total area \[m^2\] that the masses were made from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area: Option<f64>,
}

/// Counts of the contents of the images of a piece.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Counts {
    /// Texels with a particle.
    pub particles: u32,
    /// Texels that lie on a seam.
    pub seam_texels: u32,
    /// Points of the seams: rings whose lowest index is in this piece.
    pub seam_points: u32,
    /// Members of the largest of those rings, 0 without seams.
    pub largest_ring: u32,
    /// Pinned texels.
    pub pinned: u32,
    /// Springs: rest lengths above 0.
    pub springs: u32,
}

/// The cut that made a piece a disk.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Cut {
    /// Length \[m\].
    pub length: f64,
    /// Edges of the source mesh.
    pub edges: u32,
    /// How it was chosen.
    pub method: String,
    /// Distortion of a stand-in cut as short as can be, and as it is cut: means of ln(symmetric Dirichlet density / 4), 0
    /// for an isometry. Their difference is what the longer cut bought.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distortion_shortest: Option<f64>,
    /// The second of these.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distortion: Option<f64>,
}

/// The surface of a piece before it was cut.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Surface {
    /// Euler number: vertices - edges + faces.
    pub euler: i32,
    /// Boundary loops.
    pub loops: u32,
    /// Area \[m^2\].
    pub area: f64,
    /// Triangles.
    pub triangles: u32,
}
