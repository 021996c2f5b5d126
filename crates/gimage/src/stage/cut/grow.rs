//! Grows the cut into the places the map stretches most (Gu, Gortler, Hoppe 2002), on a coarse stand-in of the surface.

use crate::base::decimate::decimate;
use crate::base::graph::Paths;
use crate::base::halfedge::BOUNDARY;
use crate::base::surface::Surface;
use crate::base::vec3::{add, cross, dot, norm, sub};
use crate::stage::border::Border;
use crate::stage::cut::disk::{self, NONE};
use crate::stage::cut::symmetry::Mirror;
use crate::stage::cut::transfer::transfer;
use crate::stage::cut::{Cut, Cutter};
use crate::stage::layout::{Found, Proxy, SearchOptions, Size, most_stretched};

/// How far to grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrowOptions {
    /// Triangles of the stand-in; more is more exact and slower.
    pub triangles: usize,
    /// Largest number of points the cut is grown to.
    pub points: usize,
    /// A point is kept if it lowers the mean of ln(density / 4) by this; 0.01 is about a hundredth of the energy.
    pub gain: f64,
}

impl GrowOptions {
    /// Several times as long as the default, for a little less distortion.
    pub const BEST: Self = Self { triangles: 3000, points: 32, gain: 0.005 };
}

impl Default for GrowOptions {
    fn default() -> Self {
        Self { triangles: 700, points: 24, gain: 0.01 }
    }
}

/// An edge lies in the middle of a symmetric surface if its ends are nearer to the plane than this share of its length.
const MIDDLE: f64 = 0.25;

/// Cost of an edge in the middle, as a share of its length.
const MIDDLE_COST: f64 = 0.5;

/// Extra cost of an edge that faces straight outwards, as a share of its length.
const OUTWARD_COST: f64 = 0.05;

/// Least mean of ln(density / 4) of the solved map at which limbs are looked for in the plain one. A map nearer to an
/// isometry shrinks no limb.
const LIMBS: f64 = 0.3;

/// Texels of the image that a cut is tried with. The default of a bundle.
const TRIAL_TEXELS: u32 = 16_384;

/// Points taken from each map of a try: its most stretched.
const PICKS: usize = 2;

/// Least distance of these two, as a share of the diagonal of the stand-in, so that they do not lie in one limb.
const PICKS_APART: f64 = 0.1;

/// A point that lowers the score by this many times [`GrowOptions::gain`] is taken before the others are tried.
const LARGE_GAIN: f64 = 5.0;

/// One try: the energy of a cut through `terminals`, and the vertices it stretches most.
struct Try {
    score: f64,
    /// The same after the first and the second lot of steps.
    early: [f64; 2],
    next: Vec<u32>,
}

/// Tries a cut. `None` if it cannot be laid out, or is going to be worse than one whose [`Try::early`] is `than`.
fn attempt(
    cutter: &Cutter<'_>,
    cost: &[f64],
    terminals: &[u32],
    search: SearchOptions,
    than: Option<[f64; 2]>,
) -> Option<Try> {
    let surface = cutter.surface;
    let cut = cutter.cut(cost, terminals);
    let mut disk = disk::open(cutter, &cut).ok()?;
    let mut on_rim = vec![false; surface.positions.len()];
    cutter.loops().iter().flatten().for_each(|&v| on_rim[v as usize] = true);
    let border = Border::new(&mut disk, |v| on_rim[v as usize]);
    let mut proxy = Proxy::new(&disk, &border, search);
    let Found { layout, uv: solved, early } = proxy.search_map(Size::Budget(TRIAL_TEXELS), than)?;
    if !layout.score.is_finite() {
        return None;
    }
    let mut on_cut = vec![false; surface.positions.len()];
    disk.boundary.iter().for_each(|&v| on_cut[disk.origin[v as usize] as usize] = true);
    let (positions, triangles) = {
        let (p, t) = proxy.coarse();
        (p.to_vec(), t.to_vec())
    };
    let (lo, hi) = positions.iter().fold((positions[0], positions[0]), |(mut lo, mut hi), p| {
        (0..3).for_each(|k| (lo[k], hi[k]) = (lo[k].min(p[k]), hi[k].max(p[k])));
        (lo, hi)
    });
    let apart = PICKS_APART * crate::base::vec3::distance(lo, hi);
    let mut next = Vec::new();
    // The plain mean-value map shrinks limbs without mercy and so finds their tips; the solved map finds the rest; the
    // point farthest from the cut is a limb's tip more often than not.
    let plain = if layout.score > LIMBS { proxy.plain(&layout) } else { None };
    for uv in plain.into_iter().chain([solved]) {
        let picks = most_stretched(&positions, &triangles, &uv, PICKS, apart, |v| {
            let o = proxy_origin(&disk, &proxy, v);
            o != NONE && !on_cut[o as usize]
        });
        next.extend(picks.into_iter().map(|v| proxy_origin(&disk, &proxy, v)));
    }
    let sources = (0..on_cut.len() as u32).filter(|&v| on_cut[v as usize]);
    next.extend(Paths::all(&cutter.graph, &cutter.graph.length, sources).farthest());
    let mut seen = std::collections::HashSet::new();
    next.retain(|&v| !on_cut[v as usize] && seen.insert(v));
    Some(Try { score: layout.score, early, next })
}

