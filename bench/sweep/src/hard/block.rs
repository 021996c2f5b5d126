//! Surfaces of blocks: handles, sponges, blobs, and trees of tubes.

use std::collections::{BTreeMap, BTreeSet};

use super::count;
use crate::random::Random;
use crate::shape::Shape;

/// A cell of a lattice.
type Cell = [i32; 3];

/// The surface of a set of cubes: a quad wherever a cube has no neighbour.
fn surface(cells: &BTreeSet<Cell>) -> Shape {
    let mut s = Shape::default();
    let mut number: BTreeMap<Cell, u32> = BTreeMap::new();
    for &cell in cells {
        for axis in 0..3 {
            for side in [0, 1] {
                let mut beside = cell;
                beside[axis] += 2 * side - 1;
                if cells.contains(&beside) {
                    continue;
                }
                let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
                let corner = |db: i32, dc: i32| {
                    let mut p = cell;
                    p[axis] += side;
                    p[b] += db;
                    p[c] += dc;
                    p
                };
                let mut quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                if side == 0 {
                    quad.reverse();
                }
                let quad = quad.map(|p| {
                    *number.entry(p).or_insert_with(|| {
                        s.positions.push(p.map(f64::from));
                        s.positions.len() as u32 - 1
                    })
                });
                s.quad(quad);
            }
        }
    }
    s
}

/// A slab with 1 to 20 tunnels: genus 1 to 20, closed or with a hole.
pub fn handles(r: &mut Random, t: f64) -> Shape {
    let n = count(t, 1.0, 20.0) as i32;
    let (columns, gap) = (1 + r.below(5) as i32, 1 + r.below(2) as i32);
    let (cell, rows) = (1 + gap, (n + columns - 1) / columns);
    let mut cells = BTreeSet::new();
    for x in 0..columns * cell + gap {
        for y in 0..rows * cell + gap {
            let tunnel = x % cell == gap && y % cell == gap && (y / cell) * columns + x / cell < n;
            if !tunnel {
                cells.insert([x, y, 0]);
            }
        }
    }
    let mut s = surface(&cells);
    if r.chance(0.5) {
        s.triangles.truncate(s.triangles.len() - 2);
    }
    let bulge = r.within(0.0, 0.3);
    s.compacted().moved(|[x, y, z]| [x, y, z + bulge * (x + 0.7 * y).sin()])
}

/// Menger's sponge of 1 to 3 levels, or a part of the third.
pub fn menger(r: &mut Random, t: f64) -> Shape {
    let (levels, side) = if t < 0.34 {
        (1, 3)
    } else if t < 0.67 {
        (2, 9)
    } else {
        (3, 12 + r.below(6) as i32)
    };
    let solid = |cell: Cell| {
        let mut c = cell;
        (0..levels).all(|_| {
            let middle = c.iter().filter(|&&x| x % 3 == 1).count();
            c = c.map(|x| x / 3);
            middle < 2
        })
    };
    let all = (0..side * side * side).map(|k| [k % side, k / side % side, k / side / side]);
    let flat = all.filter(|&c| solid(c) && (levels < 3 || c[2] < 9)).collect();
    surface(&flat)
}

/// Random cubes that touch along edges and at corners.
pub fn cubes(r: &mut Random, t: f64) -> Shape {
    let (side, p) = (3 + (t * 7.0) as i32, r.within(0.2, 0.8));
    let all = (0..side * side * side).map(|k| [k % side, k / side % side, k / side / side]);
    let mut kept: BTreeSet<Cell> = all.filter(|_| r.chance(p)).collect();
    kept.insert([0; 3]);
    surface(&kept)
}

/// A random walk of cubes: a blob of long arms and handles.
pub fn walk(r: &mut Random, t: f64) -> Shape {
    let mut cells = BTreeSet::from([[0; 3]]);
    let mut at: Cell = [0; 3];
    let most = count(t, 10.0, 800.0);
    for _ in 0..20 * most {
        if cells.len() >= most {
            break;
        }
        at[r.below(3)] += if r.chance(0.5) { 1 } else { -1 };
        cells.insert(at);
    }
    surface(&cells)
}

