//! One half-edge collapse after the other, the cheapest first.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::base::vec3::{cross, dot, norm, scale, sub};

#[derive(Clone, Copy, Default)]
struct Quadric([f64; 10]);

impl Quadric {
    fn plane(n: [f64; 3], d: f64, w: f64) -> Self {
        let [a, b, c] = n;
        Self([a * a, a * b, a * c, a * d, b * b, b * c, b * d, c * c, c * d, d * d].map(|x| x * w))
    }

    fn add(&mut self, o: &Self) {
        self.0.iter_mut().zip(o.0).for_each(|(a, b)| *a += b);
    }

    fn at(&self, [x, y, z]: [f64; 3]) -> f64 {
        let q = &self.0;
        q[0] * x * x
            + 2.0 * (q[1] * x * y + q[2] * x * z + q[3] * x)
            + q[4] * y * y
            + 2.0 * (q[5] * y * z + q[6] * y)
            + q[7] * z * z
            + 2.0 * q[8] * z
            + q[9]
    }
}

pub(super) struct Collapser<'a> {
    positions: &'a [[f64; 3]],
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) alive: Vec<bool>,
    around: Vec<Vec<u32>>,
    boundary: Vec<bool>,
    locked: Vec<bool>,
    quadric: Vec<Quadric>,
    area: Vec<f64>,
    pub(super) into: Vec<u32>,
    centre: [f64; 3],
    /// Factor that makes costs free of units.
    unit: f64,
    /// Vertices seen in the count at work carry its number.
    seen: Vec<u32>,
    count: u32,
    /// Room for the neighbours of a vertex.
    ring: Vec<u32>,
    /// Inner vertices stay out of the boundary.
    apart: bool,
    /// Triangles may turn over: only the topology is kept.
    pub(super) bare: bool,
}

impl Collapser<'_> {
    /// The neighbours of `v`, ascending, into `out`.
    fn neighbours(&mut self, v: u32, out: &mut Vec<u32>) {
        self.count += 1;
        out.clear();
        for &t in &self.around[v as usize] {
            for w in self.triangles[t as usize] {
                if w != v && self.seen[w as usize] != self.count {
                    self.seen[w as usize] = self.count;
                    out.push(w);
                }
            }
        }
        out.sort_unstable();
    }

    fn shared(&self, u: u32, v: u32) -> usize {
        self.around[u as usize].iter().filter(|&&t| self.triangles[t as usize].contains(&v)).count()
    }

    /// The cost of collapsing `u` into `v`.
    fn cost(&self, u: u32, v: u32) -> f64 {
        let p = sub(self.positions[v as usize], self.centre);
        let l2 = {
            let d = sub(self.positions[v as usize], self.positions[u as usize]);
            dot(d, d)
        };
        let cost = self.quadric[u as usize].at(p).max(0.0) + 1e-2 * l2 * self.area[u as usize];
        // Of equal costs the first counts, not the last bits.
        f64::from((cost * self.unit) as f32)
    }

    /// The cheapest vertex to collapse `u` into, of those allowed now if `strict`; `around` is left with the neighbours of
    /// `u`.
    fn best(&mut self, u: u32, around: &mut Vec<u32>, strict: bool) -> Option<(f64, u32)> {
        if self.locked[u as usize] {
            return None;
        }
        self.neighbours(u, around);
        let mut best: Option<(f64, u32)> = None;
        for &v in &*around {
            if self.boundary[u as usize] && !(self.boundary[v as usize] && self.shared(u, v) == 1) {
                continue;
            }
            if self.apart && self.boundary[v as usize] {
                continue;
            }
            let cost = self.cost(u, v);
            if best.is_none_or(|b| cost < b.0) && (!strict || self.allowed(u, v, around)) {
                best = Some((cost, v));
            }
        }
        best
    }

    /// The link condition, and no triangle turns over. `around` are the neighbours of `u`.
    fn allowed(&mut self, u: u32, v: u32, around: &[u32]) -> bool {
        self.count += 1;
        for &t in &self.around[v as usize] {
            self.triangles[t as usize].iter().for_each(|&w| self.seen[w as usize] = self.count);
        }
        let common = around.iter().filter(|&&w| w != v && self.seen[w as usize] == self.count).count();
        let shared = self.shared(u, v);
        if common != shared || (self.boundary[u as usize] && self.boundary[v as usize] && shared != 1) {
            return false;
        }
        // Keep at least a triangle; two fans of three that share two triangles are a tetrahedron, which would be left as
        // two triangles back to back.
        let (fan_u, fan_v) = (self.around[u as usize].len(), self.around[v as usize].len());
        let closed = !self.boundary[u as usize] && !self.boundary[v as usize];
        if (fan_u <= shared && fan_v <= shared) || (closed && fan_u == 3 && fan_v == 3) {
            return false;
        }
        if self.bare {
            return true;
        }
        self.around[u as usize].iter().all(|&t| {
            let tri = self.triangles[t as usize];
            if tri.contains(&v) {
                return true;
            }
            let normal = |tri: [u32; 3]| {
                let [p, q, r] = tri.map(|x| self.positions[x as usize]);
                cross(sub(q, p), sub(r, p))
            };
            let (n, m) = (normal(tri), normal(tri.map(|x| if x == u { v } else { x })));
            dot(n, m) > 0.1 * norm(n) * norm(m)
        })
    }

    fn collapse(&mut self, u: u32, v: u32) -> usize {
        let fans = std::mem::take(&mut self.around[u as usize]);
        let mut gone = 0;
        self.into[u as usize] = v;
        for t in fans {
            let tri = self.triangles[t as usize];
            if tri.contains(&v) {
                self.alive[t as usize] = false;
                gone += 1;
                for w in tri {
                    self.around[w as usize].retain(|&x| x != t);
                }
            } else {
                self.triangles[t as usize] = tri.map(|x| if x == u { v } else { x });
                self.around[v as usize].push(t);
            }
        }
        let q = self.quadric[u as usize];
        self.quadric[v as usize].add(&q);
        self.area[v as usize] += self.area[u as usize];
        gone
    }
}

