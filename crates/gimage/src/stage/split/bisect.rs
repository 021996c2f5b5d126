//! Cuts a set of triangles in two along a short path of edges: the neck.
//!
//! A sweep over a field made of graph distances from far points gives the side each triangle is on (a cheap stand-in for
//! the Fiedler vector of spectral bisection), the shortest of its balanced level sets is kept, and moves of single
//! triangles in the order of their gain straighten it (C. Fiduccia, R. Mattheyses, "A Linear-Time Heuristic for Improving
//! Network Partitions", DAC 1982; gains here are edge lengths, so a heap takes the place of their buckets).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::base::graph::{EdgeGraph, NONE, Wave};
use crate::base::halfedge::BOUNDARY;
use crate::base::surface::Surface;
use crate::base::vec3::{add, distance, scale};

/// Least share of the weight that either side of a sweep has.
const LEAST_SHARE: f64 = 0.3;
/// Least share of the weight that moves may leave a side.
const LEAST_SHARE_MOVED: f64 = 0.25;
/// Most rounds of moves.
const MAX_ROUNDS: usize = 8;
/// Fewest triangles that are cut in two.
const LEAST_TRIANGLES: usize = 8;

/// The triangles of a surface as a graph.
pub(super) struct Dual {
    /// For each triangle its up to three neighbours with the length of the edge between.
    around: Vec<[(u32, f64); 3]>,
    centre: Vec<[f64; 3]>,
    /// Weight of each triangle in the balance.
    pub weight: Vec<f64>,
}

impl Dual {
    /// The graph of an edge-manifold surface, with one weight a triangle. O(triangles).
    pub(super) fn new(surface: &Surface, graph: &EdgeGraph, weight: Vec<f64>) -> Self {
        let around = (0..surface.triangles.len() as u32)
            .map(|t| {
                [0, 1, 2].map(|k| {
                    let h = 3 * t + k;
                    let e = graph.of_half[h as usize] as usize;
                    let [a, b] = graph.halves[e];
                    let other = if b == BOUNDARY { BOUNDARY } else { (a ^ b ^ h) / 3 };
                    (other, graph.length[e])
                })
            })
            .collect();
        let third = |t: usize| {
            let [a, b, c] = surface.corners(t);
            scale(add(a, add(b, c)), 1.0 / 3.0)
        };
        Self { around, centre: (0..surface.triangles.len()).map(third).collect(), weight }
    }
}

/// Some of the triangles, numbered from 0 in their order.
struct Region<'a> {
    dual: &'a Dual,
    triangles: &'a [u32],
    around: Vec<[(u32, f64); 3]>,
    total: f64,
}

impl<'a> Region<'a> {
    fn new(dual: &'a Dual, triangles: &'a [u32]) -> Self {
        let mut local = vec![BOUNDARY; dual.weight.len()];
        triangles.iter().enumerate().for_each(|(k, &t)| local[t as usize] = k as u32);
        let inside = |t: u32| if t == BOUNDARY { BOUNDARY } else { local[t as usize] };
        let around = triangles.iter().map(|&t| dual.around[t as usize].map(|(o, l)| (inside(o), l))).collect();
        let total = triangles.iter().map(|&t| dual.weight[t as usize]).sum();
        Self { dual, triangles, around, total }
    }

    fn neighbours(&self, k: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.around[k].iter().filter(|x| x.0 != BOUNDARY).map(|&(o, l)| (o as usize, l))
    }

    fn weight(&self, k: usize) -> f64 {
        self.dual.weight[self.triangles[k] as usize]
    }

    /// Distances from a triangle along the graph, from centre to centre.
    fn distances(&self, from: usize) -> Vec<f64> {
        let centre = |k: usize| self.dual.centre[self.triangles[k] as usize];
        let around = |k: u32| {
            let k = k as usize;
            self.neighbours(k).map(move |(o, _)| (o as u32, NONE, distance(centre(k), centre(o))))
        };
        let mut wave = Wave::new(self.triangles.len());
        wave.source(from as u32);
        wave.next(around, |_| false);
        wave.distance
    }

