//! Places solids along a body, and divides those that fit badly.

use rayon::prelude::*;

use super::bounded::bounded;
use super::refine::{best, error, refined};
use super::samples::Sample;
use super::shape::{Kind, Shape, guess};
use super::solid::{Form, Solid};
use crate::base::vec3::{dot, sub};

/// Depth below which a surface sample of another solid counts, as a share of the target.
const BULGE: f64 = 0.5;
/// Rounds of assignment and refinement after a division, and at the end.
const ROUNDS: usize = 3;
const LAST_ROUNDS: usize = 12;
/// Steps of refinement per round.
const STEPS: usize = 4;
/// Fewest samples of the surface of a solid that is divided, and of one that stays.
const DIVISIBLE: usize = 40;
const USED: usize = 6;
/// Largest share of its thickness by which a solid gets thinner on each side to leave the garments outside.
const CLEARED: f64 = 0.25;
/// Divisions that are tried per solid, at most.
const ATTEMPTS: usize = 3;
/// A point outside counts for solids that come so near \[targets\] to the distance that they must keep.
const NEAR: f64 = 20.0;

/// A solid that follows a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    pub joint: Option<u32>,
    pub solid: Solid,
}

/// Limits of a fit.
pub(super) struct Limits<'a> {
    pub kinds: &'a [Kind],
    /// Distance \[m\] that 95 % of the samples may have.
    pub target: f64,
    /// Largest number of solids.
    pub count: usize,
    /// Smallest thickness \[m\] of the solids of a division: cloth passes through thin ones.
    pub thin: f64,
}

/// Solids whose common surface lies near the samples: one per joint, then more where it is farthest, until 95 % of the samples of the
/// surface are within the target or the number is reached. Deterministic.
///
/// Distances are those of the union: of a sample, the least signed distance of all solids. Rounds assign each sample to the
/// solid of its joint that is active there, and to solids of other joints that bulge over it, and then refine each solid.
pub(super) fn fit(samples: &[Sample], limits: &Limits) -> Vec<Placed> {
    let mut joints: Vec<Option<u32>> = samples.iter().map(|s| s.joint).collect();
    joints.sort_unstable();
    joints.dedup();
    let of_joint = |joint: &Option<u32>| {
        let its: Vec<_> = samples.iter().filter(|s| s.joint == *joint).copied().collect();
        best(limits.kinds, &its).map(|solid| Placed { joint: *joint, solid })
    };
    let mut placed: Vec<Placed> = joints.par_iter().filter_map(of_joint).collect();
    (0..ROUNDS).for_each(|_| round(&mut placed, samples, limits, false));
    let mut given_up: Vec<Solid> = Vec::new();
    // Solids that were given up change with their neighbours, and are tried again.
    let attempts = ATTEMPTS * limits.count;
    for _ in 0..attempts {
        if placed.len() >= limits.count {
            break;
        }
        let state = State::new(&placed, samples);
        if state.within(samples, limits.target) {
            break;
        }
        let open = |k: &usize| !given_up.contains(&placed[*k].solid);
        let Some(worst) = state.worst(samples, limits.target, open) else { break };
        let halves = divided(&state.list(samples, worst, limits.target), limits.kinds);
        match halves.filter(|halves| halves.iter().all(|s| s.form.thickness() >= limits.thin)) {
            Some([one, other]) => {
                placed[worst].solid = one;
                placed.insert(worst + 1, Placed { solid: other, ..placed[worst] });
                (0..ROUNDS).for_each(|_| round(&mut placed, samples, limits, false));
            }
            None => given_up.push(placed[worst].solid),
        }
    }
    (0..LAST_ROUNDS).for_each(|k| round(&mut placed, samples, limits, k == 0));
    let counts = State::new(&placed, samples).counts(samples);
    let mut counts = counts.iter();
    placed.retain(|_| counts.next().is_some_and(|c| *c >= USED));
    for p in &mut placed {
        p.solid = bounded(p.solid, p.joint, samples);
        p.solid.form = clear(&p.solid, samples);
    }
    placed
}

/// The form of a solid, made thinner so that no point that must stay outside is in it, by at most [`CLEARED`] of its thickness.
fn clear(solid: &Solid, samples: &[Sample]) -> Form {
    let outside = samples.iter().filter(|s| s.is_outside());
    let depth = outside.map(|s| -solid.distance(s.point)).fold(0.0, f64::max);
    solid.form.shrunk(depth.min(CLEARED * solid.form.thickness()))
}

/// Refines each solid on the samples that it is responsible for; with `any`, another kind may take its place.
fn round(placed: &mut Vec<Placed>, samples: &[Sample], limits: &Limits, any: bool) {
    let state = State::new(placed, samples);
    let refine = |k: usize| {
        let list = state.list(samples, k, limits.target);
        let mut solid = refined(&placed[k].solid, &list, STEPS);
        let graded = |s: &Solid| Shape::of(s).kind.handicap() * error(s, &list);
        let other = if any { best(limits.kinds, &list) } else { None };
        if let Some(other) = other.filter(|o| graded(o) < 0.95 * graded(&solid)) {
            solid = other;
        }
        Placed { solid, ..placed[k] }
    };
    *placed = (0..placed.len()).into_par_iter().map(refine).collect();
}