/// A mesh in which nothing is collapsed yet.
pub(super) fn prepare<'a>(
    positions: &'a [[f64; 3]],
    triangles: &[[u32; 3]],
    boundary: &[bool],
    locked: &[bool],
    apart: bool,
) -> Collapser<'a> {
    let n = positions.len();
    let mut around = vec![Vec::new(); n];
    for (t, tri) in triangles.iter().enumerate() {
        tri.iter().for_each(|&v| around[v as usize].push(t as u32));
    }
    let centre = positions.first().copied().unwrap_or_default();
    let mut c = Collapser {
        positions,
        triangles: triangles.to_vec(),
        alive: vec![true; triangles.len()],
        around,
        boundary: boundary.to_vec(),
        locked: locked.to_vec(),
        quadric: vec![Quadric::default(); n],
        area: vec![0.0; n],
        into: (0..n as u32).collect(),
        centre,
        unit: 1.0,
        seen: vec![0; n],
        count: 0,
        ring: Vec::new(),
        apart,
        bare: false,
    };
    for tri in triangles {
        let [p, q, r] = tri.map(|v| sub(positions[v as usize], centre));
        let m = cross(sub(q, p), sub(r, p));
        let area = norm(m);
        if area > 0.0 {
            let unit = scale(m, 1.0 / area);
            let quadric = Quadric::plane(unit, -dot(unit, p), area);
            for &v in tri {
                c.quadric[v as usize].add(&quadric);
                c.area[v as usize] += area;
            }
        }
    }
    let total: f64 = c.area.iter().sum();
    c.unit = 1.0 / (total * total).max(1e-300);
    c
}

/// Stands for no vertex.
const NONE: u32 = u32::MAX;

/// The next collapse of a vertex, as the queue knows it.
#[derive(Clone, Copy)]
struct Next {
    /// Bits of its cost: costs are not negative, so these have the order of the numbers.
    cost: u64,
    into: u32,
    /// The entry of the queue that counts.
    version: u32,
    /// The cheapest collapse may cost more by now: it is looked for when its turn comes.
    stale: bool,
    /// Collapses that were not allowed have been left out.
    strict: bool,
}

/// An entry of the queue: bits of the cost, the vertex, the one it goes into, the version.
type Entry = Reverse<(u64, u32, u32, u32)>;

