//! The triangle of a coarser image at a place of the finer one.

use gimage_bundle::triangles;

use crate::cloth::Grid;

/// Quads around a place without a triangle in which the nearest one is looked for.
const AROUND: i64 = 8;

/// The triangles of a coarse grid by the quads of the fine grid that they reach into.
pub struct Lookup {
    /// Where the triangles of each quad of the fine grid begin; a quad more than there are.
    starts: Vec<u32>,
    /// Numbers of `triangles`.
    list: Vec<u32>,
    triangles: Vec<Triangle>,
}

/// A triangle of coarse particles, and where these lie in the fine grid \[texels\].
struct Triangle {
    corners: [u32; 3],
    at: [[f64; 2]; 3],
}

impl Lookup {
    /// For a fine grid and the coarse grid that is made of it; `samples` has the fine particle of each coarse one, `exists` tells which coarse ones
    /// there are.
    pub fn new((fine, coarse): (&Grid, &Grid), samples: &[u32], exists: impl Fn(u32) -> bool) -> Self {
        let place = |k: u32| {
            let k = samples[k as usize] - fine.first;
            [f64::from(k % fine.width), f64::from(k / fine.width)]
        };
        let there = |k: u32| exists(coarse.first + k);
        let quads = (0..coarse.height - 1).flat_map(|j| (0..coarse.width - 1).map(move |i| j * coarse.width + i));
        let all = quads.flat_map(|k| triangles(k, coarse.width, there)).map(|t| t.map(|k| coarse.first + k));
        let triangles: Vec<_> = all.map(|corners| Triangle { corners, at: corners.map(place) }).collect();
        let across = fine.width as usize - 1;
        let mut by_quad = vec![Vec::new(); across * (fine.height as usize - 1)];
        for (n, t) in triangles.iter().enumerate() {
            let span = |c: usize| {
                let values = t.at.map(|p| p[c] as usize);
                let (low, high) = (values.iter().min().copied(), values.iter().max().copied());
                low.unwrap_or(0)..high.unwrap_or(0)
            };
            for (y, x) in span(1).flat_map(|y| span(0).map(move |x| (y, x))) {
                by_quad[y * across + x].push(n as u32);
            }
        }
        let starts = std::iter::once(0).chain(by_quad.iter().scan(0, |sum, list| {
            *sum += list.len() as u32;
            Some(*sum)
        }));
        Lookup { starts: starts.collect(), list: by_quad.concat(), triangles }
    }

