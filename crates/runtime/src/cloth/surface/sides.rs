//! Which triangles meet at a side.

use std::collections::HashMap;

use super::{BodySurface, normal};
use crate::number::real::{V3, cast, dot, sub};

/// No triangle.
pub(crate) const NONE: u32 = u32::MAX;

/// Least rise over the square root of the area by which a neighbour stands above a triangle at a hollow side.
const RISE: f64 = 0.02;

/// For each triangle those beyond its sides. A side that is not of exactly two triangles, in opposite directions, is a border.
pub fn across(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut sides: HashMap<[u32; 2], (u32, u32)> = HashMap::new();
    let each =
        || triangles.iter().enumerate().flat_map(|(t, v)| (0..3).map(move |c| (t as u32, [v[c], v[(c + 1) % 3]])));
    for (t, side) in each() {
        let entry = sides.entry(side).or_insert((t, 0));
        entry.1 += 1;
    }
    let beyond = |[a, b]: [u32; 2]| match (sides.get(&[a, b]), sides.get(&[b, a])) {
        (Some((_, 1)), Some((t, 1))) => *t,
        _ => NONE,
    };
    triangles.iter().map(|v| [0, 1, 2].map(|c| beyond([v[c], v[(c + 1) % 3]]))).collect()
}

/// The sides at which the far corner of the neighbour is in front of a triangle.
pub fn hollow(surface: &BodySurface) -> Vec<u8> {
    let at = |v: u32| -> V3<f64> { cast(surface.rest[v as usize]) };
    let of = |(t, across): (&[u32; 3], &[u32; 3])| {
        let n = normal(t.map(at));
        let size = dot(n, n).sqrt();
        let stands = |c: usize| {
            let Some(other) = surface.triangles.get(across[c] as usize) else { return false };
            let far = other.iter().find(|v| !t.contains(v)).copied().unwrap_or(t[c]);
            dot(sub(at(far), at(t[c])), n) > RISE * size * size.sqrt()
        };
        (0..3).filter(|c| stands(*c)).map(|c| 1u8 << c).sum()
    };
    surface.triangles.iter().zip(&surface.across).map(of).collect()
}

/// Whether each vertex is at the end of a side without a neighbour.
pub fn border(surface: &BodySurface) -> Vec<bool> {
    let mut border = vec![false; surface.rest.len()];
    for (t, across) in surface.triangles.iter().zip(&surface.across) {
        for c in (0..3).filter(|c| across[*c] == NONE) {
            [t[c], t[(c + 1) % 3]].iter().for_each(|v| border[*v as usize] = true);
        }
    }
    border
}
