//! The search: every start at one aspect roughly, the best of them further, then aspects, starts and corners around these.

use super::proxy::{Proxy, Trial};
use super::{Layout, Size, cells, exact_cells, fits};
use crate::stage::parameterize::Start;

/// How hard to search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchOptions {
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

impl SearchOptions {
    /// Takes about as long as the map of the whole disk.
    pub const DEFAULT: Self =
        Self { triangles: 600, shifts: 12, rough: 3, passes: 2, steps: [1, 2, 3], keep: [3, 1], refine: true, snap: 3 };

    /// For previews: half as many starts, and neither aspect nor start is refined.
    pub const FAST: Self = Self { shifts: 6, keep: [2, 1], refine: false, snap: 2, ..Self::DEFAULT };

    /// Several times as long as the default: every start takes Newton steps, on a stand-in of five times the triangles.
    pub const BEST: Self =
        Self { triangles: 3000, shifts: 24, rough: 24, steps: [2, 4, 8], keep: [12, 6], snap: 6, ..Self::DEFAULT };

    /// For a cut on trial ([`mod@crate::stage::cut::grow`]): it runs for every point that a cut may grow to, so it keeps only one layout.
    /// `triangles` is the size of the stand-in that is cut.
    pub(crate) fn trial(triangles: usize) -> Self {
        Self { triangles, shifts: 6, rough: 2, steps: [1, 2, 6], keep: [1, 1], refine: false, snap: 1, ..Self::DEFAULT }
    }
}

/// Scores that differ by less are equal: nodes on corners of the image are then better, which a stand-in of few triangles
/// cannot tell.
const EQUAL: f64 = 1e-6;

/// Bound on a score as a multiple of another score plus a constant: near an isometry scores are so close to 0 that a
/// factor alone would be too strict.
#[derive(Clone, Copy)]
struct Bound {
    factor: f64,
    extra: f64,
}

impl Bound {
    fn above(self, score: f64) -> f64 {
        self.factor * score + self.extra
    }
}

/// A search ends where its best score is above this bound on that of another cut, after the first and after the second
/// lot of steps. The later the comparison, the less a score can still change.
const WORSE_CUT: [Bound; 2] = [Bound { factor: 1.03, extra: 0.005 }, Bound { factor: 1.02, extra: 0.002 }];

/// A trial ends where its score after the first lot of steps is above this bound on that of the best trial.
const WORSE_TRIAL: Bound = Bound { factor: 1.15, extra: 0.005 };

/// Width : height ratios tried, in steps from square.
pub(super) const ASPECTS: [f64; 9] = [1.0, 1.25, 1.6, 2.0, 2.5, 3.2, 4.0, 5.0, 6.4];

/// Step of the further ratios of a strip.
const STRIP_ASPECTS: f64 = 1.25;

/// Index of the aspect at which starts are compared: 1.6, from which the refinement walks both ways.
const FIRST_ASPECT: usize = 2;

/// Least share of the border that the side between two nodes may have: below it the image is a strip.
pub(super) const LEAST_SIDE: f64 = 0.02;

/// Least share of such a side of a strip, in units of the share of its end.
const LEAST_END: f64 = 0.5;

/// Steps of a border, in units of the fewest it can have, up to which its image has no room to get smaller.
const TIGHT: f64 = 1.05;

/// Rounds in which an aspect, its steps and the shares of these settle.
const SETTLING_ROUNDS: usize = 3;

/// First step by which a start is refined, as a share of the loop that all starts together are spread over: half the
/// distance of two starts, as these are spread over half the loop.
const REFINED_START: f64 = 0.25;
/// Rounds of refinement; each halves the step.
const REFINEMENTS: usize = 2;

/// The largest aspect of an image of a budget: three texels across.
fn longest(size: Size) -> Option<f64> {
    if let Size::Budget(texels) = size { Some(f64::from(texels.max(9)) / 9.0) } else { None }
}

/// The result of a search.
#[derive(Debug)]
pub(crate) struct Found {
    pub layout: Layout,
    /// The map of the stand-in, empty if none was free of flips.
    pub uv: Vec<[f64; 2]>,
    /// The least score after the first and the second lot of steps.
    pub early: [f64; 2],
}