    /// The coarse triangle at a point of a fine one, and the weights of its second and third corner. Beside holes that the coarse image does not
    /// have, the nearest point of a triangle near by; a point of the first triangle where there is none near.
    pub fn point(&self, fine: &Grid, corners: [u32; 3], [s, t]: [f32; 2]) -> ([u32; 3], [f32; 2]) {
        let place = |k: u32| [f64::from((k - fine.first) % fine.width), f64::from((k - fine.first) / fine.width)];
        let ([a, b, c], [s, t]) = (corners.map(place), [s, t].map(f64::from));
        let p = [0, 1].map(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
        let (across, down) = (i64::from(fine.width) - 1, i64::from(fine.height) - 1);
        let (x, y) = ((p[0] as i64).clamp(0, across - 1), (p[1] as i64).clamp(0, down - 1));
        let mut best: Option<(f64, u32, [f64; 2])> = None;
        for radius in 0..=AROUND {
            let ring = (-radius..=radius).flat_map(|j| (-radius..=radius).map(move |i| (i, j)));
            for (i, j) in ring.filter(|(i, j)| i.abs().max(j.abs()) == radius) {
                let (i, j) = (x + i, y + j);
                if i < 0 || j < 0 || i >= across || j >= down {
                    continue;
                }
                let quad = (j * across + i) as usize;
                for n in &self.list[self.starts[quad] as usize..self.starts[quad + 1] as usize] {
                    let (gap2, weights) = nearest(self.triangles[*n as usize].at, p);
                    if best.is_none_or(|b| gap2 < b.0) {
                        best = Some((gap2, *n, weights));
                    }
                }
            }
            // A quad farther out is at least this far away.
            if best.is_some_and(|b| b.0 <= (radius as f64).powi(2)) {
                break;
            }
        }
        let found = best.map(|(_, n, weights)| (self.triangles[n as usize].corners, weights.map(|w| w as f32)));
        let first = || self.triangles.first().map_or(([0; 3], [0.0; 2]), |t| (t.corners, [0.0; 2]));
        found.unwrap_or_else(first)
    }
}

/// The squared distance of a triangle of the plane from a point, and the weights of the second and the third corner at its nearest point.
fn nearest(at: [[f64; 2]; 3], p: [f64; 2]) -> (f64, [f64; 2]) {
    let sub = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let (e, f, d) = (sub(at[1], at[0]), sub(at[2], at[0]), sub(p, at[0]));
    let area = cross(e, f);
    let [s, t] = [cross(d, f) / area, cross(e, d) / area];
    if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
        return (0.0, [s, t]);
    }
    let side = |from: usize| {
        let (a, way) = (at[from], sub(at[(from + 1) % 3], at[from]));
        let share = (dot(sub(p, a), way) / dot(way, way)).clamp(0.0, 1.0);
        let gap = sub(p, [a[0] + share * way[0], a[1] + share * way[1]]);
        let weights = [[share, 0.0], [1.0 - share, share], [0.0, 1.0 - share]][from];
        (dot(gap, gap), weights)
    };
    [side(1), side(2)].into_iter().fold(side(0), |best, other| if other.0 < best.0 { other } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(width: u32, height: u32) -> Grid {
        Grid { name: String::new(), first: 0, width, height }
    }

    #[test]
    fn a_place_of_the_fine_grid_is_the_same_place_of_the_coarse_one() {
        // Columns 0, 1, 3, 4 and rows 0, 2, 3 of 5 x 4.
        let (columns, rows) = ([0u32, 1, 3, 4], [0u32, 2, 3]);
        let samples: Vec<u32> = rows.iter().flat_map(|y| columns.iter().map(move |x| 5 * y + x)).collect();
        let fine = grid(5, 4);
        let look = Lookup::new((&fine, &grid(4, 3)), &samples, |_| true);
        for corner in (0..19).filter(|k| k % 5 < 4 && k / 5 < 3) {
            for corners in triangles(corner, 5, |_| true) {
                for [s, t] in [[0.0, 0.0], [0.25, 0.5], [0.5, 0.5], [0.1, 0.2]] {
                    let (found, [u, v]) = look.point(&fine, corners, [s, t]);
                    let mix = |[a, b, c]: [u32; 3], [s, t]: [f32; 2], of: &dyn Fn(u32) -> u32| {
                        of(a) as f32 + s * (of(b) as f32 - of(a) as f32) + t * (of(c) as f32 - of(a) as f32)
                    };
                    for of in [|k: u32| k % 5, |k: u32| k / 5] {
                        let (want, got) = (mix(corners, [s, t], &of), mix(found, [u, v], &|k| of(samples[k as usize])));
                        assert!((want - got).abs() < 1e-5, "{corners:?} {s} {t}: {found:?} {u} {v}");
                    }
                    // The first edge leads along u.
                    assert_eq!(found[1], found[0] + 1);
                }
            }
        }
    }

    #[test]
    fn beside_a_hole_the_nearest_triangle_is_taken() {
        let samples: Vec<u32> = [0u32, 2, 4].iter().flat_map(|y| [0u32, 2, 4].map(|x| 5 * y + x)).collect();
        let fine = grid(5, 5);
        // The right column of the coarse grid does not exist.
        let look = Lookup::new((&fine, &grid(3, 3)), &samples, |k| k % 3 < 2);
        let (found, weights) = look.point(&fine, [18, 19, 13], [0.5, 0.0]);
        assert!(found.iter().all(|k| k % 3 < 2), "{found:?}");
        let x: f32 = 2.0 * ((found[0] % 3) as f32 * (1.0 - weights[0] - weights[1]))
            + 2.0 * ((found[1] % 3) as f32 * weights[0] + (found[2] % 3) as f32 * weights[1]);
        assert!((x - 2.0).abs() < 1e-6, "{found:?} {weights:?}");
    }
}
