//! Which rectangle, and where on its border the boundary starts: searched on a coarse stand-in of the disk.

use std::collections::BTreeMap;

use crate::border::{Border, on_rectangle};
use crate::decimate::decimate;
use crate::disk::Disk;
use crate::parameterize::{NewtonOptions, System, distortion, solve};

/// How large the image of a piece may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Size {
    /// Exactly this many texels (width, height).
    Fixed(u32, u32),
    /// At most about this many texels, of any shape.
    Budget(u32),
}

/// A rectangle in cells (one less than texels) and the start of the boundary on it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    /// Cells across.
    pub w: u32,
    /// Cells down.
    pub h: u32,
    /// Steps from (0, 0) to the start of the boundary loop; whole unless the boundary has no node.
    pub shift: f64,
    /// Steps of each group of the border.
    pub count: Vec<u32>,
    /// Distortion of the stand-in: mean of ln(symmetric Dirichlet density / 4), 0 for an isometry.
    pub score: f64,
}

/// How hard to search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SearchOptions {
    /// Triangles of the stand-in.
    pub triangles: usize,
    /// Starts tried at the first aspect.
    pub shifts: usize,
    /// How many of these go on, by the distortion of their plain mean-value maps: one factor serves all of those.
    pub rough: usize,
    /// Reweighting passes of each trial.
    pub passes: usize,
    /// Newton steps of all trials, of those that came out best, and of the best of these.
    pub steps: [usize; 3],
    /// How many trials go on to the second and the third lot of steps.
    pub keep: [usize; 2],
    /// Refine aspect and start around the best.
    pub refine: bool,
    /// Layouts tried with nodes on corners of the image.
    pub snap: usize,
}

/// A layout and the map of the stand-in so far.
#[derive(Clone, Debug)]
struct Trial {
    layout: Layout,
    uv: Vec<[f64; 2]>,
    /// The score after the first lot of steps.
    early: f64,
    /// Index of the aspect and part of the loop at the middle of the side v = 0.
    aspect: usize,
    middle: f64,
}

/// Width : height ratios tried, in steps from square.
const ASPECTS: [f64; 9] = [1.0, 1.25, 1.6, 2.0, 2.5, 3.2, 4.0, 5.0, 6.4];

/// The disk as the search sees it.
pub(crate) struct Proxy<'a> {
    disk: &'a Disk,
    border: &'a Border,
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    wanted: Vec<f64>,
    /// The disk vertex of each coarse vertex; those past its end were split in.
    vertex: Vec<u32>,
    /// Coarse boundary vertices with their places in the loop of the disk.
    loop_at: Vec<(u32, usize)>,
    system: System,
    /// Places in the loop and dead ends for each way of sharing out the steps.
    along: BTreeMap<Vec<u32>, (Vec<f64>, Vec<u32>)>,
    options: SearchOptions,
}

impl<'a> Proxy<'a> {
    /// Makes the stand-in.
    pub(crate) fn new(disk: &'a Disk, border: &'a Border, options: SearchOptions) -> Self {
        let mask = disk.boundary_mask();
        let mut locked = vec![false; disk.positions.len()];
        for (i, &v) in disk.boundary.iter().enumerate() {
            locked[v as usize] = border.nodes.get(i).copied().unwrap_or(false);
        }
        let coarse = decimate(&disk.positions, &disk.triangles, &mask, &locked, options.triangles);
        let mut place = vec![usize::MAX; disk.positions.len()];
        disk.boundary.iter().enumerate().for_each(|(i, &v)| place[v as usize] = i);
        let mut small = Disk {
            positions: coarse.vertex.iter().map(|&v| disk.positions[v as usize]).collect(),
            face: vec![0; coarse.triangles.len()],
            corners: vec![[[0.0; 3]; 3]; coarse.triangles.len()],
            origin: coarse.vertex.clone(),
            wanted: coarse.vertex.iter().map(|&v| disk.wanted[v as usize]).collect(),
            triangles: coarse.triangles,
            ..Disk::default()
        };
        let loop_at: Vec<(u32, usize)> = coarse
            .vertex
            .iter()
            .enumerate()
            .filter(|(_, v)| place[**v as usize] != usize::MAX)
            .map(|(k, v)| (k as u32, place[*v as usize]))
            .collect();
        small.boundary = loop_at.iter().map(|x| x.0).collect();
        small.split_chords();
        let fixed = small.boundary_mask();
        let system = System::new(&small.triangles, &fixed);
        Self {
            disk,
            border,
            positions: small.positions,
            triangles: small.triangles,
            wanted: small.wanted,
            vertex: coarse.vertex,
            loop_at,
            system,
            along: BTreeMap::new(),
            options,
        }
    }

