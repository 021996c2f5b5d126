//! Pieces that are parts of one surface: joined by rings of duplicates, and alike in all that a point has once.

use std::collections::{BTreeMap, BTreeSet};

use gimage_bundle::manifest::{ComponentEntry, Surface as SurfaceEntry};
use gimage_bundle::{Bundle, Image, MapKind, other_end};

use super::{Made, Piece};
use crate::stage::assemble::attributes::same;
use crate::stage::assemble::mass::Masses;
use crate::stage::assemble::springs::{DOWN, RIGHT, RestLengths};
use crate::stage::component::Component;
use crate::stage::cut::disk::NONE;
use crate::stage::split::{PartTexel, Parts};

/// Consecutive pieces that are the parts of one component.
#[derive(Clone, Debug)]
pub struct Family<'a> {
    /// The component as a whole.
    pub whole: &'a Component,
    /// The first piece.
    pub first: usize,
    /// The number of pieces.
    pub count: usize,
    /// Rings across parts, as (part, texel).
    pub rings: Vec<Vec<PartTexel>>,
}

impl Family<'_> {
    /// The indices of its pieces.
    pub(crate) fn pieces(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.count
    }
}

/// The parts of a component as components of their own: `name.1`, `name.2`, ..., none of them in `taken`, which gains them
/// (in lower case).
pub(crate) fn part_components(whole: &Component, parts: &Parts, taken: &mut BTreeSet<String>) -> Vec<Component> {
    let mut base = whole.name.clone();
    let name = |base: &str, k: usize| format!("{base}.{}", k + 1);
    while (0..parts.parts.len()).any(|k| taken.contains(&name(&base, k).to_lowercase())) {
        base.push('_');
    }
    let component = |(k, part): (usize, &crate::stage::split::PartImage)| {
        let mut triangles = part.surface.source_triangle.clone();
        triangles.sort_unstable();
        let mut bounds = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in &part.surface.positions {
            (0..3).for_each(|c| {
                (bounds.0[c], bounds.1[c]) = (bounds.0[c].min(p[c]), bounds.1[c].max(p[c]));
            });
        }
        Component {
            triangles,
            name: name(&base, k),
            area: part.surface.area(),
            euler: part.euler,
            loops: part.loops,
            orientable: whole.orientable,
            genus: (2 - part.euler - part.loops as i64).max(0) as u32 / if whole.orientable { 2 } else { 1 },
            bounds,
            lies_on: None,
        }
    };
    let out: Vec<Component> = parts.parts.iter().enumerate().map(component).collect();
    taken.extend(out.iter().map(|c| c.name.to_lowercase()));
    out
}

