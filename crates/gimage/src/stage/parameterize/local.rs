//! One vertex at a time: where it has room, and how it goes down the energy of its own triangles.

use super::distortion::{Rest, density, energy, jacobian, signed_area2};
use super::newton::{Local, local};
use crate::stage::sample::fit::clip;

/// Energy per weight above which a vertex first tries the middle of its room: far from the minimum a Newton step
/// changes an area by a third only.
const CRUSHED: f64 = 1e3;

/// The middle of the places where all triangles around `u` are turned the right way; `None` if f64 finds no such place.
pub(super) fn room(u: u32, fan: impl Iterator<Item = [u32; 3]>, uv: &[[f64; 2]]) -> Option<[f64; 2]> {
    let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut sides = Vec::with_capacity(8);
    let mut origin = None;
    for t in fan {
        let k = t.iter().position(|&x| x == u)?;
        let (a, b) = (uv[t[(k + 1) % 3] as usize], uv[t[(k + 2) % 3] as usize]);
        // Coordinates from a corner of the polygon: a small one is not lost beside its distance from (0, 0).
        let o = *origin.get_or_insert(a);
        let (a, b) = ([a[0] - o[0], a[1] - o[1]], [b[0] - o[0], b[1] - o[1]]);
        for c in 0..2 {
            lo[c] = lo[c].min(a[c]).min(b[c]);
            hi[c] = hi[c].max(a[c]).max(b[c]);
        }
        sides.push((a, b));
    }
    let o = origin?;
    let mut polygon = vec![lo, [hi[0], lo[1]], hi, [lo[0], hi[1]]];
    let mut next = Vec::new();
    for (a, b) in sides {
        let (n, d) = ([b[1] - a[1], a[0] - b[0]], a[0] * b[1] - a[1] * b[0]);
        clip(&polygon, n, d, &mut next);
        std::mem::swap(&mut polygon, &mut next);
    }
    if polygon.len() < 3 {
        return None;
    }
    let n = polygon.len() as f64;
    let middle = polygon.iter().fold([0.0; 2], |m, p| [m[0] + p[0] / n, m[1] + p[1] / n]);
    Some([middle[0] + o[0], middle[1] + o[1]])
}

/// A place for `u` near `v`, which it is split off from: along the bisector of the angle that the polygon around `u` has
/// at `v`, as far as no triangle is flipped. Serves where [`room`] is lost to rounding; `None` if f64 has no number between.
pub(super) fn beside(u: u32, v: u32, fan: impl Iterator<Item = [u32; 3]> + Clone, uv: &[[f64; 2]]) -> Option<[f64; 2]> {
    let o = uv[v as usize];
    let from = |x: u32| [uv[x as usize][0] - o[0], uv[x as usize][1] - o[1]];
    let (mut first, mut last, mut near) = (None, None, f64::INFINITY);
    for t in fan.clone() {
        let k = t.iter().position(|&x| x == u)?;
        let (a, b) = (t[(k + 1) % 3], t[(k + 2) % 3]);
        if a == v {
            first = Some(from(b));
        }
        if b == v {
            last = Some(from(a));
        }
        near = [a, b].into_iter().filter(|&x| x != v).map(from).fold(near, |m, d| m.min(d[0].hypot(d[1])));
    }
    let (first, last) = (first?, last?);
    let start = first[1].atan2(first[0]);
    let span = (last[1].atan2(last[0]) - start).rem_euclid(std::f64::consts::TAU);
    let (sin, cos) = (start + 0.5 * span).sin_cos();
    let places = (1..60).map(|k| near * 0.5f64.powi(k)).map(|r| [o[0] + r * cos, o[1] + r * sin]);
    places.into_iter().find(|&p| valid(u, p, fan.clone(), uv))
}

/// Whether all triangles around `u` are turned the right way with `u` at `p`.
pub(super) fn valid(u: u32, p: [f64; 2], mut fan: impl Iterator<Item = [u32; 3]>, uv: &[[f64; 2]]) -> bool {
    fan.all(|t| signed_area2(t.map(|x| if x == u { p } else { uv[x as usize] })) > 0.0)
}