/// Costs of the edges: their lengths, but the middle of a symmetric surface is cheap: both halves are then alike.
fn middle_costs(cutter: &Cutter<'_>, mirror: Option<&Mirror>) -> Vec<f64> {
    let graph = &cutter.graph;
    let Some(mirror) = mirror else { return graph.length.clone() };
    let offset = |v: u32| mirror.offset(cutter.surface.positions[v as usize]).abs();
    let cost = |(e, &l): (&[u32; 2], &f64)| if e.iter().all(|&v| offset(v) < MIDDLE * l) { MIDDLE_COST * l } else { l };
    graph.ends.iter().zip(&graph.length).map(cost).collect()
}

/// Costs of the edges where there is nothing to grow to: besides, what faces the middle costs a little less than what faces
/// outwards. Inner sleeves and inner legs are seen least, and tailors sew there.
pub(crate) fn hidden_costs(cutter: &Cutter<'_>, mirror: Option<&Mirror>) -> Vec<f64> {
    let mut cost = middle_costs(cutter, mirror);
    let Some(mirror) = mirror else { return cost };
    let (surface, graph) = (cutter.surface, &cutter.graph);
    for (e, cost) in cost.iter_mut().enumerate() {
        let normal = graph.halves[e].iter().filter(|&&h| h != BOUNDARY).fold([0.0; 3], |sum, &h| {
            let [a, b, c] = surface.corners(h as usize / 3);
            add(sum, cross(sub(b, a), sub(c, a)))
        });
        let side = graph.ends[e].iter().map(|&v| mirror.offset(surface.positions[v as usize])).sum::<f64>();
        let outward = dot(normal, mirror.normal) * side.signum() / norm(normal).max(1e-300);
        *cost *= 1.0 + OUTWARD_COST * outward.max(0.0);
    }
    cost
}

/// The surface vertex behind a vertex of the stand-in.
fn proxy_origin(disk: &disk::Disk, proxy: &Proxy<'_>, v: u32) -> u32 {
    proxy.original(v).map_or(NONE, |d| disk.origin[d as usize])
}

/// A cut found on the stand-in and carried over to the surface.
pub(crate) struct Grown {
    /// The cut of the surface.
    pub cut: Cut,
    /// Points the cut was grown to.
    pub terminals: Vec<u32>,
    /// Distortion of the stand-in before and after.
    pub bought: Option<[f64; 2]>,
    /// The middle of a symmetric surface.
    pub mirror: Option<Mirror>,
}