/// The first piece of the family of each piece; a piece without one is its own.
pub(super) fn owners(pieces: usize, families: &[Family<'_>]) -> Vec<usize> {
    let mut owner: Vec<usize> = (0..pieces).collect();
    families.iter().for_each(|f| owner[f.pieces()].fill(f.first));
    owner
}

/// For each texel of each piece the bundle-wide index of its next duplicate, or [`NONE`].
pub(super) fn links(pieces: &[Piece<'_>], families: &[Family<'_>]) -> Vec<Vec<u32>> {
    let mut first = Vec::with_capacity(pieces.len());
    let mut total = 0u32;
    for Piece { image, .. } in pieces {
        first.push(total);
        total = total.saturating_add(image.grid.positions.len() as u32);
    }
    let own = |(Piece { image, .. }, &first): (&Piece<'_>, &u32)| -> Vec<u32> {
        image.grid.links.iter().map(|&l| if l == NONE { NONE } else { first + l }).collect()
    };
    let mut out: Vec<Vec<u32>> = pieces.iter().zip(&first).map(own).collect();
    for family in families {
        for ring in &family.rings {
            for (k, &(p, at)) in ring.iter().enumerate() {
                let (q, next) = ring[(k + 1) % ring.len()];
                out[family.first + p as usize][at as usize] = first[family.first + q as usize] + next;
            }
        }
    }
    out
}

/// Makes the maps of parts agree at the points that they share: masses add up, a pin holds all duplicates, joints and
/// weights are one, the smallest limit counts, other attributes where they are equal to rounding, and so are the lengths of springs along a seam.
pub(super) fn agree(made: &mut [Made], pieces: &[Piece<'_>], families: &[Family<'_>]) {
    for family in families {
        let (made, pieces) = (&mut made[family.pieces()], &pieces[family.pieces()]);
        masses(made, pieces, family);
        for ring in &family.rings {
            if ring.iter().any(|&(p, at)| made[p as usize].pinned[at as usize]) {
                ring.iter().for_each(|&(p, at)| made[p as usize].pinned[at as usize] = true);
            }
        }
        limits(made, pieces, family);
        maps(made, pieces, family);
        rests(made, pieces, family);
    }
}

/// The mass of a point is the sum over the parts that have it, and there over its rings.
fn masses(made: &mut [Made], pieces: &[Piece<'_>], family: &Family<'_>) {
    for (m, Piece { image, .. }) in made.iter_mut().zip(pieces) {
        if let Masses::Constant(c) = m.mass {
            m.mass = Masses::Image(vec![c; image.grid.positions.len()]);
        }
    }
    let own: Vec<Vec<u32>> = pieces.iter().map(|Piece { image, .. }| image.grid.representative()).collect();
    for ring in &family.rings {
        let points: BTreeSet<PartTexel> = ring.iter().map(|&(p, at)| (p, own[p as usize][at as usize])).collect();
        let sum: f64 = points.iter().map(|&(p, at)| f64::from(made[p as usize].mass.at(at as usize))).sum();
        for &(p, at) in ring {
            if let Masses::Image(masses) = &mut made[p as usize].mass {
                masses[at as usize] = sum as f32;
            }
        }
    }
}

/// The limit of a point is the smallest of the parts that have it.
fn limits(made: &mut [Made], pieces: &[Piece<'_>], family: &Family<'_>) {
    if made.iter().all(|m| m.limits.is_none()) {
        return;
    }
    let of_piece = |(m, Piece { image, .. }): (&mut Made, &Piece<'_>)| {
        m.limits.take().unwrap_or_else(|| vec![f32::INFINITY; image.grid.positions.len()])
    };
    let mut limits: Vec<Vec<f32>> = made.iter_mut().zip(pieces).map(of_piece).collect();
    for ring in &family.rings {
        let least = ring.iter().map(|&(p, at)| limits[p as usize][at as usize]).fold(f32::INFINITY, f32::min);
        ring.iter().for_each(|&(p, at)| limits[p as usize][at as usize] = least);
    }
    made.iter_mut().zip(limits).for_each(|(m, limits)| m.limits = Some(limits));
}

fn maps(made: &mut [Made], pieces: &[Piece<'_>], family: &Family<'_>) {
    let kinds: BTreeMap<MapKind, u32> =
        made.iter().flat_map(|m| &m.maps).map(|(kind, image)| (kind.clone(), image.channels)).collect();
    for (kind, channels) in kinds {
        if kind.agrees_across_seams() {
            // A part without a skin follows the first joint.
            for (m, Piece { image, .. }) in made.iter_mut().zip(pieces) {
                if !m.maps.iter().any(|x| x.0 == kind) {
                    let mut blank = Image::zeros(image.width, image.height, channels);
                    if matches!(kind, MapKind::Weights(0)) {
                        blank.data.chunks_exact_mut(channels as usize).for_each(|t| t[0] = 1.0);
                    }
                    m.maps.push((kind.clone(), blank));
                }
            }
        }
        let whose: Vec<Option<usize>> = made.iter().map(|m| m.maps.iter().position(|x| x.0 == kind)).collect();
        for ring in &family.rings {
            let texel = |made: &[Made], (p, at): PartTexel| {
                let image = &made[p as usize].maps[whose[p as usize]?].1;
                (image.channels == channels).then(|| image.at(at as usize).to_vec())
            };
            let Some(first) = texel(made, ring[0]) else { continue };
            for &(p, at) in &ring[1..] {
                let agrees = texel(made, (p, at))
                    .is_some_and(|t| kind.agrees_across_seams() || first.iter().zip(&t).all(|(a, b)| same(*a, *b)));
                if let (true, Some(k)) = (agrees, whose[p as usize]) {
                    let n = channels as usize;
                    made[p as usize].maps[k].1.data[at as usize * n..][..n].copy_from_slice(&first);
                }
            }
        }
    }
}

/// The springs along a path that two parts share have one length, where both parts store their lengths.
fn rests(made: &mut [Made], pieces: &[Piece<'_>], family: &Family<'_>) {
    let mut point: BTreeMap<PartTexel, u32> = BTreeMap::new();
    for (k, ring) in family.rings.iter().enumerate() {
        ring.iter().for_each(|&m| {
            point.insert(m, k as u32);
        });
    }
    let mut known: BTreeMap<[u32; 2], f32> = BTreeMap::new();
    for (p, (m, Piece { image, .. })) in made.iter_mut().zip(pieces).enumerate() {
        let RestLengths::Image(lengths) = &mut m.rest else { continue };
        let (w, h) = (image.grid.width, image.grid.height);
        for (k, lengths) in lengths.iter_mut().enumerate() {
            for kind in [RIGHT, DOWN] {
                let along = if kind == RIGHT { k / w == 0 || k / w == h - 1 } else { k % w == 0 || k % w == w - 1 };
                let Some(end) = other_end(w, h, k, kind).filter(|_| along) else { continue };
                let at = |k: usize| point.get(&(p as u32, k as u32)).copied();
                if let (Some(a), Some(b)) = (at(k), at(end))
                    && a != b
                {
                    lengths[kind] = *known.entry([a.min(b), a.max(b)]).or_insert(lengths[kind]);
                }
            }
        }
    }
}

/// Writes into the manifest which pieces are parts of what.
pub(super) fn declare(bundle: &mut Bundle, families: &[Family<'_>]) {
    for family in families {
        let index = bundle.manifest.components.len() as u32;
        bundle.manifest.components.push(ComponentEntry {
            name: family.whole.name.clone(),
            surface: SurfaceEntry {
                euler: family.whole.euler as i32,
                loops: family.whole.loops as u32,
                area: family.whole.area,
                triangles: family.whole.triangles.len() as u32,
            },
        });
        bundle.manifest.pieces[family.pieces()].iter_mut().for_each(|p| p.part_of = Some(index));
    }
}