impl Collapser<'_> {
    /// Puts the cheapest collapse of `u` into the queue.
    fn push(&mut self, queue: &mut BinaryHeap<Entry>, next: &mut [Next], u: u32, strict: bool) {
        let mut around = std::mem::take(&mut self.ring);
        let best = self.best(u, &mut around, strict);
        self.ring = around;
        let n = &mut next[u as usize];
        let version = n.version + 1;
        *n = Next { cost: u64::MAX, into: NONE, version, stale: false, strict };
        if let Some((cost, into)) = best {
            (n.cost, n.into) = (cost.to_bits(), into);
            queue.push(Reverse((n.cost, u, into, version)));
        }
    }

    /// Notes that `u` has gone into `v`, next to `w`. Other collapses of `w` cost as much as before: only `v` can be cheaper.
    fn renew(&mut self, queue: &mut BinaryHeap<Entry>, next: &mut [Next], w: u32, v: u32) {
        let Next { cost, into, strict, .. } = next[w as usize];
        if w == v || strict || into == NONE || self.boundary[w as usize] {
            return self.push(queue, next, w, false);
        }
        let into_v = match self.apart && self.boundary[v as usize] {
            true => u64::MAX,
            false => self.cost(w, v).to_bits(),
        };
        if (into_v, v) < (cost, into) {
            let n = &mut next[w as usize];
            *n = Next { cost: into_v, into: v, version: n.version + 1, stale: false, strict: false };
            queue.push(Reverse((n.cost, w, v, n.version)));
        } else if self.around[into as usize].is_empty() {
            // It was to go into the vertex that is gone.
            next[w as usize].stale = true;
        }
    }

    /// Collapses until about `target` triangles are left; `each` sees every collapse before it is made.
    pub(super) fn run(&mut self, target: usize, mut each: impl FnMut(u32, u32, &[u32])) {
        let n = self.positions.len() as u32;
        let mut queue: BinaryHeap<Entry> = BinaryHeap::with_capacity(n as usize);
        let nothing = Next { cost: u64::MAX, into: NONE, version: 0, stale: false, strict: false };
        let mut next = vec![nothing; n as usize];
        // Most collapses are allowed, so that is looked at only for those whose turn has come.
        (0..n).for_each(|u| self.push(&mut queue, &mut next, u, false));
        let mut ring = Vec::new();
        let mut left = self.alive.iter().filter(|a| **a).count();
        while left > target {
            let Some(Reverse((_, u, v, version))) = queue.pop() else { break };
            if version != next[u as usize].version || self.around[u as usize].is_empty() {
                continue;
            }
            if next[u as usize].stale {
                self.push(&mut queue, &mut next, u, false);
                continue;
            }
            if self.around[v as usize].is_empty() {
                continue;
            }
            self.neighbours(u, &mut ring);
            if !self.allowed(u, v, &ring) {
                self.push(&mut queue, &mut next, u, true);
                continue;
            }
            each(u, v, &self.around[u as usize]);
            left -= self.collapse(u, v);
            next[u as usize].version += 1;
            for &w in &ring {
                self.renew(&mut queue, &mut next, w, v);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::shapes;
    use proptest::prelude::*;

    /// The cheapest collapse of all vertices again and again, searched for each time.
    fn looked_for(c: &mut Collapser<'_>) -> Vec<[u32; 2]> {
        let (mut ring, mut out) = (Vec::new(), Vec::new());
        let mut strict = vec![false; c.positions.len()];
        loop {
            let there: Vec<u32> = (0..strict.len() as u32).filter(|&u| !c.around[u as usize].is_empty()).collect();
            let best = |u: u32| c.best(u, &mut ring, strict[u as usize]).map(|(cost, v)| (cost.to_bits(), u, v));
            let Some((_, u, v)) = there.into_iter().filter_map(best).min() else { return out };
            c.neighbours(u, &mut ring);
            if c.allowed(u, v, &ring) {
                ring.iter().for_each(|&w| strict[w as usize] = false);
                c.collapse(u, v);
                out.push([u, v]);
            } else {
                strict[u as usize] = true;
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn the_queue_finds_the_cheapest_collapse(seed in any::<u64>(), cells in 1usize..60, holes in 0usize..10, apart: bool, bare: bool) {
            let s = shapes::blob(seed, cells, holes);
            let rim = shapes::rim(&s);
            let locked = if apart { rim.clone() } else { vec![false; rim.len()] };
            let made = |c: &mut Collapser<'_>| {
                let mut out = Vec::new();
                c.bare = bare;
                c.run(0, |u, v, _| out.push([u, v]));
                out
            };
            let found = made(&mut prepare(&s.positions, &s.triangles, &rim, &locked, apart));
            let mut c = prepare(&s.positions, &s.triangles, &rim, &locked, apart);
            c.bare = bare;
            prop_assert_eq!(found, looked_for(&mut c));
        }
    }
}