/// A tree of tubes of 3 to 200 limbs, their ends closed or open. Two steps of midpoint division make it finer.
pub fn tree(r: &mut Random, t: f64) -> Shape {
    let (limbs, open) = (count(t, 3.0, 200.0), r.chance(0.5));
    let mut points: Vec<[f64; 3]> = Vec::new();
    let mut quads: Vec<[usize; 4]> = Vec::new();
    for k in 0..8 {
        points.push([k & 1, k >> 1 & 1, k >> 2 & 1].map(|b| b as f64));
    }
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    quads.extend(sides);
    let mut tips: Vec<usize> = (0..6).collect();
    for _ in 0..limbs {
        if tips.is_empty() {
            break;
        }
        let tip = tips.swap_remove(r.below(tips.len()));
        let (steps, shrink) = (1 + r.below(5), r.within(0.75, 1.0));
        for step in 0..steps {
            let grown = extrude(&mut points, &mut quads, tip, r.log(0.5, 3.0), shrink, r);
            if step + 1 == steps {
                tips.extend([tip, grown + r.below(2), grown + 2 + r.below(2)]);
            }
        }
    }
    if open {
        let mut ends = tips;
        ends.sort_unstable();
        ends.dedup();
        ends.truncate(ends.len().min(quads.len() - 1));
        for &k in ends.iter().rev().step_by(2) {
            quads.remove(k);
        }
    }
    let mut s = Shape { positions: points, triangles: Vec::new() };
    for q in quads {
        s.quad(q.map(|v| v as u32));
    }
    finer(&s.compacted())
}

/// Pulls quad `k` out by `length` sides; it becomes the new end. Returns the first of the four quads around it.
fn extrude(
    points: &mut Vec<[f64; 3]>,
    quads: &mut Vec<[usize; 4]>,
    k: usize,
    length: f64,
    shrink: f64,
    r: &mut Random,
) -> usize {
    let old = quads[k];
    let p = old.map(|v| points[v]);
    let sub = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|c| a[c] - b[c]);
    let (a, b) = (sub(p[2], p[0]), sub(p[3], p[1]));
    let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    // The normal has twice the area for its length; its root is a side.
    let size = n.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-12);
    let side = (0.5 * size).sqrt();
    let sway = r.direction();
    let way = [0, 1, 2].map(|c| length * side * (n[c] / size + 0.3 * sway[c]));
    let centre = [0, 1, 2].map(|c| 0.25 * (p[0][c] + p[1][c] + p[2][c] + p[3][c]));
    let first = points.len();
    points.extend(p.map(|q| [0, 1, 2].map(|c| centre[c] + shrink * (q[c] - centre[c]) + way[c])));
    let around = quads.len();
    for c in 0..4 {
        let d = (c + 1) % 4;
        quads.push([old[c], old[d], first + d, first + c]);
    }
    quads[k] = [first, first + 1, first + 2, first + 3];
    around
}

/// Every triangle in four.
fn finer(s: &Shape) -> Shape {
    let mut out = Shape { positions: s.positions.clone(), triangles: Vec::new() };
    let mut middle: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for &t in &s.triangles {
        let m = [0, 1, 2].map(|c| {
            let (a, b) = (t[c], t[(c + 1) % 3]);
            *middle.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                let (p, q) = (s.positions[a as usize], s.positions[b as usize]);
                out.positions.push([0, 1, 2].map(|c| 0.5 * (p[c] + q[c])));
                out.positions.len() as u32 - 1
            })
        });
        out.triangles.extend([[t[0], m[0], m[2]], [m[0], t[1], m[1]], [m[2], m[1], t[2]], m]);
    }
    out
}
