//! Half-spaces that keep pairs of features apart (Planar-DAT, "divide and truncate", arXiv 2604.15513).
//!
//! Two features that are convex lie on both sides of a slab, whose normal is the shortest way between them. Each gets a half-space; while
//! their points stay in these, and move in straight lines, the features do not meet. Differences from the paper: the sides are measured
//! along the normal, so that rounding of the closest points does no harm, and a gap never falls below a floor.

use crate::cpu::untangle::loose::Loose;
use crate::memory::Tally;
use crate::number::real::{V3, dot, scale, sub};

/// Share of a gap that two features may use up until the next search.
const GAP_SHARE: f64 = 0.8;

/// `normal . x <= most` for a point.
#[derive(Clone, Copy, Debug)]
pub struct HalfSpace {
    pub normal: V3<f64>,
    pub most: f64,
}

/// The points as a search finds them.
pub struct Points<'a> {
    pub at: &'a [V3<f64>],
    /// Where they are to go.
    pub want: &'a [V3<f64>],
    /// Whether truncation may hold a point back; pins go where they are told.
    pub free: &'a [bool],
    /// The cloth of each point, and which points it may pass; none if empty.
    pub loose: &'a [(u32, Loose)],
    /// The way that each is expected to go per step, and how far it may be from there.
    pub drift: &'a [V3<f64>],
    pub reach: &'a [f64],
    /// For points that are renewed true; none in a search.
    pub fresh: Option<&'a [bool]>,
    pub floor: f64,
    /// Steps until the next search.
    pub ahead: f64,
}

impl Points<'_> {
    /// Whether two features may pass one another.
    fn are_loose(&self, a: &[u32], b: &[u32]) -> bool {
        let Some((cloth, _)) = self.loose.get(a[0] as usize) else { return false };
        let within = b.iter().all(|k| self.loose[*k as usize].0 == *cloth);
        a.iter().chain(b).map(|k| self.loose[*k as usize].1).all(|loose| if within { loose.own } else { loose.others })
    }

    /// Whether a point of two features is renewed: pairs of others keep their half-spaces. In a search all are.
    #[inline]
    pub fn concerns(&self, a: &[u32], b: &[u32]) -> bool {
        self.fresh.is_none_or(|fresh| a.iter().chain(b).any(|k| fresh[*k as usize]))
    }

    /// How far a point may be from where its drift takes it, seen from where it is now: one that is not renewed may already be off.
    #[inline]
    fn reach_of(&self, k: u32) -> f64 {
        let whole = self.fresh.is_none_or(|fresh| fresh[k as usize]);
        if whole { self.reach[k as usize] } else { 2.0 * self.reach[k as usize] }
    }

    /// The distance \[m\] from which on two features cannot meet until the next search.
    #[inline]
    fn near(&self, a: &[u32], b: &[u32]) -> f64 {
        let of = |list: &[u32]| list.iter().map(|k| self.reach_of(*k)).fold(0.0, f64::max);
        let mut nearer2 = 0.0f64;
        for p in a {
            for q in b {
                let way = sub(self.drift[*p as usize], self.drift[*q as usize]);
                nearer2 = nearer2.max(dot(way, way));
            }
        }
        of(a) + of(b) + self.floor + self.ahead * nearer2.sqrt()
    }
}

/// All half-spaces, by points.
#[derive(Default)]
pub struct Planes {
    found: Vec<(u32, HalfSpace)>,
    starts: Vec<u32>,
    list: Vec<HalfSpace>,
}

impl Planes {
    /// The half-spaces of a point; none before the first search.
    #[inline]
    pub fn of(&self, point: usize) -> &[HalfSpace] {
        &self.list[self.starts[point] as usize..self.starts[point + 1] as usize]
    }

    /// Counts its lists.
    pub fn tally(&self, tally: &mut Tally) {
        tally.state(&self.found);
        tally.state(&self.list);
        tally.state(&self.starts);
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.found.clear();
    }

