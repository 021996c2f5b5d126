//! Corner attributes of the mesh -> maps, sampled where the texels are.
//!
//! Every texel reads one triangle, so a UV seam inside the image falls between two texels and is never smeared over one.
//! Duplicates of a seam point share joints and weights, and share every other attribute bit for bit where its two sides
//! agree to rounding.

use std::collections::BTreeMap;

use gimage_bundle::{Image, MapKind};

use crate::base::joints::strongest;
use crate::base::mesh::{Channel, Mesh, Semantic};
use crate::base::surface::Surface;
use crate::record::{Finding, Severity};
use crate::stage::assemble::limits;
use crate::stage::image::PieceImage;

/// Relative difference up to which the two sides of a seam are one value.
const SAME: f32 = 1e-4;

/// Whether the values of two sides of a seam are one value.
pub(crate) fn same(a: f32, b: f32) -> bool {
    (a - b).abs() <= SAME * a.abs().max(b.abs()).max(1.0)
}

/// The mesh triangle and the barycentric coordinates of each texel.
pub(crate) fn places(image: &PieceImage, surface: &Surface) -> Vec<(usize, [f64; 3])> {
    let disk = &image.disk;
    image
        .samples
        .iter()
        .map(|s| {
            let t = s.triangle as usize;
            let face = disk.face[t] as usize;
            let corners = disk.corners.of(t);
            let mut bary = [0.0; 3];
            for (weight, corner) in s.bary.iter().zip(corners) {
                for c in 0..3 {
                    bary[surface.source_corner(face, c)] += weight * corner[c];
                }
            }
            (surface.source_triangle[face] as usize, bary)
        })
        .collect()
}

/// The value of a channel at a place, over the corners that have one; `false` if none has.
fn sample(channel: &Channel, (t, bary): (usize, [f64; 3]), out: &mut [f64]) -> bool {
    out.fill(0.0);
    let mut total = 0.0;
    for (c, b) in bary.iter().enumerate() {
        if let Some(v) = channel.at(t, c) {
            total += b;
            out.iter_mut().zip(v).for_each(|(o, &x)| *o += b * f64::from(x));
        }
    }
    if total > 0.0 {
        out.iter_mut().for_each(|o| *o /= total);
    }
    total > 0.0
}

/// The four strongest joints at a place, strongest first, their weights summing to 1.
fn skin(sets: &[(&Channel, &Channel)], (t, bary): (usize, [f64; 3])) -> ([f32; 4], [f32; 4]) {
    let mut sum: BTreeMap<u32, f64> = BTreeMap::new();
    for (joints, weights) in sets {
        for (c, b) in bary.iter().enumerate() {
            if let (Some(j), Some(w)) = (joints.at(t, c), weights.at(t, c)) {
                for (j, w) in j.iter().zip(w) {
                    *sum.entry(*j as u32).or_default() += b * f64::from(*w);
                }
            }
        }
    }
    // A texel on a part of the mesh without a skin follows the first joint.
    let (mut j, mut w) = ([0.0; 4], [1.0, 0.0, 0.0, 0.0]);
    for (k, (joint, weight)) in strongest(sum, 4).into_iter().enumerate() {
        (j[k], w[k]) = (joint as f32, weight as f32);
    }
    (j, w)
}

fn map_of(semantic: &Semantic, width: usize) -> Option<(MapKind, usize)> {
    Some(match semantic {
        Semantic::Normal => (MapKind::Normal, 3),
        Semantic::TexCoord(n) => (MapKind::Uv(u8::try_from(*n).ok()?), 3),
        Semantic::Color(n) => (MapKind::Color(u8::try_from(*n).ok()?), 4),
        Semantic::Custom(name) if width <= 4 => {
            (MapKind::Custom(name.clone()), if width == 1 { 1 } else { width.max(3) })
        }
        _ => return None,
    })
}