    /// The start of the map of the stand-in for a layout. `None` if the layout cannot be, or has no flip-free start.
    fn begin(&mut self, (w, h): (u32, u32), shift: f64, count: Vec<u32>, passes: usize) -> Option<Trial> {
        let perimeter = 2 * (w + h);
        let (disk, border) = (self.disk, self.border);
        if !self.along.contains_key(&count) {
            self.along.insert(count.clone(), (border.along(disk, &count), border.dead_ends(&count)));
        }
        let (along, dead) = &self.along[&count];
        let at_corner = |step: &u32| {
            let p = (f64::from(*step) + shift).rem_euclid(f64::from(perimeter)).round() as u32 % perimeter;
            [0, w, w + h, 2 * w + h].contains(&p)
        };
        if dead.iter().any(at_corner) {
            return None;
        }
        let mut uv = vec![[0.0; 2]; self.positions.len()];
        for &(k, i) in &self.loop_at {
            uv[k as usize] = on_rectangle(along[i] + shift, w, h);
        }
        let layout = Layout { w, h, shift, count, score: f64::INFINITY };
        let mut trial = Trial { layout, uv, early: f64::INFINITY, aspect: 0, middle: 0.0 };
        self.solve(&mut trial, passes, 0).then_some(trial)
    }

    /// Starts the map (`passes` above 0) and takes Newton steps.
    fn solve(&mut self, trial: &mut Trial, passes: usize, steps: usize) -> bool {
        let options = NewtonOptions { steps, tolerance: 1e-2 };
        let (system, uv) = (&mut self.system, &mut trial.uv);
        let record = solve(system, &self.positions, &self.triangles, &self.wanted, uv, passes, &options);
        trial.layout.score = record.map_or(f64::INFINITY, |r| r.log_distortion);
        trial.layout.score.is_finite()
    }

    /// The plain mean-value map of the stand-in for a layout.
    pub(crate) fn plain(&mut self, layout: &Layout) -> Option<Vec<[f64; 2]>> {
        Some(self.begin((layout.w, layout.h), layout.shift, layout.count.clone(), 1)?.uv)
    }

    /// The disk vertex that a vertex of the stand-in is.
    pub(crate) fn original(&self, v: u32) -> Option<u32> {
        self.vertex.get(v as usize).copied()
    }

    /// Positions and triangles of the stand-in.
    pub(crate) fn coarse(&self) -> (&[[f64; 3]], &[[u32; 3]]) {
        (&self.positions, &self.triangles)
    }

    /// A trial's first lot of steps.
    fn first(&mut self, (w, h): (u32, u32), shift: f64, count: Vec<u32>) -> Option<Trial> {
        let mut trial = self.begin((w, h), shift, count, self.options.passes)?;
        let fine = self.solve(&mut trial, 0, self.options.steps[0]);
        trial.early = trial.layout.score;
        fine.then_some(trial)
    }

    /// All steps of a trial, unless it starts out much worse than the `best`.
    fn all(&mut self, mut trial: Trial, best: &Trial) -> Option<Trial> {
        if trial.early > 1.15 * best.early + 0.005 {
            return None;
        }
        let fine = (1..3).all(|k| self.solve(&mut trial, 0, self.options.steps[k]));
        (fine && trial.layout.score < best.layout.score).then_some(trial)
    }

    /// The trial of an aspect with `middle` (a part of the loop) at the middle of the side v = 0.
    fn trial(&mut self, size: Size, aspect: usize, middle: f64) -> Option<Trial> {
        let ((w, h), shift, count) = self.placed(size, aspect, middle)?;
        Some(Trial { aspect, middle, ..self.first((w, h), shift, count)? })
    }

    /// The cells, the shift and the steps of such a layout.
    fn placed(&self, size: Size, aspect: usize, middle: f64) -> Option<((u32, u32), f64, Vec<u32>)> {
        let (w, h) = cells(size, ASPECTS[aspect], self.border.least_steps())?;
        let count = self.border.share(2 * (w + h))?;
        let perimeter = f64::from(2 * (w + h));
        let mut shift = (0.5 * f64::from(w) - middle * perimeter).rem_euclid(perimeter);
        if !self.border.is_free() {
            shift = shift.round().rem_euclid(perimeter);
        }
        Some(((w, h), shift, count))
    }