    /// Which side each triangle is on in the best level set of a field, and the length of the path over the share of the
    /// smaller side.
    fn sweep(&self, field: &[f64]) -> Option<(f64, Vec<bool>)> {
        let n = self.triangles.len();
        let mut order: Vec<u32> = (0..n as u32).collect();
        order.sort_unstable_by(|&a, &b| field[a as usize].total_cmp(&field[b as usize]).then(a.cmp(&b)));
        let mut side = vec![false; n];
        let (mut weight, mut cut) = (0.0, 0.0);
        let mut best: Option<(f64, usize)> = None;
        for (many, &k) in order.iter().enumerate() {
            side[k as usize] = true;
            weight += self.weight(k as usize) / self.total;
            for (o, l) in self.neighbours(k as usize) {
                cut += if side[o] { -l } else { l };
            }
            let least = weight.min(1.0 - weight);
            if least >= LEAST_SHARE && best.is_none_or(|b| cut / least < b.0) {
                best = Some((cut / least, many + 1));
            }
        }
        let (score, many) = best?;
        side.fill(false);
        order[..many].iter().for_each(|&k| side[k as usize] = true);
        Some((score, side))
    }

    /// How much shorter the path gets if triangle `k` changes sides.
    fn gain(&self, side: &[bool], k: usize) -> f64 {
        self.neighbours(k).map(|(o, l)| if side[o] == side[k] { -l } else { l }).sum()
    }

    /// Moves single triangles over, the best first, and keeps what was best.
    fn straighten(&self, side: &mut [bool]) {
        let mut weight: f64 = (0..side.len()).filter(|&k| side[k]).map(|k| self.weight(k) / self.total).sum();
        for _ in 0..MAX_ROUNDS {
            // Gains are ordered by their bits: non-negative once raised by the largest.
            let raise = self.around.iter().flatten().map(|x| x.1).fold(0.0, f64::max) * 3.0;
            let mut heap: BinaryHeap<(u64, Reverse<u32>)> = BinaryHeap::new();
            let push = |heap: &mut BinaryHeap<_>, side: &[bool], k: usize| {
                let gain = self.gain(side, k);
                heap.push(((gain + raise).max(0.0).to_bits(), Reverse(k as u32)));
            };
            let frontier: Vec<usize> =
                (0..side.len()).filter(|&k| self.neighbours(k).any(|(o, _)| side[o] != side[k])).collect();
            frontier.iter().for_each(|&k| push(&mut heap, side, k));
            let patience = 2 * frontier.len() + 16;
            let mut moved = vec![false; side.len()];
            let (mut done, mut sum, mut best) = (Vec::new(), 0.0, (0.0, 0usize));
            let start = weight;
            let mut weights = Vec::new();
            while let Some((bits, Reverse(k))) = heap.pop() {
                let k = k as usize;
                let gain = self.gain(side, k);
                if moved[k] || (gain + raise).max(0.0).to_bits() != bits {
                    continue;
                }
                let change = if side[k] { -self.weight(k) } else { self.weight(k) } / self.total;
                let after = weight + change;
                if after.min(1.0 - after) < LEAST_SHARE_MOVED {
                    continue;
                }
                (side[k], moved[k], weight) = (!side[k], true, after);
                sum += gain;
                done.push(k);
                weights.push(weight);
                // A difference within rounding does not count as a gain.
                if sum > best.0 + 1e-9 * raise {
                    best = (sum, done.len());
                } else if done.len() > best.1 + patience {
                    break;
                }
                let near: Vec<usize> = self.neighbours(k).map(|x| x.0).filter(|&o| !moved[o]).collect();
                near.into_iter().for_each(|o| push(&mut heap, side, o));
            }
            done[best.1..].iter().for_each(|&k| side[k] = !side[k]);
            weight = if best.1 == 0 { start } else { weights[best.1 - 1] };
            if best.1 == 0 {
                return;
            }
        }
    }

    /// Leaves the heaviest connected part of either side and gives the rest to the other.
    fn connect(&self, side: &mut [bool]) {
        for which in [true, false] {
            let mut seen = vec![false; side.len()];
            let mut parts: Vec<(f64, Vec<usize>)> = Vec::new();
            for start in 0..side.len() {
                if seen[start] || side[start] != which {
                    continue;
                }
                let (mut stack, mut part, mut weight) = (vec![start], Vec::new(), 0.0);
                seen[start] = true;
                while let Some(k) = stack.pop() {
                    part.push(k);
                    weight += self.weight(k);
                    for (o, _) in self.neighbours(k).filter(|x| side[x.0] == which) {
                        if !std::mem::replace(&mut seen[o], true) {
                            stack.push(o);
                        }
                    }
                }
                parts.push((weight, part));
            }
            let heaviest = (0..parts.len()).max_by(|&a, &b| parts[a].0.total_cmp(&parts[b].0).then(b.cmp(&a)));
            for (k, (_, part)) in parts.iter().enumerate().filter(|(k, _)| Some(*k) != heaviest) {
                debug_assert!(Some(k) != heaviest);
                part.iter().for_each(|&t| side[t] = !which);
            }
        }
    }
}