    /// Forgets the half-spaces of some points.
    pub fn forget(&mut self, of: &[bool]) {
        self.found.retain(|(point, _)| !of[*point as usize]);
    }

    /// Orders the half-spaces by `count` points, those of a point as they were found.
    pub fn arrange(&mut self, count: usize) {
        self.starts.clear();
        self.starts.resize(count + 1, 0);
        self.found.iter().for_each(|(point, _)| self.starts[*point as usize + 1] += 1);
        (1..=count).for_each(|n| self.starts[n] += self.starts[n - 1]);
        let mut ends = self.starts.clone();
        self.list.resize(self.found.len(), HalfSpace { normal: [0.0; 3], most: 0.0 });
        for (point, plane) in &self.found {
            let end = &mut ends[*point as usize];
            self.list[*end as usize] = *plane;
            *end += 1;
        }
    }

    /// Appends the half-spaces of another list.
    pub fn append(&mut self, other: &mut Planes) {
        self.found.append(&mut other.found);
    }

    /// Keeps two features apart, whose shortest way \[m\] goes from `a` to `b`.
    pub fn separate(&mut self, points: &Points, (a, b): (&[u32], &[u32]), way: V3<f64>) {
        if points.are_loose(a, b) {
            return;
        }
        let (far2, near) = (dot(way, way), points.near(a, b));
        // Features that touch have no slab between them. Comparisons with NaN are false.
        if !(far2 > 0.0 && far2 < near * near) {
            return;
        }
        let far = far2.sqrt();
        let normal = scale(way, 1.0 / far);
        let side = |k: &u32| dot(normal, points.at[*k as usize]);
        let high = a.iter().map(side).fold(f64::NEG_INFINITY, f64::max);
        let low = b.iter().map(side).fold(f64::INFINITY, f64::min);
        let gap = low - high;
        if gap < 0.5 * far {
            return self.close(points, (a, b), far);
        }
        let slack = gap - gap.min(points.floor.max((1.0 - GAP_SHARE) * gap));
        // The side that moves towards the other gets more of it; a pin all that it needs.
        let (mut moves, mut must) = ([0.0f64; 2], [0.0f64; 2]);
        for (n, (list, sign)) in [(a, 1.0), (b, -1.0)].into_iter().enumerate() {
            for k in list.iter().map(|k| *k as usize) {
                let step = sign * (dot(normal, points.want[k]) - dot(normal, points.at[k]));
                moves[n] = moves[n].max(step);
                if !points.free[k] {
                    // Another point of the feature may be the nearest one.
                    let side = sign * dot(normal, points.want[k]) - if n == 0 { high } else { -low };
                    must[n] = must[n].max(side);
                }
            }
        }
        let even = 0.05 * gap;
        let share = slack * (moves[0] + even) / (moves[0] + moves[1] + 2.0 * even);
        let share = share.max(must[0]).min((slack - must[1]).max(0.0)).min(slack);
        for (list, sign, most) in [(a, 1.0, high + share), (b, -1.0, -(low - (slack - share)))] {
            let normal = scale(normal, sign);
            for k in list {
                let p = *k as usize;
                let ahead = dot(normal, points.drift[p]).max(0.0) * points.ahead;
                if dot(normal, points.at[p]) + ahead + points.reach_of(*k) > most {
                    self.found.push((*k, HalfSpace { normal, most }));
                }
            }
        }
    }

    /// Keeps all points of two features that are `far` \[m\] apart in cubes around where they are: for edges that are nearly parallel and
    /// cross, whose shortest way rounding may turn.
    fn close(&mut self, points: &Points, (a, b): (&[u32], &[u32]), far: f64) {
        // The half diagonal of a cube is less than twice its half side.
        let half = 0.25 * (far - points.floor.min(0.5 * far));
        for k in a.iter().chain(b) {
            for c in 0..3 {
                for sign in [1.0, -1.0] {
                    let mut normal = [0.0; 3];
                    normal[c] = sign;
                    let most = sign * points.at[*k as usize][c] + half;
                    self.found.push((*k, HalfSpace { normal, most }));
                }
            }
        }
    }
}