    /// The layout that puts two nodes at the ends of the side v = 0, if its shape is a sensible one.
    fn trial_between(&mut self, size: Size, from: usize, to: usize) -> Option<Trial> {
        let least = self.border.least_steps();
        let part = |steps: &[u32], all: u32| f64::from((steps[to] + all - steps[from]) % all) / f64::from(all);
        let (mut w, mut h) = cells(size, 1.0, least)?;
        for _ in 0..3 {
            // The aspect moves the number of steps, and that the shares: a few rounds settle it.
            let all = 2 * (w + h);
            let count = self.border.share(all)?;
            let f = part(&self.border.node_steps(&count), all);
            if !(0.02..0.48).contains(&f) {
                return None;
            }
            (w, h) = cells(size, 2.0 * f / (1.0 - 2.0 * f), least)?;
        }
        let all = 2 * (w + h);
        let count = self.border.share(all)?;
        let steps = self.border.node_steps(&count);
        let side = (steps[to] + all - steps[from]) % all;
        if side < 2 || side + 2 > all / 2 || (matches!(size, Size::Fixed(..)) && side != w) {
            return None;
        }
        if !fits(side + 1, all / 2 - side + 1) {
            return None;
        }
        let shift = f64::from((all - steps[from]) % all);
        self.first((side, all / 2 - side), shift, count)
    }

    /// The layouts in which four paths are the four sides.
    fn trial_sides(&mut self, size: Size) -> Vec<Trial> {
        let Size::Fixed(width, height) = size else { return Vec::new() };
        let (w, h) = (width - 1, height - 1);
        [false, true]
            .into_iter()
            .filter_map(|turned| {
                let count = self.border.four_sides(w, h, turned)?;
                // Turned, the second path is the side v = 0.
                let shift = if turned { f64::from(w + 2 * h) } else { 0.0 };
                self.first((w, h), shift, count)
            })
            .collect()
    }

    /// The best layout found. `None` if none can be laid out.
    pub(crate) fn search(&mut self, size: Size) -> Option<Layout> {
        self.search_map(size).map(|found| found.0)
    }

    /// The best layout found, and the map of the stand-in if one was free of flips.
    pub(crate) fn search_map(&mut self, size: Size) -> Option<(Layout, Vec<[f64; 2]>)> {
        let shifts = self.options.shifts.max(1);
        // A half turn of the rectangle is the same map, so half the loop is enough; a fixed size likewise.
        let mut rough: Vec<(f64, f64)> = (0..shifts)
            .filter_map(|k| {
                let middle = 0.5 * k as f64 / shifts as f64;
                let ((w, h), shift, count) = self.placed(size, 2, middle)?;
                Some((self.begin((w, h), shift, count, 1)?.layout.score, middle))
            })
            .collect();
        rough.sort_by(|a, b| a.0.total_cmp(&b.0));
        rough.truncate(self.options.rough.max(1));
        let mut found: Vec<Trial> = rough.into_iter().filter_map(|(_, middle)| self.trial(size, 2, middle)).collect();
        for (lot, keep) in self.options.keep.into_iter().enumerate() {
            found.sort_by(|a, b| a.layout.score.total_cmp(&b.layout.score));
            found.truncate(keep.max(1));
            found.retain_mut(|t| self.solve(t, 0, self.options.steps[lot + 1]));
        }
        if found.is_empty() {
            // Too coarse to be flip-free anywhere: fall back to the first start that can be laid out at all.
            let (w, h) = cells(size, 1.0, self.border.least_steps())?;
            let count = self.border.share(2 * (w + h))?;
            return Some((Layout { w, h, shift: 0.0, count, score: f64::INFINITY }, Vec::new()));
        }
        let best = |found: &[Trial]| {
            let k = (0..found.len())
                .min_by(|a, b| found[*a].layout.score.total_cmp(&found[*b].layout.score).then(a.cmp(b)));
            k.and_then(|k| found.get(k).cloned())
        };
        if self.options.refine && matches!(size, Size::Budget(_)) {
            found.iter_mut().for_each(|t| self.refine_aspect(size, t));
        }
        let mut best = best(&found)?;
        if self.options.refine {
            let mut step = 0.25 / shifts as f64;
            for _ in 0..2 {
                for m in [best.middle - step, best.middle + step] {
                    if let Some(t) = self.trial(size, best.aspect, m).and_then(|t| self.all(t, &best)) {
                        best = t;
                    }
                }
                step *= 0.5;
            }
        }
        for t in self.snapped(size, &best.layout) {
            if let Some(t) = self.all(t, &best) {
                best = t;
            }
        }
        Some((best.layout, best.uv))
    }

