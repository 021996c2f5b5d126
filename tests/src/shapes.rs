//! Meshes made by rule.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

/// Positions \[m\] and counter-clockwise triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Positions \[m\].
    pub positions: Vec<[f64; 3]>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
}

/// A small generator of numbers that are the same everywhere (SplitMix64).
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// 0 up to, but not, 1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// -1 to 1.
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// 0 to `n` - 1.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
}

impl Shape {
    /// As the text of an OBJ file. Numbers are the shortest that read back as the same f64.
    pub fn obj(&self) -> String {
        let mut out = String::new();
        for p in &self.positions {
            let _ = writeln!(out, "v {} {} {}", p[0], p[1], p[2]);
        }
        for t in &self.triangles {
            let _ = writeln!(out, "f {} {} {}", t[0] + 1, t[1] + 1, t[2] + 1);
        }
        out
    }

    /// With every position mapped.
    pub fn moved(mut self, f: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        self.positions.iter_mut().for_each(|p| *p = f(*p));
        self
    }

    /// With every position moved by up to `amount` along each axis.
    pub fn jittered(mut self, amount: f64, random: &mut Random) -> Self {
        self.positions.iter_mut().flatten().for_each(|x| *x += amount * random.signed());
        self
    }

    /// Without a share of its triangles, chosen at random; vertices stay.
    pub fn holed(mut self, share: f64, random: &mut Random) -> Self {
        self.triangles.retain(|_| random.unit() >= share);
        self
    }

    /// The same surface with vertices and triangles in another order.
    pub fn shuffled(&self, random: &mut Random) -> Self {
        let n = self.positions.len();
        let mut to: Vec<u32> = (0..n as u32).collect();
        for k in (1..n).rev() {
            to.swap(k, random.below(k + 1));
        }
        let mut out = Shape { positions: vec![[0.0; 3]; n], triangles: Vec::new() };
        for (old, &new) in to.iter().enumerate() {
            out.positions[new as usize] = self.positions[old];
        }
        for t in &self.triangles {
            let mut t = t.map(|v| to[v as usize]);
            t.rotate_left(random.below(3));
            out.triangles.push(t);
        }
        for k in (1..out.triangles.len()).rev() {
            out.triangles.swap(k, random.below(k + 1));
        }
        out
    }
}

/// A sheet of `nx` x `ny` cells; `f` gives the point at u, v in 0..=1. Diagonals go either way by chance.
pub fn sheet(nx: usize, ny: usize, random: &mut Random, f: impl Fn(f64, f64) -> [f64; 3]) -> Shape {
    let mut out = Shape::default();
    let index = |i: usize, j: usize| (j * (nx + 1) + i) as u32;
    for j in 0..=ny {
        for i in 0..=nx {
            out.positions.push(f(i as f64 / nx as f64, j as f64 / ny as f64));
        }
    }
    for j in 0..ny {
        for i in 0..nx {
            let q = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            out.triangles.extend(halves(q, random.bits() & 1 == 0));
        }
    }
    out
}

/// A strip of `n` x `m` cells joined to itself with a number of half twists: 0 a tube's ring, 1 a Moebius strip.
pub fn twisted(n: usize, m: usize, half_twists: usize, width: f64, random: &mut Random) -> Shape {
    let mut out = Shape::default();
    for i in 0..n {
        let a = TAU * i as f64 / n as f64;
        for j in 0..=m {
            let s = width * (j as f64 / m as f64 - 0.5);
            let turn = PI * half_twists as f64 * i as f64 / n as f64;
            let r = 1.0 + s * turn.cos();
            out.positions.push([r * a.cos(), s * turn.sin(), r * a.sin()]);
        }
    }
    for i in 0..n {
        for j in 0..m {
            let index = |i: usize, j: usize| {
                let over = i == n && half_twists % 2 == 1;
                ((i % n) * (m + 1) + if over { m - j } else { j }) as u32
            };
            let q = [index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j)];
            out.triangles.extend(halves(q, random.bits() & 1 == 0));
        }
    }
    out
}

/// A quad as two triangles along either diagonal.
fn halves([a, b, c, d]: [u32; 4], first: bool) -> [[u32; 3]; 2] {
    if first { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
}

/// A set of `cells` voxels grown at random, face by face, inside a cube of `side` voxels.
pub fn growth(side: i32, cells: usize, random: &mut Random) -> BTreeSet<[i32; 3]> {
    let mut set = BTreeSet::from([[side / 2; 3]]);
    let mut tries = 100 * cells;
    while set.len() < cells.min((side * side * side) as usize) && tries > 0 {
        tries -= 1;
        let mut at = *set.iter().nth(random.below(set.len())).unwrap_or(&[0; 3]);
        at[random.below(3)] += if random.bits() & 1 == 0 { 1 } else { -1 };
        if at.iter().all(|&x| (0..side).contains(&x)) {
            set.insert(at);
        }
    }
    set
}

/// The surface between a set of voxels and the rest, wound outwards: closed, of any genus, and with edges of four
/// triangles where two voxels touch along an edge only.
pub fn voxels(set: &BTreeSet<[i32; 3]>, random: &mut Random) -> Shape {
    let mut out = Shape::default();
    let mut index: BTreeMap<[i32; 3], u32> = BTreeMap::new();
    for &cell in set {
        for axis in 0..3 {
            for side in [0, 1] {
                let mut beyond = cell;
                beyond[axis] += 2 * side - 1;
                if set.contains(&beyond) {
                    continue;
                }
                let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut quad = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[x, y]| {
                    let mut p = cell;
                    p[axis] += side;
                    p[b] += x;
                    p[c] += y;
                    *index.entry(p).or_insert_with(|| {
                        out.positions.push(p.map(f64::from));
                        out.positions.len() as u32 - 1
                    })
                });
                if side == 0 {
                    quad.reverse();
                }
                out.triangles.extend(halves(quad, random.bits() & 1 == 0));
            }
        }
    }
    out
}