/// Cuts `surface` to a disk, growing the cut while that lowers the distortion of the stand-in. `None` if the stand-in
/// or the carried cut does not give a disk.
pub(crate) fn grow(fine: &Cutter<'_>, options: &GrowOptions) -> Option<Grown> {
    let surface = fine.surface;
    let search = SearchOptions::trial(options.triangles);
    let mut rim = vec![false; surface.positions.len()];
    fine.loops().iter().flatten().for_each(|&v| rim[v as usize] = true);
    let locked = vec![false; rim.len()];
    let coarse = decimate(&surface.positions, &surface.triangles, &rim, &locked, options.triangles);
    let small = Surface {
        positions: coarse.vertex.iter().map(|&v| surface.positions[v as usize]).collect(),
        source_triangle: vec![0; coarse.triangles.len()],
        first_corner: vec![0; coarse.triangles.len()],
        triangles: coarse.triangles.clone(),
    };
    let mut cutter = Cutter::new(&small)?;
    cutter.wanted = coarse.vertex.iter().map(|&v| fine.wanted[v as usize]).collect();
    let mirror = Mirror::of(&small);
    let cost = middle_costs(&cutter, mirror.as_ref());
    let mates = mirror.as_ref().map(|m| m.mates(&small.positions));
    let mut terminals: Vec<u32> = Vec::new();
    let mut now = attempt(&cutter, &cost, &terminals, search, None);
    let shortest = now.as_ref().map(|t| t.score);
    while terminals.len() < options.points {
        let score = now.as_ref().map_or(f64::INFINITY, |t| t.score);
        let candidates = now.as_ref().map_or_else(Vec::new, |t| t.next.clone());
        let mut best: Option<(Try, u32)> = None;
        for v in candidates {
            let tries = now.iter().chain(best.as_ref().map(|b| &b.0));
            let early = tries.map(|t| t.early).reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1])]);
            let mut longer = terminals.clone();
            longer.push(v);
            if let Some(t) = attempt(&cutter, &cost, &longer, search, early)
                && t.score < score - options.gain
                && best.as_ref().is_none_or(|b| t.score < b.0.score)
            {
                let enough = t.score < score - LARGE_GAIN * options.gain;
                best = Some((t, v));
                if enough {
                    break;
                }
            }
        }
        let Some((t, v)) = best else { break };
        terminals.push(v);
        now = Some(t);
        // Places alike on both sides are cut alike, unless that is worse.
        let room = terminals.len() < options.points;
        if let Some(mate) = mates.as_ref().map(|m| m[v as usize]).filter(|m| room && !terminals.contains(m)) {
            terminals.push(mate);
            let both = attempt(&cutter, &cost, &terminals, search, now.as_ref().map(|t| t.early));
            if both.as_ref().is_some_and(|b| now.as_ref().is_some_and(|t| b.score <= t.score)) {
                now = both;
            } else {
                terminals.pop();
            }
        }
    }
    let cut = cutter.cut(&cost, &terminals);
    let terminals: Vec<u32> = terminals.iter().map(|&v| coarse.vertex[v as usize]).collect();
    let cut = transfer(fine, &cutter, &coarse, &cut, &terminals);
    disk::open(fine, &cut).ok()?;
    let bought = shortest.zip(now).map(|(before, after)| [before, after.score]);
    Some(Grown { cut, terminals, bought, mirror })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::shapes::{Join, sheet};

    /// A sleeve, wider at one end, alike on both sides of y = 3 alone, and shortest along its flanks, off that plane.
    fn sleeve() -> Surface {
        sheet(40, 24, Join::Same, Join::Open, |u, v| {
            let (sin, cos) = (std::f64::consts::TAU * u).sin_cos();
            let r = (0.1 + 0.02 * (cos * cos - sin * sin) + 0.005 * cos) * (1.0 + v);
            [r * cos, 3.0 + r * sin, 0.8 * v]
        })
    }

    #[test]
    fn a_symmetric_sleeve_is_cut_along_its_middle() {
        let s = sleeve();
        let cutter = Cutter::new(&s).unwrap();
        let grown = grow(&cutter, &GrowOptions::default()).unwrap();
        let mirror = grown.mirror.unwrap();
        assert!((mirror.normal[1].abs() - 1.0).abs() < 1e-2, "{mirror:?}");
        let off = |cost: &[f64]| -> Vec<f64> {
            let cut = cutter.cut(cost, &[]);
            let ends = cutter.graph.ends.iter().zip(&cut.edges).filter(|x| *x.1).flat_map(|x| *x.0);
            ends.map(|v| (s.positions[v as usize][1] - 3.0).abs()).collect()
        };
        let (shortest, chosen) = (off(&cutter.graph.length), off(&hidden_costs(&cutter, Some(&mirror))));
        assert!(shortest.iter().all(|o| *o > 0.05), "{shortest:?}");
        assert!(chosen.len() >= 48 && chosen.iter().all(|o| *o < 1e-9), "{chosen:?}");
    }

    #[test]
    fn of_equal_places_the_one_that_faces_the_middle_is_cut() {
        // A straight sleeve, alike all around, to the right and to the left of the middle: only its inner side faces that.
        let tube = sheet(40, 24, Join::Same, Join::Open, |u, v| {
            let (sin, cos) = (std::f64::consts::TAU * u).sin_cos();
            [0.4 + 0.1 * cos, 0.1 * sin, 0.8 * v]
        });
        let cutter = Cutter::new(&tube).unwrap();
        let [a, b, c] = tube.corners(0);
        let out = dot(cross(sub(b, a), sub(c, a)), sub(a, [0.4, 0.0, 0.0])).signum();
        for (middle, side) in [(0.0, 1.0), (0.8, -1.0)] {
            let mirror = Mirror { point: [middle, 0.0, 0.0], normal: [1.0, 0.0, 0.0] };
            let cut = cutter.cut(&hidden_costs(&cutter, Some(&mirror)), &[]);
            let ends = cutter.graph.ends.iter().zip(&cut.edges).filter(|x| *x.1).flat_map(|x| *x.0);
            let x: Vec<f64> = ends.map(|v| out * side * (tube.positions[v as usize][0] - 0.4)).collect();
            assert!(x.len() >= 48 && x.iter().all(|x| *x < 1e-9), "where it faces outwards: {x:?}");
        }
    }

    #[test]
    fn growing_tells_what_it_bought() {
        // A sheet with a long horn, which shrinks unless it is slit.
        let horn = sheet(24, 24, Join::Open, Join::Open, |u, v| {
            let (x, y) = (u - 0.5, v - 0.5);
            [x, y, 2.0 * (-(x * x + y * y) / 0.02).exp()]
        });
        let cutter = Cutter::new(&horn).unwrap();
        let grown = grow(&cutter, &GrowOptions::default()).unwrap();
        let [before, after] = grown.bought.unwrap();
        assert!(!grown.terminals.is_empty() && after < before - 0.01, "{before} {after} {:?}", grown.terminals);
    }
}