impl Proxy<'_> {
    /// A trial's first lot of steps.
    fn first(&mut self, (w, h): (u32, u32), shift: f64, count: Vec<u32>) -> Option<Trial> {
        let trial = self.begin((w, h), shift, count, self.options.passes)?;
        self.first_steps(trial)
    }

    fn first_steps(&mut self, mut trial: Trial) -> Option<Trial> {
        let fine = self.solve(&mut trial, Start::Map, self.options.steps[0]);
        trial.early = trial.layout.score;
        fine.then_some(trial)
    }

    /// All steps of a trial, unless it starts out much worse than the `best`; none if it ends worse by `more`.
    fn all(&mut self, mut trial: Trial, best: &Trial, more: f64) -> Option<Trial> {
        if trial.early > WORSE_TRIAL.above(best.early) {
            return None;
        }
        let fine = (1..3).all(|k| self.solve(&mut trial, Start::Map, self.options.steps[k]));
        (fine && trial.layout.score < best.layout.score + more).then_some(trial)
    }

    /// The trial of an aspect with `middle` (a part of the loop) at the middle of the side v = 0.
    fn trial(&mut self, size: Size, aspect: usize, middle: f64) -> Option<Trial> {
        let ((w, h), shift, count) = self.placed(size, aspect, middle)?;
        Some(Trial { aspect, middle, ..self.first((w, h), shift, count)? })
    }

    /// Widens the search to the ratios of a strip, up to those that leave three texels across. Returns the ratio nearest to
    /// its own and the part of the loop at the middle of a long side.
    fn widen(&mut self, size: Size) -> Option<(usize, f64)> {
        let strip = self.strip?;
        let most = longest(size)?;
        self.aspects = ASPECTS.to_vec();
        let (mut aspect, mut nearest) = (ASPECTS[ASPECTS.len() - 1], ASPECTS.len() - 1);
        while aspect < (STRIP_ASPECTS * strip.aspect).min(most) {
            aspect = (aspect * STRIP_ASPECTS).min(most);
            self.aspects.push(aspect);
            if (aspect / strip.aspect).ln().abs() < (self.aspects[nearest] / strip.aspect).ln().abs() {
                nearest = self.aspects.len() - 1;
            }
        }
        let end = 0.5 / (1.0 + strip.aspect.min(most));
        self.least_side = LEAST_SIDE.min(LEAST_END * end);
        Some((nearest, strip.end + 0.25))
    }

    /// The cells of an image of a size and aspect that holds the border.
    fn cells(&self, size: Size, aspect: f64) -> Option<(u32, u32)> {
        match (self.border.exact_steps(), size) {
            (Some(steps), Size::Budget(_)) => exact_cells(aspect, steps),
            _ => {
                let most = self.strip.and_then(|_| longest(size)).unwrap_or(f64::INFINITY);
                cells(size, aspect.clamp(1.0 / most, most), self.border.least_steps())
            }
        }
    }

    /// The cells, the shift and the steps of such a layout.
    fn placed(&self, size: Size, aspect: usize, middle: f64) -> Option<((u32, u32), f64, Vec<u32>)> {
        let (w, h) = self.cells(size, self.aspects[aspect])?;
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
        let part = |steps: &[u32], all: u32| f64::from((steps[to] + all - steps[from]) % all) / f64::from(all);
        let (mut w, mut h) = self.cells(size, 1.0)?;
        for _ in 0..SETTLING_ROUNDS {
            // The aspect moves the number of steps, and that the shares: a few rounds settle it.
            let all = 2 * (w + h);
            let count = self.border.share(all)?;
            let f = part(&self.border.node_steps(&count), all);
            if !(self.least_side..0.5 - self.least_side).contains(&f) {
                return None;
            }
            (w, h) = self.cells(size, 2.0 * f / (1.0 - 2.0 * f))?;
        }
        let all = 2 * (w + h);
        let count = self.border.share(all)?;
        let steps = self.border.node_steps(&count);
        let side = (steps[to] + all - steps[from]) % all;
        if let Size::Budget(texels) = size {
            let area = |w: u32, h: u32| u64::from(w + 1) * u64::from(h + 1);
            let tight = f64::from(all) <= TIGHT * f64::from(self.border.least_steps());
            // Made again with a smaller budget, it would be as large.
            if tight
                && side < all / 2
                && area(w, h) <= u64::from(texels)
                && area(side, all / 2 - side) > u64::from(texels)
            {
                return None;
            }
        }
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

    /// The best layout found, and the map of the stand-in if one was free of flips. `None` too if it is going to be worse
    /// than searches of other cuts, the least of whose [`Found::early`] are `than`.
    pub(crate) fn search_map(&mut self, size: Size, than: Option<[f64; 2]>) -> Option<Found> {
        let bar = than.map_or([f64::INFINITY; 2], |early| [0, 1].map(|lot| WORSE_CUT[lot].above(early[lot])));
        let mut early = [f64::INFINITY; 2];
        let shifts = self.options.shifts.max(1);
        // A half turn of the rectangle is the same map, so half the loop is enough; a fixed size likewise.
        let strip = self.widen(size);
        let mut begun = |(aspect, middle)| {
            let ((w, h), shift, count) = self.placed(size, aspect, middle)?;
            Some(Trial { aspect, middle, ..self.begin((w, h), shift, count, 1)? })
        };
        let starts = (0..shifts).map(|k| (FIRST_ASPECT, 0.5 * k as f64 / shifts as f64));
        let mut rough: Vec<Trial> = starts.filter_map(&mut begun).collect();
        let strip = strip.and_then(&mut begun);
        rough.sort_by(|a, b| a.layout.score.total_cmp(&b.layout.score));
        rough.truncate(self.options.rough.max(1));
        // Its plain map says little: caps at the ends of a tube are crushed in it.
        rough.extend(strip);
        let passes = self.options.passes;
        let mut go_on = |mut t: Trial| {
            let start = if t.plain { Start::Plain { passes } } else { Start::Convex { passes } };
            if self.solve(&mut t, start, 0) { self.first_steps(t) } else { None }
        };
        let mut found: Vec<Trial> = rough.into_iter().filter_map(&mut go_on).collect();
        let least = |found: &[Trial]| found.iter().map(|t| t.layout.score).fold(f64::INFINITY, f64::min);
        early[0] = least(&found);
        if early[0] > bar[0] {
            return None;
        }
        for (lot, keep) in self.options.keep.into_iter().enumerate() {
            found.sort_by(|a, b| a.layout.score.total_cmp(&b.layout.score));
            found.truncate(keep.max(1));
            found.retain_mut(|t| self.solve(t, Start::Map, self.options.steps[lot + 1]));
            if lot == 0 {
                early[1] = least(&found);
                if early[1] > bar[1] {
                    return None;
                }
            }
        }
        if found.is_empty() {
            // Too coarse to be flip-free at any of these starts: one with nodes on corners may be, else the first start that
            // can be laid out at all.
            let (w, h) = self.cells(size, 1.0)?;
            let count = self.border.share(2 * (w + h))?;
            let first = Layout { w, h, shift: 0.0, count, score: f64::INFINITY };
            found = self.snapped(size, &first);
            if found.is_empty() {
                return Some(Found { layout: first, uv: Vec::new(), early });
            }
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
            let mut step = REFINED_START / shifts as f64;
            for _ in 0..REFINEMENTS {
                for m in [best.middle - step, best.middle + step] {
                    if let Some(t) = self.trial(size, best.aspect, m).and_then(|t| self.all(t, &best, 0.0)) {
                        best = t;
                    }
                }
                step *= 0.5;
            }
        }
        for t in self.snapped(size, &best.layout) {
            if let Some(t) = self.all(t, &best, EQUAL) {
                best = t;
            }
        }
        Some(Found { layout: best.layout, uv: best.uv, early })
    }

    /// Walks along the aspects while that helps.
    fn refine_aspect(&mut self, size: Size, trial: &mut Trial) {
        for direction in [1, -1] {
            while let Some(next) = trial.aspect.checked_add_signed(direction).filter(|&k| k < self.aspects.len()) {
                match self.trial(size, next, trial.middle).and_then(|t| self.all(t, trial, 0.0)) {
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
