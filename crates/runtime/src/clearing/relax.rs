//! Moves the points of a garment out of what they are in, and the points around them along the links.

use super::net::{Link, Net};
use super::obstacles::{Obstacles, Over, Plane};
use crate::cloth::surface::{BodySurface, Posed};
use crate::number::real::{V3, add, dot, scale, sub};

/// Rounds after which planes are found again, at most, and sweeps over links and planes in each.
const ROUNDS: usize = 60;
const SWEEPS: usize = 10;
/// Points that are nearer than this \[m\] to where they must be are there.
pub const CLOSE_M: f64 = 5e-5;
/// Share by which a link that is longer at the end tears the cloth, and attempts without the points at such links.
const TORN: f64 = 0.25;
const ATTEMPTS: usize = 4;
/// Share by which links may be longer than they ought to be, so that cloth far away does not move; twice that at the end.
const LONGER: f64 = 0.002;

/// From this round on links reach their ranges by a share only, at least the second number: where there is no room for all of them, the last ones
/// of a sweep would be longer than the others.
const EASED_FROM: f64 = 20.0;
const LEAST_SHARE: f64 = 0.1;

/// A garment of a net.
pub struct Part<'a> {
    pub points: &'a [u32],
    pub links: &'a [Link],
    /// Its surface, if layers count for it.
    pub surface: Option<&'a BodySurface>,
}

/// The planes of the points, in lists one after the other.
#[derive(Default)]
struct Planes {
    /// The point of each list, and the end of its planes.
    ends: Vec<(u32, u32)>,
    list: Vec<Plane>,
    over: Vec<Over>,
}

/// Clears a garment. Whether anything was moved. Points that only links stretched by more than [`TORN`] would take out stay where they are.
pub fn clear(net: &mut Net, part: &Part, obstacles: &Obstacles) -> bool {
    let mut stays = vec![false; net.at.len()];
    for _ in 0..ATTEMPTS {
        if !attempt(net, part, obstacles, &stays) {
            return false;
        }
        let torn: Vec<u32> =
            part.links.iter().filter(|link| longer(net, link) > TORN).flat_map(|link| link.ends).collect();
        if torn.is_empty() {
            return true;
        }
        torn.iter().for_each(|point| stays[*point as usize] = true);
        part.points.iter().for_each(|point| net.at[*point as usize] = net.start[*point as usize]);
    }
    false
}

/// Moves the points out of what they are in, but for those that stay. Whether anything was moved.
fn attempt(net: &mut Net, part: &Part, obstacles: &Obstacles, stays: &[bool]) -> bool {
    // How far each point may move before its planes are found again.
    let mut safe = vec![(0.0, [f64::NAN; 3]); net.at.len()];
    let mut moved = false;
    for round in 0..ROUNDS {
        let planes = find(net, part, obstacles, (stays, &mut safe));
        let short = planes.short(net);
        if short <= CLOSE_M && (!moved || longest(net, part) <= 2.0 * LONGER) {
            break;
        }
        moved = true;
        let share = (EASED_FROM / (round + 1) as f64).clamp(LEAST_SHARE, 1.0);
        for sweep in 0..SWEEPS {
            pull(net, part, share, sweep % 2 == 1);
            planes.apply(net);
        }
    }
    moved
}

fn find(net: &Net, part: &Part, obstacles: &Obstacles, (stays, safe): (&[bool], &mut [(f64, V3<f64>)])) -> Planes {
    let mut planes = Planes::default();
    for point in part.points.iter().map(|k| *k as usize).filter(|k| net.free[*k] && !stays[*k]) {
        let p = net.at[point];
        let (room, from) = safe[point];
        let d = sub(p, from);
        if room > 0.0 && dot(d, d) < room * room {
            continue;
        }
        let before = planes.list.len();
        safe[point] = (obstacles.planes(point, p, &mut planes.list), p);
        if planes.list.len() > before {
            safe[point].0 = 0.0;
            planes.ends.push((point as u32, planes.list.len() as u32));
        }
    }
    if let Some(surface) = part.surface.filter(|_| !obstacles.below.is_empty()) {
        let posed = Posed::put(surface, net.at.clone());
        obstacles.below.iter().for_each(|below| below.over(&posed, surface.triangles(), &mut planes.over));
    }
    planes
}

impl Planes {
    /// How far \[m\] the point is from where it must be that is farthest.
    fn short(&self, net: &Net) -> f64 {
        let mut short = 0.0f64;
        let mut first = 0;
        for (point, end) in &self.ends {
            let p = net.at[*point as usize];
            let own = &self.list[first..*end as usize];
            short = own.iter().map(|plane| plane.offset - dot(plane.normal, p)).fold(short, f64::max);
            first = *end as usize;
        }
        self.over.iter().map(|over| over.short(&net.at)).fold(short, f64::max)
    }

    fn apply(&self, net: &mut Net) {
        self.over.iter().for_each(|over| over.apply(&mut net.at, &net.free));
        let mut first = 0;
        for (point, end) in &self.ends {
            let point = *point as usize;
            net.at[point] = within(net.start[point], net.at[point], net.reach[point]);
            let p = &mut net.at[point];
            for plane in &self.list[first..*end as usize] {
                let short = plane.offset - dot(plane.normal, *p);
                if short > 0.0 {
                    *p = add(*p, scale(plane.normal, short));
                }
            }
            first = *end as usize;
        }
    }
}

/// A point no farther \[m\] from another one than `reach`.
fn within(from: V3<f64>, p: V3<f64>, reach: f64) -> V3<f64> {
    let d = sub(p, from);
    let far = dot(d, d).sqrt();
    if far > reach { add(from, scale(d, reach / far)) } else { p }
}

/// Brings the links nearer to their ranges by a share, one after the other.
fn pull(net: &mut Net, part: &Part, share: f64, backwards: bool) {
    let count = part.links.len();
    for n in 0..count {
        let Link { ends, range, .. } = part.links[if backwards { count - 1 - n } else { n }];
        let [a, b] = ends.map(|k| k as usize);
        let shares = [a, b].map(|k| f64::from(u8::from(net.free[k])));
        let d = sub(net.at[b], net.at[a]);
        let long = dot(d, d).sqrt();
        let to = long.clamp(range[0], range[1] * (1.0 + LONGER));
        if to == long || shares == [0.0; 2] || long <= 0.0 {
            continue;
        }
        let by = scale(d, share * (long - to) / long / (shares[0] + shares[1]));
        net.at[a] = add(net.at[a], scale(by, shares[0]));
        net.at[b] = sub(net.at[b], scale(by, shares[1]));
    }
}

/// The share by which a link is longer than it ought to be; 0 between two pins.
fn longer(net: &Net, link: &Link) -> f64 {
    let [a, b] = link.ends.map(|k| k as usize);
    let d = sub(net.at[b], net.at[a]);
    if net.free[a] || net.free[b] { dot(d, d).sqrt() / link.range[1] - 1.0 } else { 0.0 }
}

/// The largest share by which a link is longer than it ought to be.
fn longest(net: &Net, part: &Part) -> f64 {
    part.links.iter().map(|link| longer(net, link)).fold(0.0, f64::max)
}
