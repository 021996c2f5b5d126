//! Contents of a bundle as one value: the JSON of `build` and `inspect`, and the source of their tables.

use std::collections::BTreeMap;

use gimage::gate::{Figures, Rating};
use gimage_bundle::manifest::{
    Accessory, Constants, Counts, Cut, PieceEntry, Quality, Repair, RungEntry, Source, Surface,
};
use gimage_bundle::{Bundle, Image, MapKind, RENDER_FILE};
use serde::Serialize;
use serde_json::Value;

use crate::exit::Failure;
use crate::units::length;

/// A bundle summed up.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Version of the format.
    pub version: u32,
    /// Program and version that made it.
    pub generator: String,
    /// The file it was made from.
    pub source: Source,
    /// Options used.
    pub options: BTreeMap<String, Value>,
    /// Texels of all pieces.
    pub texels: u32,
    /// The box around all particles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounds: Option<Bounds>,
    /// Bytes of all images.
    pub image_bytes: u64,
    /// The pieces.
    pub pieces: Vec<Piece>,
    /// The mesh of the source, if the bundle has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub render: Option<RenderMesh>,
    /// Parts that ride on pieces.
    pub accessories: Vec<Accessory>,
    /// Quality of the whole.
    pub quality: Quality,
    /// Largest distance between duplicates \[m\], from the images.
    pub seam_gap: f64,
    /// Repairs and findings of the build.
    pub repairs: Vec<Repair>,
    /// Contradictions between the manifest and the images; one sentence each.
    pub disagreements: Vec<String>,
}

/// The mesh of the source, bound to the pieces.
#[derive(Clone, Debug, Serialize)]
pub struct RenderMesh {
    /// Its file.
    pub file: String,
    /// The length of the file; none if the manifest does not record it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bytes: Option<u64>,
    /// Vertices of primitives with a bound vertex.
    pub vertices: u64,
    /// Those of them that are bound.
    pub bound: u64,
    /// The largest distance of a bound vertex from its point on the surface \[m\].
    pub largest_offset: f64,
}

/// An axis-aligned box \[m\].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bounds {
    /// Smallest x, y, z.
    pub min: [f32; 3],
    /// Largest x, y, z.
    pub max: [f32; 3],
}

impl Bounds {
    /// The box around two boxes.
    fn with(self, other: Bounds) -> Bounds {
        let min = std::array::from_fn(|k| self.min[k].min(other.min[k]));
        Bounds { min, max: std::array::from_fn(|k| self.max[k].max(other.max[k])) }
    }

    /// The box around the particles of a position map.
    fn of(positions: &Image) -> Option<Bounds> {
        let texels = positions.data.as_chunks::<4>().0.iter().filter(|t| t[3] != 0.0);
        texels.map(|&[x, y, z, _]| Bounds { min: [x, y, z], max: [x, y, z] }).reduce(Bounds::with)
    }
}

/// The limits of a piece: largest distances of particles from their positions at rest \[m\].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limits {
    /// Particles that have a limit.
    pub particles: u32,
    /// Shortest limit.
    pub min: f32,
    /// Longest limit.
    pub max: f32,
}

impl Limits {
    /// The limits of a piece of `bundle`; `all` are those of its particles, by bundle-wide index.
    fn of(bundle: &Bundle, piece: usize, all: &[f32]) -> Option<Limits> {
        let first = bundle.manifest.pieces[piece].first_particle as usize;
        let positions = bundle.image(piece, &MapKind::Position)?;
        let codes = positions.data.as_chunks::<4>().0.iter().map(|t| t[3]);
        let limited = codes.zip(all.get(first..)?).filter(|&(code, &limit)| code != 0.0 && limit >= 0.0);
        limited.map(|(_, &limit)| Limits { particles: 1, min: limit, max: limit }).reduce(|a, b| Limits {
            particles: a.particles + b.particles,
            min: a.min.min(b.min),
            max: a.max.max(b.max),
        })
    }
}

/// A piece summed up.
#[derive(Clone, Debug, Serialize)]
pub struct Piece {
    /// Its name.
    pub name: String,
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Index of its first texel.
    pub first_particle: u32,
    /// The box around its particles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounds: Option<Bounds>,
    /// Counts, from the images.
    pub counts: Counts,
    /// Its files.
    pub maps: Vec<Map>,
    /// Values that are the same everywhere.
    pub constants: Constants,
    /// The limits of its particles, if any has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<Limits>,
    /// Quality measured.
    pub quality: Quality,
    /// The cut that made it a disk.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cut: Option<Cut>,
    /// The surface before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface: Option<Surface>,
    /// Good, worth a look, or poor.
    pub rating: Rating,
    /// The figures that speak against it, in words.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<String>,
    /// The rungs tried where the first image did not pass.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ladder: Vec<RungEntry>,
}

/// A file of a piece.
#[derive(Clone, Debug, Serialize)]
pub struct Map {
    /// The kind of map it holds.
    pub map: String,
    /// Its name.
    pub file: String,
    /// Its length; none if the manifest does not record it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bytes: Option<u64>,
}

