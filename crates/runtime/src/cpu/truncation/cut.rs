//! Holds points back: each ends in all of its half-spaces and within its reach, as near to where it wants to be as they let it.

use super::planes::HalfSpace;
use super::{HELD_STEPS, ROUNDING, Truncation};
use crate::number::real::{V3, add, dot, scale, sub};

/// Rounds of projection onto half-spaces, one after the other.
const ROUNDS: usize = 4;
/// Halvings of the way that rounding may take.
const HALVINGS: usize = 6;

/// Share of its reach that a point has used up that needs a further search.
const SHORT_SHARE: f64 = 0.9;

/// How points were held back.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cut {
    /// Points held back by half-spaces.
    pub held: usize,
    /// Points that have used up their reach.
    pub short: usize,
    /// Pins that left their half-spaces or their reach.
    pub forced: usize,
}

/// The room of a point in a step.
struct Room<'a> {
    planes: &'a [HalfSpace],
    /// Where its drift has taken it.
    at: V3<f64>,
    reach: f64,
}

impl Room<'_> {
    fn is_within_reach(&self, p: V3<f64>) -> bool {
        let way = sub(p, self.at);
        dot(way, way) <= self.reach * self.reach
    }

    fn has(&self, p: V3<f64>) -> bool {
        self.is_within_reach(p) && self.planes.iter().all(|plane| dot(plane.normal, p) <= plane.most)
    }

    /// The nearest point within reach and, after some rounds, nearly in all half-spaces, `slop` \[m\] inside.
    fn project(&self, want: V3<f64>, slop: f64) -> V3<f64> {
        let mut p = want;
        for _ in 0..ROUNDS {
            let mut moved = false;
            for plane in self.planes {
                let over = dot(plane.normal, p) - plane.most;
                if over > 0.0 {
                    p = sub(p, scale(plane.normal, over + slop));
                    moved = true;
                }
            }
            let way = sub(p, self.at);
            let far2 = dot(way, way);
            if far2 > self.reach * self.reach {
                p = toward(self.at, p, (self.reach - slop).max(0.0) / far2.sqrt());
                moved = true;
            }
            if !moved {
                break;
            }
        }
        p
    }

    /// The position nearest to `to` on the way from `from` that the room has, as f32 has it; none if it has no such position.
    fn clip(&self, from: V3<f64>, to: V3<f64>, slop: f64) -> Option<V3<f64>> {
        let rounded = |p: V3<f64>| p.map(|x| f64::from(x as f32));
        if self.has(rounded(to)) {
            return Some(rounded(to));
        }
        let mut share = 1.0f64;
        for plane in self.planes {
            let (begin, end) = (dot(plane.normal, from), dot(plane.normal, to));
            if end > plane.most - slop && end > begin {
                share = share.min(((plane.most - slop - begin) / (end - begin)).max(0.0));
            }
        }
        for _ in 0..HALVINGS {
            let p = rounded(toward(from, to, share));
            if self.has(p) {
                return Some(p);
            }
            share *= 0.5;
        }
        self.has(from).then_some(from)
    }
}

/// A point on a way, 0 at its beginning.
fn toward(from: V3<f64>, to: V3<f64>, share: f64) -> V3<f64> {
    add(from, scale(sub(to, from), share))
}

impl Truncation {
    /// Finds where all points can be that is nearest to where they want to be; `next` has that, unless one fails: it can neither go on as it
    /// did nor stay. If a search of an earlier step goes on, points that have used up their reach, or that it has held back for long, fail too.
    pub(super) fn cut(&mut self, goes_on: bool) -> Cut {
        let mut cut = Cut::default();
        self.short.clear();
        self.failing.clear();
        self.next.clone_from(&self.want);
        for k in 0..self.last.len() {
            let (from, want) = (self.last[k], self.want[k]);
            let room = self.room(k);
            if room.has(want) || !want.iter().all(|x| x.is_finite()) {
                continue;
            }
            if !self.free[k] {
                cut.forced += 1;
                continue;
            }
            let slop = ROUNDING * from.iter().chain(&want).fold(0.0f64, |far, x| far.max(x.abs()));
            let was_renewed = self.since[k] == self.age;
            let Some(to) = room.clip(from, room.project(want, slop), slop) else {
                if self.stuck[k] && was_renewed {
                    // Where it is belongs to its room, but for numbers that are not finite: it stays.
                    self.next[k] = from;
                } else {
                    self.stuck[k] = true;
                    self.failing.push(k as u32);
                }
                continue;
            };
            // One that half-spaces hold well within its reach gets no farther by a further search.
            let way = sub(to, room.at);
            let edge = SHORT_SHARE * room.reach;
            let ahead = dot(way, sub(want, room.at)) > 0.0;
            if ahead && !room.is_within_reach(want) && dot(way, way) > edge * edge {
                cut.short += 1;
                self.short.push(k as u32);
                if goes_on && !was_renewed {
                    self.failing.push(k as u32);
                }
            } else {
                cut.held += 1;
                if goes_on && self.age - self.since[k] + 1 >= HELD_STEPS {
                    self.failing.push(k as u32);
                }
            }
            self.next[k] = to;
        }
        cut
    }

    fn room(&self, k: usize) -> Room<'_> {
        let drift = scale(self.drift[k], f64::from(self.age));
        Room { planes: self.planes.of(k), at: add(self.at[k], drift), reach: self.reach[k] }
    }

    /// Whether a pin goes where the last search does not allow it.
    pub(super) fn pins_leave(&self) -> bool {
        (0..self.last.len())
            .filter(|k| !self.free[*k] && self.want[*k] != self.last[*k])
            .any(|k| !self.room(k).has(self.want[k]))
    }
}