/// Distances of all samples from all solids, and which solid each sample belongs to.
struct State {
    /// By solid, then by sample.
    distances: Vec<Vec<f64>>,
    /// The solid of its joint that is nearest, or deepest; none of points outside.
    owners: Vec<Option<usize>>,
}

impl State {
    fn new(placed: &[Placed], samples: &[Sample]) -> Self {
        let of = |p: &Placed| {
            let mut out = Vec::new();
            Shape::of(&p.solid).distances(samples, &mut out);
            out
        };
        let distances: Vec<Vec<f64>> = placed.par_iter().map(of).collect();
        let owner = |(i, s): (usize, &Sample)| {
            let all = (0..placed.len()).filter(|k| placed[*k].joint == s.joint && !s.is_outside());
            all.min_by(|a, b| distances[*a][i].total_cmp(&distances[*b][i]))
        };
        let owners = samples.iter().enumerate().map(owner).collect();
        State { distances, owners }
    }

    /// The samples that solid `k` is responsible for.
    fn list(&self, samples: &[Sample], k: usize, target: f64) -> Vec<Sample> {
        let counts = |i: &usize| match (&samples[*i], self.distances[k][*i]) {
            (s, d) if s.is_outside() => d < s.low + NEAR * target,
            (s, d) => self.owners[*i] == Some(k) || (s.is_on_surface() && d < -BULGE * target),
        };
        (0..samples.len()).filter(counts).map(|i| samples[i]).collect()
    }

    /// Samples of the surface that belong to each solid.
    fn counts(&self, samples: &[Sample]) -> Vec<usize> {
        let mut counts = vec![0; self.distances.len()];
        let surface = samples.iter().zip(&self.owners).filter(|(s, _)| s.is_on_surface());
        surface.filter_map(|(_, o)| *o).for_each(|k| counts[k] += 1);
        counts
    }

    /// Signed distance of sample `i` from the union.
    fn to_union(&self, i: usize) -> f64 {
        self.distances.iter().map(|d| d[i]).fold(f64::INFINITY, f64::min)
    }

    /// Whether 95 % of the surface are within the target.
    fn within(&self, samples: &[Sample], target: f64) -> bool {
        let surface = || (0..samples.len()).filter(|i| samples[*i].is_on_surface());
        let beyond = surface().filter(|i| self.to_union(*i).abs() > target).count();
        beyond * 20 <= surface().count()
    }

    /// The solid whose samples are farthest beyond the target, in sum of squares.
    fn worst(&self, samples: &[Sample], target: f64, open: impl Fn(&usize) -> bool) -> Option<usize> {
        let mut sums = vec![0.0; self.distances.len()];
        for (i, owner) in self.owners.iter().enumerate().filter(|(i, _)| samples[*i].is_on_surface()) {
            let Some(k) = *owner else { continue };
            sums[k] += (self.to_union(i).abs() - target).max(0.0).powi(2);
        }
        let counts = self.counts(samples);
        let divisible = |k: &usize| open(k) && counts[*k] >= DIVISIBLE && sums[*k] > 0.0;
        (0..sums.len()).filter(divisible).max_by(|a, b| sums[*a].total_cmp(&sums[*b]))
    }
}

/// Two solids for the samples on both sides of a plane across a principal axis, the best of three. Both keep away from points outside.
fn divided(samples: &[Sample], kinds: &[Kind]) -> Option<[Solid; 2]> {
    let surface: Vec<_> = samples.iter().filter(|s| s.is_on_surface()).map(|s| s.point).collect();
    let frame = guess(Kind::Box, &surface)?;
    let turn = frame.turn();
    let candidate = |axis: usize| {
        let axis: [f64; 3] = turn.matrix().column(axis).into_owned().into();
        let along = |p: [f64; 3]| dot(sub(p, frame.center), axis);
        let mut order: Vec<f64> = surface.iter().map(|p| along(*p)).collect();
        order.sort_by(f64::total_cmp);
        let middle = order[order.len() / 2];
        let half = |side: fn(&f64, &f64) -> bool| {
            let its = |s: &&Sample| s.is_outside() || side(&along(s.point), &middle);
            let its: Vec<Sample> = samples.iter().filter(its).copied().collect();
            let solid = best(kinds, &its)?;
            Some((error(&solid, &its).powi(2) * its.len() as f64, solid))
        };
        let (low, high) = (half(f64::lt)?, half(f64::ge)?);
        Some((low.0 + high.0, [low.1, high.1]))
    };
    let all: Vec<_> = (0..3).into_par_iter().map(candidate).collect();
    all.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, solids)| solids)
}