impl Summary {
    /// Sums a bundle up. Counts, boxes and the seam gap come from the images; errors only where a particle code is not
    /// legal.
    pub fn new(mut bundle: Bundle) -> Result<Self, Failure> {
        let stated: Vec<Counts> = bundle.manifest.pieces.iter().map(|p| p.counts).collect();
        bundle.count()?;
        let seam_gap = bundle.seam_gap()?;
        let positions = |piece| bundle.image(piece, &MapKind::Position);
        let boxes: Vec<Option<Bounds>> = (0..stated.len()).map(|piece| positions(piece).and_then(Bounds::of)).collect();
        let bounds = boxes.iter().flatten().copied().reduce(Bounds::with);
        let all_limits = bundle.limits().unwrap_or_default();
        let limits: Vec<Option<Limits>> = (0..stated.len()).map(|k| Limits::of(&bundle, k, &all_limits)).collect();
        let manifest = bundle.manifest;
        let mut disagreements = Vec::new();
        for (piece, stated) in manifest.pieces.iter().zip(&stated) {
            disagreements.extend(count_differences(piece, stated));
        }
        let gaps = manifest.pieces.iter().filter_map(|p| p.quality.seam_gap).chain(manifest.quality.seam_gap);
        let gap = gaps.fold(0.0, f64::max);
        if gap != seam_gap {
            disagreements.push(format!(
                "the manifest says seam gap {}, the images have {}",
                length(gap),
                length(seam_gap)
            ));
        }
        let map = |(map, file): (&String, &String)| Map {
            map: map.clone(),
            file: file.clone(),
            bytes: manifest.files.get(file).map(|f| f.bytes),
        };
        let maps: Vec<Vec<Map>> = manifest.pieces.iter().map(|p| p.maps.iter().map(map).collect()).collect();
        let is_image = |(name, _): &(&String, _)| *name != RENDER_FILE;
        let image_bytes = manifest.files.iter().filter(is_image).map(|(_, f)| f.bytes).sum();
        let render = manifest.render.as_ref().map(|r| RenderMesh {
            file: r.file.clone(),
            bytes: manifest.files.get(&r.file).map(|f| f.bytes),
            vertices: r.vertices,
            bound: r.bound,
            largest_offset: r.largest_offset,
        });
        let texels = manifest.texels();
        let pieces =
            manifest.pieces.into_iter().zip(maps).zip(boxes).zip(limits).map(|(((p, maps), bounds), limits)| {
                let (rating, remarks) = Figures::of(&p.quality).rate();
                Piece {
                    name: p.name,
                    width: p.width,
                    height: p.height,
                    first_particle: p.first_particle,
                    bounds,
                    counts: p.counts,
                    maps,
                    constants: p.constants,
                    limits,
                    quality: p.quality,
                    cut: p.cut,
                    surface: p.surface,
                    rating,
                    remarks,
                    ladder: p.ladder,
                }
            });
        Ok(Summary {
            version: manifest.version,
            generator: manifest.generator,
            source: manifest.source,
            options: manifest.options,
            texels,
            bounds,
            image_bytes,
            pieces: pieces.collect(),
            render,
            accessories: manifest.accessories,
            quality: manifest.quality,
            seam_gap,
            repairs: manifest.repairs,
            disagreements,
        })
    }
}

fn count_differences(piece: &PieceEntry, stated: &Counts) -> Vec<String> {
    let found = &piece.counts;
    [
        ("particles", stated.particles, found.particles),
        ("seam texels", stated.seam_texels, found.seam_texels),
        ("seam points", stated.seam_points, found.seam_points),
        ("members of the largest ring", stated.largest_ring, found.largest_ring),
        ("pinned", stated.pinned, found.pinned),
        ("springs", stated.springs, found.springs),
    ]
    .into_iter()
    .filter(|(_, stated, found)| stated != found)
    .map(|(what, stated, found)| {
        format!("piece {}: the manifest says {stated} {what}, the images have {found}", piece.name)
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_manifest_that_does_not_agree_is_told() {
        let mut bundle = Bundle::new("test");
        let piece = bundle.add_piece("body", 2, 2).unwrap();
        let mut image = Image::zeros(2, 2, 4);
        image.data.chunks_mut(4).for_each(|t| t[3] = 1.0);
        bundle.insert(piece, MapKind::Position, image).unwrap();
        bundle.count().unwrap();
        assert!(Summary::new(bundle.clone()).unwrap().disagreements.is_empty());
        bundle.manifest.pieces[0].counts.pinned = 3;
        bundle.manifest.quality.seam_gap = Some(0.5);
        let summary = Summary::new(bundle).unwrap();
        assert_eq!(summary.disagreements.len(), 2, "{:?}", summary.disagreements);
        assert_eq!(summary.pieces[0].counts.pinned, 0);
    }

    #[test]
    fn boxes_hold_particles_alone() {
        let mut bundle = Bundle::new("test");
        for x in [1.0, 5.0] {
            let piece = bundle.add_piece("body", 2, 2).unwrap();
            let mut image = Image::zeros(2, 2, 4);
            image.data[..8].copy_from_slice(&[x, 2.0, -3.0, 1.0, x + 1.0, 2.5, -4.0, 1.0]);
            bundle.insert(piece, MapKind::Position, image).unwrap();
        }
        let summary = Summary::new(bundle).unwrap();
        assert_eq!(summary.pieces[0].bounds, Some(Bounds { min: [1.0, 2.0, -4.0], max: [2.0, 2.5, -3.0] }));
        assert_eq!(summary.bounds, Some(Bounds { min: [1.0, 2.0, -4.0], max: [6.0, 2.5, -3.0] }));
    }
}