/// Cuts connected `triangles` (ascending) into two connected sets, each with a quarter of the weight or so. `None` if there
/// are too few of them. The answer depends on the surface alone. O(n log n).
pub(super) fn bisect(dual: &Dual, triangles: &[u32]) -> Option<[Vec<u32>; 2]> {
    if triangles.len() < LEAST_TRIANGLES {
        return None;
    }
    let region = Region::new(dual, triangles);
    let far = |d: &[f64]| {
        (0..d.len()).filter(|&k| d[k].is_finite()).max_by(|&a, &b| d[a].total_cmp(&d[b]).then(b.cmp(&a))).unwrap_or(0)
    };
    let from_first = region.distances(0);
    let one = region.distances(far(&from_first));
    let two = region.distances(far(&one));
    let both: Vec<f64> = one.iter().zip(&two).map(|(a, b)| a.min(*b)).collect();
    let three = region.distances(far(&both));
    let four = region.distances(far(&three));
    let minus = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
    let (f, g) = (minus(&one, &two), minus(&three, &four));
    let sum: Vec<f64> = f.iter().zip(&g).map(|(a, b)| a + b).collect();
    let difference = minus(&f, &g);
    let best = [f, g, sum, difference]
        .iter()
        .filter_map(|field| region.sweep(field))
        .map(|(_, mut side)| {
            region.straighten(&mut side);
            region.connect(&mut side);
            let share = (0..side.len()).filter(|&k| side[k]).map(|k| region.weight(k)).sum::<f64>() / region.total;
            let twice: f64 = (0..side.len())
                .flat_map(|k| region.neighbours(k).filter(|x| side[x.0] != side[k]).map(|x| x.1).collect::<Vec<_>>())
                .sum();
            (0.5 * twice / share.min(1.0 - share).max(1e-9), side)
        })
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let (_, side) = best?;
    let of = |which: bool| (0..side.len()).filter(|&k| side[k] == which).map(|k| triangles[k]).collect::<Vec<u32>>();
    let out = [of(true), of(false)];
    out.iter().all(|s| !s.is_empty()).then_some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::shapes;

    fn parts(s: &Surface) -> ([Vec<u32>; 2], f64) {
        let graph = EdgeGraph::new(&s.positions, &s.triangles);
        let dual = Dual::new(s, &graph, (0..s.triangles.len()).map(|t| s.triangle_area(t)).collect());
        let all: Vec<u32> = (0..s.triangles.len() as u32).collect();
        let out = bisect(&dual, &all).expect("two sides");
        let side: std::collections::BTreeSet<u32> = out[0].iter().copied().collect();
        let cut = (0..graph.ends.len())
            .filter(|&e| {
                let [a, b] = graph.halves[e];
                b != BOUNDARY && side.contains(&(a / 3)) != side.contains(&(b / 3))
            })
            .map(|e| graph.length[e])
            .sum();
        (out, cut)
    }

    #[test]
    fn a_dumbbell_is_cut_at_its_neck() {
        let s = shapes::sheet(24, 48, shapes::Join::Same, shapes::Join::Open, |u, v| {
            let (a, y) = (std::f64::consts::TAU * u, 2.0 * v - 1.0);
            let r = 0.1 + 0.9 * y * y;
            [r * a.cos(), 2.0 * y, -r * a.sin()]
        });
        let (_, cut) = parts(&s);
        assert!(cut < 1.1 * std::f64::consts::TAU * 0.1, "{cut}");
    }

    #[test]
    fn a_rectangle_is_cut_straight_across() {
        let (out, cut) = parts(&shapes::rectangle(30, 12, 3.0, 1.0));
        assert!(cut < 1.01, "{cut}");
        assert!(out.iter().all(|s| s.len() > 180));
    }

    #[test]
    fn every_shape_has_two_connected_sides() {
        for (name, s) in shapes::all().into_iter().filter(|x| x.1.triangles.len() >= LEAST_TRIANGLES) {
            let (out, _) = parts(&s);
            assert_eq!(out[0].len() + out[1].len(), s.triangles.len(), "{name}");
            for side in &out {
                let t: Vec<[u32; 3]> = side.iter().map(|&t| s.triangles[t as usize]).collect();
                assert_eq!(crate::base::topology::Topology::of(&t).components, 1, "{name}");
                assert!(side.is_sorted());
            }
        }
    }
}
