//! Holds points back: each ends in all of its half-spaces and within its reach, as near to where it wants to be as they let it.

use super::planes::HalfSpace;
use super::{ROUNDING, Truncation, along};
use crate::number::real::{V3, dot, scale, sub};

/// Rounds of projection onto half-spaces, one after the other.
const ROUNDS: usize = 4;
/// Halvings of the way that rounding may take.
const HALVINGS: usize = 6;

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

/// The room of a point.
struct Room<'a> {
    planes: &'a [HalfSpace],
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
                p = along(self.at, p, (self.reach - slop).max(0.0) / far2.sqrt());
                moved = true;
            }
            if !moved {
                break;
            }
        }
        p
    }

    /// The last position on the way from `from`, which the room has, that the room has too, as f32 has it.
    fn clip(&self, from: V3<f64>, to: V3<f64>, slop: f64) -> V3<f64> {
        let rounded = |p: V3<f64>| p.map(|x| f64::from(x as f32));
        if self.has(rounded(to)) {
            return rounded(to);
        }
        let mut share = 1.0f64;
        for plane in self.planes {
            let (begin, end) = (dot(plane.normal, from), dot(plane.normal, to));
            if end > plane.most - slop {
                share = share.min(((plane.most - slop - begin) / (end - begin)).max(0.0));
            }
        }
        for _ in 0..HALVINGS {
            let p = rounded(along(from, to, share));
            if self.has(p) {
                return p;
            }
            share *= 0.5;
        }
        from
    }
}

impl Truncation {
    /// Moves all points towards where they want to be.
    pub(super) fn cut(&mut self) -> Cut {
        let mut cut = Cut::default();
        for k in 0..self.last.len() {
            let (from, want) = (self.last[k], self.want[k]);
            let room = Room { planes: self.planes.of(k), at: self.at[k], reach: self.reach[k] };
            if room.has(want) || !want.iter().all(|x| x.is_finite()) {
                self.last[k] = want;
                continue;
            }
            if !self.free[k] {
                cut.forced += 1;
                self.last[k] = want;
                continue;
            }
            let slop = ROUNDING * from.iter().chain(&want).fold(0.0f64, |far, x| far.max(x.abs()));
            let to = room.clip(from, room.project(want, slop), slop);
            if room.is_within_reach(want) {
                cut.held += 1;
            } else {
                // It may be held by half-spaces too, and then more reach does not help.
                let rest = sub(want, to);
                let ahead = room
                    .planes
                    .iter()
                    .any(|plane| dot(plane.normal, to) > plane.most - 4.0 * slop && dot(plane.normal, rest) > 0.0);
                if ahead { cut.held += 1 } else { cut.short += 1 }
            }
            self.last[k] = to;
        }
        cut
    }

    /// Whether a pin goes where the last search does not allow it.
    pub(super) fn pins_leave(&self) -> bool {
        (0..self.last.len()).filter(|k| !self.free[*k] && self.want[*k] != self.last[*k]).any(|k| {
            let room = Room { planes: self.planes.of(k), at: self.at[k], reach: self.reach[k] };
            !room.has(self.want[k])
        })
    }
}
