//! Which points are sewn to which panel.

use gimage_bundle::{Place, Stitch};

use super::panel::{Panel, Point, share};
use super::reach::{Near, nearest};
use super::thread::{Seamstress, Sewn};
use crate::base::vec3::distance;

/// A part of a border that lies on another panel is sewn to it from this number of points on,
const LEAST_POINTS: usize = 3;
/// and from this share of the length of its loop,
const LEAST_OF_LOOP: f64 = 0.1;
/// or from this share of the diagonal of the garment. A shorter part, such as the end of a strap,
const LEAST_OF_GARMENT: f64 = 0.06;
/// is sewn if its mean distance is at most this share of the largest: otherwise it merely passes.
const CLOSE: f64 = 1.0 / 3.0;

/// Sews borders to the panels that they lie on, those of the smallest panel first, of panels that may be tied. Where two borders meet, one is sewn to
/// the other.
pub(super) fn borders(sewing: &mut Seamstress<'_>, most: f64, diagonal: f64, ties: impl Fn(usize, usize) -> bool) {
    let panels = sewing.panels;
    let mut order: Vec<usize> = (0..panels.len()).collect();
    order.sort_by(|a, b| panels[*a].area.total_cmp(&panels[*b].area).then(a.cmp(b)));
    for own in order {
        for points in &panels[own].loops {
            let near = nearest(panels, own, points, most);
            for run in runs(points, &near, diagonal, most) {
                let on = run.into_iter().filter_map(|k| Some((points[k], near[k]?.panel)));
                sewing.seam(own, on.filter(|(_, to)| ties(own, *to)));
            }
        }
    }
}

/// The parts of a loop that lie on other panels, as indices of points in their order.
fn runs(points: &[Point], near: &[Option<Near>], diagonal: f64, most: f64) -> Vec<Vec<usize>> {
    let n = points.len();
    let on = |k: usize| near[k % n].is_some();
    // A loop that lies on panels all around begins anywhere.
    let start = (0..n).find(|k| on(*k) != on(k + n - 1)).unwrap_or(0);
    let mut found: Vec<Vec<usize>> = Vec::new();
    for k in start..start + n {
        let continues = k > start && on(k) == on(k - 1);
        match (on(k), found.last_mut()) {
            (false, _) => {}
            (true, Some(run)) if continues => run.push(k % n),
            (true, _) => found.push(vec![k % n]),
        }
    }
    let whole: f64 = (0..n).map(|k| share(points, k)).sum();
    let counts = |run: &Vec<usize>| {
        let length: f64 = run.iter().map(|k| share(points, *k)).sum();
        let far = run.iter().filter_map(|k| near[*k]).map(|near| near.distance).sum::<f64>() / run.len() as f64;
        let is_long = length >= LEAST_OF_LOOP * whole || length >= LEAST_OF_GARMENT * diagonal;
        run.len() >= LEAST_POINTS.min(n) && (is_long || far <= CLOSE * most)
    };
    found.retain(counts);
    found
}

/// Points of a panel that are sewn to others all over it have this number of texels between them,
const SPARSE: f64 = 3.0;
/// or this share of the diagonal of the panel.
const SPARSE_SHARE: f64 = 0.06;
/// They are sewn only if this share of all points lies on other panels: fewer merely touch.
const LEAST_OF_POINTS: f64 = 0.05;

/// Sews a panel to the panels that it lies on by a sparse set of its points, of panels that may be tied.
pub(super) fn all_over(sewing: &mut Seamstress<'_>, own: usize, most: f64, ties: impl Fn(usize, usize) -> bool) {
    let panels = sewing.panels;
    let panel = &panels[own];
    let apart = (SPARSE * panel.spacing).max(SPARSE_SHARE * panel.diagonal());
    let near = nearest(panels, own, &panel.points, most);
    if (near.iter().flatten().count() as f64) < LEAST_OF_POINTS * panel.points.len() as f64 {
        return;
    }
    let mut taken: Vec<[f64; 3]> = Vec::new();
    let mut chosen: Vec<(Point, usize)> = Vec::new();
    for (point, near) in panel.points.iter().zip(&near) {
        let Some(near) = near else { continue };
        if taken.iter().all(|p| distance(*p, point.at) >= apart) {
            taken.push(point.at);
            chosen.push((*point, near.panel));
        }
    }
    sewing.seam(own, chosen.into_iter().filter(|(_, to)| ties(own, *to)));
}