/// Moves `u` down the energy of its own triangles, never over a flip. With `leap`, a crushed vertex first tries the
/// middle of its room.
pub(super) fn settle<'a>(
    u: u32,
    fan: impl Iterator<Item = ([u32; 3], &'a Rest)> + Clone,
    uv: &mut [[f64; 2]],
    steps: usize,
    leap: bool,
) {
    let at = |uv: &[[f64; 2]], t: [u32; 3], p: [f64; 2]| t.map(|x| if x == u { p } else { uv[x as usize] });
    let energy = |uv: &[[f64; 2]], p: [f64; 2]| -> f64 {
        fan.clone().map(|(t, r)| r.weight * density(jacobian(r, at(uv, t, p)))).sum()
    };
    let mut p = uv[u as usize];
    let mut now = energy(uv, p);
    if leap
        && now > CRUSHED * fan.clone().map(|x| x.1.weight).sum::<f64>()
        && let Some(q) = room(u, fan.clone().map(|x| x.0), uv)
    {
        let e = energy(uv, q);
        if e < now {
            (p, now) = (q, e);
        }
    }
    for _ in 0..steps {
        let (mut g, mut h) = ([0.0; 2], [0.0; 3]);
        for (t, r) in fan.clone() {
            let Local { gradient, own, .. } = local(r, at(uv, t, p));
            let k = usize::from(t[1] == u) + 2 * usize::from(t[2] == u);
            g = [g[0] + gradient[k][0], g[1] + gradient[k][1]];
            let b = own[k];
            h = [h[0] + b[0], h[1] + b[1], h[2] + b[3]];
        }
        let det = h[0] * h[2] - h[1] * h[1];
        let d = [(h[1] * g[1] - h[2] * g[0]) / det, (h[1] * g[0] - h[0] * g[1]) / det];
        if !(d[0].is_finite() && d[1].is_finite()) {
            break;
        }
        let mut step = 1.0;
        let mut moved = false;
        for _ in 0..12 {
            let q = [p[0] + step * d[0], p[1] + step * d[1]];
            let e = energy(uv, q);
            if e < now {
                (p, now, moved) = (q, e, true);
                break;
            }
            step *= 0.5;
        }
        if !moved {
            break;
        }
    }
    uv[u as usize] = p;
}

/// The triangles around each vertex.
pub(super) struct Fans {
    first: Vec<u32>,
    around: Vec<u32>,
}

impl Fans {
    /// For a mesh of `n` vertices. O(n + triangles).
    pub(super) fn new(triangles: &[[u32; 3]], n: usize) -> Self {
        let mut first = vec![0u32; n + 1];
        triangles.iter().flatten().for_each(|&v| first[v as usize + 1] += 1);
        (0..n).for_each(|v| first[v + 1] += first[v]);
        let mut next = first.clone();
        let mut around = vec![0u32; 3 * triangles.len()];
        for (t, tri) in triangles.iter().enumerate() {
            for &v in tri {
                around[next[v as usize] as usize] = t as u32;
                next[v as usize] += 1;
            }
        }
        Self { first, around }
    }

    /// The triangles around a vertex, ascending.
    pub(super) fn of(&self, v: usize) -> &[u32] {
        &self.around[self.first[v] as usize..self.first[v + 1] as usize]
    }
}

/// Every free vertex settles in turn, `count` times.
pub(super) fn turns(triangles: &[[u32; 3]], rest: &[Rest], fixed: &[bool], uv: &mut [[f64; 2]], count: usize) {
    let fans = Fans::new(triangles, fixed.len());
    for _ in 0..count {
        for v in (0..fixed.len()).filter(|&v| !fixed[v]) {
            let fan = fans.of(v).iter().map(|&t| (triangles[t as usize], &rest[t as usize]));
            settle(v as u32, fan, uv, 1, false);
        }
    }
}

/// Spreads crushed triangles: free vertices with room leap and settle in turn, forth and back, until the energy is below
/// `enough` or falls by less than a fifth a turn, at most `most` turns. Returns the energy before and after.
pub(super) fn spread(
    triangles: &[[u32; 3]],
    rest: &[Rest],
    fixed: &[bool],
    uv: &mut [[f64; 2]],
    (enough, most): (f64, usize),
) -> (f64, f64) {
    let before = energy(rest, triangles, uv);
    let mut now = before;
    if !(now > enough && now.is_finite()) {
        return (before, now);
    }
    let fans = Fans::new(triangles, fixed.len());
    let free: Vec<usize> = (0..fixed.len()).filter(|&v| !fixed[v]).collect();
    for turn in 0..most {
        let mut one = |v: usize| {
            let fan = fans.of(v).iter().map(|&t| (triangles[t as usize], &rest[t as usize]));
            settle(v as u32, fan, uv, 1, true);
        };
        if turn % 2 == 0 {
            free.iter().for_each(|&v| one(v));
        } else {
            free.iter().rev().for_each(|&v| one(v));
        }
        let last = std::mem::replace(&mut now, energy(rest, triangles, uv));
        if now < enough || now > 0.8 * last {
            break;
        }
    }
    (before, now)
}