/// All attribute maps of a piece, and what could not be kept.
pub(crate) fn attributes(
    mesh: &Mesh,
    piece: &str,
    image: &PieceImage,
    places: &[(usize, [f64; 3])],
) -> (Vec<(MapKind, Image)>, Vec<Finding>) {
    let (mut maps, mut findings) = (Vec::new(), Vec::new());
    let blank = |channels: usize| Image {
        width: image.width,
        height: image.height,
        channels: channels as u32,
        data: vec![0.0; places.len() * channels],
    };
    let rings: Vec<Vec<u32>> = image.grid.rings().collect();
    // Limits have a map of their own.
    let is_limit =
        |c: &&Channel| matches!(&c.semantic, Semantic::Custom(name) if limits::ATTRIBUTES.contains(&&**name));
    for channel in mesh.channels.iter().filter(|c| !is_limit(c)) {
        let Some((kind, channels)) = map_of(&channel.semantic, channel.width) else {
            if let Semantic::Custom(name) = &channel.semantic {
                findings.push(note(
                    piece,
                    "attribute-too-wide",
                    1,
                    format!("{name}: more than four components do not fit an image."),
                ));
            }
            continue;
        };
        // A channel that no texel of this piece has belongs to other parts of the file.
        let (mut out, mut missing) = (blank(channels), 0u64);
        let mut value = vec![0.0; channel.width];
        for (k, &place) in places.iter().enumerate() {
            missing += u64::from(!sample(channel, place, &mut value));
            if kind == MapKind::Normal {
                let n = value.iter().map(|x| x * x).sum::<f64>().sqrt();
                value.iter_mut().for_each(|x| *x /= n.max(1e-30));
            }
            let texel = &mut out.data[k * channels..(k + 1) * channels];
            texel.iter_mut().zip(&value).for_each(|(t, x)| *t = *x as f32);
        }
        if missing == places.len() as u64 {
            continue;
        }
        if missing > 0 {
            let text = format!("{}: texels without a value are 0.", kind.name());
            findings.push(note(piece, "attribute-incomplete", missing, text));
        }
        for ring in &rings {
            let first = ring[0] as usize * channels;
            for &k in &ring[1..] {
                let at = k as usize * channels;
                if (0..channels).all(|c| same(out.data[first + c], out.data[at + c])) {
                    out.data.copy_within(first..first + channels, at);
                }
            }
        }
        maps.push((kind, out));
    }
    maps.extend(skin_maps(mesh, &blank, places, &rings));
    (maps, findings)
}

/// The maps of joints and weights, if any texel has some. Duplicates share those of their first.
fn skin_maps(
    mesh: &Mesh,
    blank: &dyn Fn(usize) -> Image,
    places: &[(usize, [f64; 3])],
    rings: &[Vec<u32>],
) -> Vec<(MapKind, Image)> {
    let sets: Vec<(&Channel, &Channel)> = mesh
        .channels
        .iter()
        .filter_map(|c| match c.semantic {
            Semantic::Joints(n) => Some((c, mesh.channel(&Semantic::Weights(n))?)),
            _ => None,
        })
        .collect();
    let skinned = places.iter().any(|(t, _)| (0..3).any(|c| sets.iter().any(|(j, _)| j.at(*t, c).is_some())));
    if !skinned {
        return Vec::new();
    }
    let (mut joints, mut weights) = (blank(4), blank(4));
    for (k, &place) in places.iter().enumerate() {
        let (j, w) = skin(&sets, place);
        joints.data[4 * k..4 * k + 4].copy_from_slice(&j);
        weights.data[4 * k..4 * k + 4].copy_from_slice(&w);
    }
    for ring in rings {
        let first = 4 * ring[0] as usize;
        for &k in &ring[1..] {
            joints.data.copy_within(first..first + 4, 4 * k as usize);
            weights.data.copy_within(first..first + 4, 4 * k as usize);
        }
    }
    vec![(MapKind::Joints(0), joints), (MapKind::Weights(0), weights)]
}

fn note(piece: &str, kind: &'static str, count: u64, message: String) -> Finding {
    Finding { severity: Severity::Note, stage: "maps", kind, count, examples: vec![format!("piece {piece}")], message }
}