/// The panels that hang together, by the smallest index of each group.
pub(super) fn groups(panels: usize, sewn: &[Sewn]) -> Vec<u32> {
    let mut sets = gimage_bundle::DisjointSets::new(panels);
    sewn.iter().for_each(|s| _ = sets.union(s.from as u32, s.to as u32));
    sets.into_representatives()
}

/// The stitch of a point of one panel to the nearest point of another. `place` gives the position of a texel of a piece as the
/// bundle stores it, `sizes` width and height of each piece.
pub(super) fn stitch(
    point: &Point,
    target: &Panel,
    particle: u32,
    sizes: &[[u32; 2]],
    place: impl Fn(usize, u32) -> [f64; 3],
) -> Option<Stitch> {
    let landing = target.landing(point.at, |piece| sizes[piece][0])?;
    let [width, height] = sizes[landing.piece];
    let along = |x: f64, n: u32| (x / f64::from(n - 1)).clamp(0.0, 1.0) as f32;
    let at = [along(landing.cell[0], width), along(landing.cell[1], height)];
    let quad = Place::of(width, height, at);
    let mut there = [0.0; 3];
    for (k, share) in quad.corners(width).into_iter().zip(quad.shares()) {
        let p = place(landing.piece, k);
        (0..3).for_each(|c| there[c] += f64::from(share) * p[c]);
    }
    let distance = distance(there, point.at) as f32;
    distance.is_finite().then_some(Stitch { particle, piece: landing.piece as u32, at, distance })
}

#[cfg(test)]
mod tests {
    use super::super::panel::Texel;
    use super::*;

    fn ring(n: usize) -> Vec<Point> {
        let at = |k: usize| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
            [cos, 0.0, sin]
        };
        (0..n).map(|k| Point { texel: Texel { piece: 0, texel: k as u32 }, at: at(k) }).collect()
    }

    #[test]
    fn a_border_is_sewn_where_it_lies_on_a_panel_for_some_length() {
        let near = |panel: usize| Some(Near { panel, distance: 0.9 });
        let points = ring(40);
        let mut all = vec![None; 40];
        // Across the first point, a graze, and one that two panels share.
        [38, 39, 0, 1, 2, 3].into_iter().for_each(|k: usize| all[k] = near(1));
        [20, 21].into_iter().for_each(|k: usize| all[k] = near(1));
        (30..36).for_each(|k| all[k] = near(1 + k % 2));
        assert_eq!(runs(&points, &all, 2.0, 1.0), [vec![30, 31, 32, 33, 34, 35], vec![38, 39, 0, 1, 2, 3]]);
        assert_eq!(runs(&points, &vec![near(1); 40], 2.0, 1.0), [(0..40).collect::<Vec<_>>()]);
        assert!(runs(&points, &vec![None; 40], 2.0, 1.0).is_empty());
        // The end of a strap of a large garment: short, but right on the panel.
        let end = |distance| {
            let mut all = vec![None; 40];
            (4..7).for_each(|k| all[k] = Some(Near { panel: 1, distance }));
            runs(&points, &all, 20.0, 1.0).len()
        };
        assert_eq!([end(0.2), end(0.9)], [1, 0]);
    }

    #[test]
    fn panels_that_are_sewn_are_one_group() {
        let sewn = |from, to| Sewn { from, to, stitch: Stitch { particle: 0, piece: 0, at: [0.0; 2], distance: 0.0 } };
        assert_eq!(groups(5, &[sewn(3, 1), sewn(4, 3)]), [0, 1, 2, 1, 1]);
    }
}