    /// Walks along the aspects while that helps.
    fn refine_aspect(&mut self, size: Size, trial: &mut Trial) {
        for direction in [1, -1] {
            while let Some(next) = trial.aspect.checked_add_signed(direction).filter(|&k| k < ASPECTS.len()) {
                match self.trial(size, next, trial.middle).and_then(|t| self.all(t, trial)) {
                    Some(t) => *trial = t,
                    None => break,
                }
            }
        }
    }

    /// Layouts with nodes on corners of the image: what a rectangle or a tube wants, and a search over steps misses.
    fn snapped(&mut self, size: Size, near: &Layout) -> Vec<Trial> {
        if self.border.is_free() || self.options.snap == 0 {
            return Vec::new();
        }
        let all = f64::from(2 * (near.w + near.h));
        let steps = self.border.node_steps(&near.count);
        let at = |k: usize| (f64::from(steps[k]) + near.shift).rem_euclid(all);
        let off = |p: f64, corner: f64| {
            let d = (p - corner).rem_euclid(all);
            d.min(all - d)
        };
        // Pairs of nodes nearest to two neighbouring corners of the best layout, in both of its half turns.
        let (w, h) = (f64::from(near.w), f64::from(near.h));
        let corners = [0.0, w, w + h, 2.0 * w + h];
        let many = self.options.snap;
        // A pair among the best has both nodes among the best for their corners: hundreds of nodes make few pairs.
        let nearest = |corner: f64| {
            let mut order: Vec<(f64, usize)> = (0..steps.len()).map(|k| (off(at(k), corner), k)).collect();
            order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            order.truncate(many + 1);
            order
        };
        let near = corners.map(nearest);
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for c in 0..4 {
            for &(a, from) in &near[c] {
                for &(b, to) in near[(c + 1) % 4].iter().filter(|x| x.1 != from) {
                    pairs.push((a + b, from, to));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut seen = std::collections::BTreeSet::new();
        pairs.retain(|p| seen.insert((p.1, p.2)));
        pairs.truncate(many);
        let mut out: Vec<Trial> =
            pairs.into_iter().filter_map(|(_, from, to)| self.trial_between(size, from, to)).collect();
        out.extend(self.trial_sides(size));
        out
    }
}

/// Cells of an image of a size and aspect, or the smallest that holds `least` border steps. `None` if that is not the
/// fixed size, or more than an image can have.
pub(crate) fn cells(size: Size, aspect: f64, least: u32) -> Option<(u32, u32)> {
    match size {
        Size::Fixed(w, h) => (w >= 3 && h >= 3 && 2 * (w + h - 2) >= least).then(|| (w - 1, h - 1)),
        Size::Budget(texels) => {
            let t = f64::from(texels.max(9));
            let mut w = ((t * aspect).sqrt().floor() as u32).max(3);
            let mut h = (texels / w).max(3);
            while 2 * (w - 1 + h - 1) < least {
                if f64::from(w) <= aspect * f64::from(h) { w += 1 } else { h += 1 }
            }
            fits(w, h).then_some((w - 1, h - 1))
        }
    }
}

/// Whether an image of this many texels across and down can be stored.
fn fits(width: u32, height: u32) -> bool {
    width.max(height) <= gimage_bundle::MAX_SIDE
        && u64::from(width) * u64::from(height) <= u64::from(gimage_bundle::MAX_PARTICLES)
}

/// The smallest image (width, height in texels), square or nearly, that holds `least` border steps.
pub(crate) fn smallest(least: u32) -> (u32, u32) {
    let half = least.div_ceil(2).max(4);
    let w = half.div_ceil(2);
    (w + 1, (half - w).max(2) + 1)
}

/// Vertices where a map of the stand-in stretches most, at most `many`, the worst first, each at least `apart` from
/// the others and all `allowed`.
pub(crate) fn most_stretched(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    uv: &[[f64; 2]],
    many: usize,
    apart: f64,
    allowed: impl Fn(u32) -> bool,
) -> Vec<u32> {
    let mut order: Vec<(f64, usize)> = triangles
        .iter()
        .enumerate()
        .map(|(k, &t)| (distortion::triangle_stretch(positions, t, uv), k))
        .filter(|x| x.0.is_finite())
        .collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut out: Vec<u32> = Vec::new();
    for (_, k) in order {
        if out.len() == many {
            break;
        }
        let far = |v: u32| {
            let p = positions[v as usize];
            out.iter().all(|&o| crate::vec3::distance(p, positions[o as usize]) > apart)
        };
        if let Some(v) = triangles[k].into_iter().find(|&v| allowed(v) && far(v)) {
            out.push(v);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;
    use crate::surface::Surface;
    use proptest::prelude::*;

    const SEARCH: SearchOptions = SearchOptions {
        triangles: 400,
        shifts: 12,
        rough: 12,
        passes: 3,
        steps: [3, 4, 5],
        keep: [12, 3],
        refine: true,
        snap: 6,
    };

    fn searched(s: &Surface, size: Size) -> (Layout, Vec<u32>) {
        let rim = shapes::rim(s);
        let mut disk = shapes::opened(s, &[]);
        let border = Border::new(&mut disk, |v| rim[v as usize]);
        let layout = Proxy::new(&disk, &border, SEARCH).search(size).unwrap();
        let dead = border.dead_ends(&layout.count);
        (layout, dead)
    }

    #[test]
    fn a_rectangle_and_a_tube_are_laid_out_without_distortion() {
        // 24 x 12 cells of a 2 x 1 m sheet are squares; the tube of circumference 1 and length 0.5 likewise.
        for s in [shapes::rectangle(16, 8, 2.0, 1.0), shapes::rectangle(8, 16, 1.0, 2.0)] {
            for size in [Size::Fixed(25, 13), Size::Fixed(13, 25)] {
                let l = searched(&s, size).0;
                // As near as the search's short solve goes.
                assert!(l.score.abs() < 1e-5, "{size:?}: {}", l.score);
            }
            let l = searched(&s, Size::Budget(325)).0;
            assert!(l.score < 1e-2, "{l:?}");
        }
        let l = searched(&shapes::tube(64, 8, 0.5), Size::Fixed(25, 13)).0;
        assert!(l.score.abs() < 1e-4, "{l:?}");
    }

    #[test]
    fn dead_ends_are_never_on_a_corner_of_the_image() {
        for (name, s) in shapes::all() {
            let (l, dead) = searched(&s, Size::Budget(400));
            if l.score.is_finite() {
                let all = 2 * (l.w + l.h);
                let at = |d: u32| (f64::from(d) + l.shift).rem_euclid(f64::from(all)) as u32;
                for d in dead {
                    assert!(![0, l.w, l.w + l.h, 2 * l.w + l.h].contains(&at(d)), "{name}");
                }
            }
        }
    }

    #[test]
    fn an_image_too_small_for_the_border_is_refused() {
        assert_eq!(cells(Size::Fixed(5, 5), 1.0, 16), Some((4, 4)));
        assert_eq!(cells(Size::Fixed(5, 5), 1.0, 18), None);
        assert_eq!(cells(Size::Fixed(2, 50), 1.0, 8), None);
    }

    #[test]
    fn no_image_is_longer_or_larger_than_can_be_stored() {
        let cap = gimage_bundle::MAX_PARTICLES;
        assert!(cells(Size::Budget(cap), 1.0 / 24.0, 8).is_none());
        assert!(cells(Size::Budget(100), 1.0, 4 * gimage_bundle::MAX_SIDE).is_none());
        let (w, h) = cells(Size::Budget(cap), 1.0, 8).unwrap();
        assert!((w + 1) * (h + 1) <= cap);
    }

    proptest! {
        #[test]
        fn cells_keep_the_budget_and_hold_the_border(texels in 64u32..2_000_000, aspect in 0.2f64..6.4, least in 8u32..5000) {
            let (w, h) = cells(Size::Budget(texels), aspect, least).unwrap();
            prop_assert!(2 * (w + h) >= least);
            // More than the budget only where the border needs it, and then no more than it needs.
            prop_assert!((w + 1) * (h + 1) <= texels || 2 * (w + h) <= least.max(8) + 1);
        }

        #[test]
        fn the_smallest_image_holds_the_border(least in 8u32..10_000) {
            let (w, h) = smallest(least);
            prop_assert!(w >= 3 && h >= 3);
            prop_assert_eq!(cells(Size::Fixed(w, h), 1.0, least), Some((w - 1, h - 1)));
            prop_assert!(w.abs_diff(h) <= 1 && 2 * (w + h - 2) <= least + 3);
        }
    }
}
