//! Meshes that are not clean surfaces: soups, copies, wrong windings, parts that touch.

use std::f64::consts::TAU;

use super::{between, count};
use crate::random::Random;
use crate::shape::Shape;

fn add(p: [f64; 3], q: [f64; 3], k: f64) -> [f64; 3] {
    [0, 1, 2].map(|c| p[c] + k * q[c])
}

/// Loose triangles, 2 to 3,000, of any size and place.
pub fn soup(r: &mut Random, t: f64) -> Shape {
    let (n, size) = (count(t, 2.0, 3000.0), r.log(0.02, 2.0));
    let mut s = Shape::default();
    for _ in 0..n {
        let p = r.point();
        s.loose([p, add(p, r.point(), size), add(p, r.point(), size)]);
    }
    s
}

/// Random triangles between few vertices: edges of many triangles.
pub fn knot(r: &mut Random, t: f64) -> Shape {
    let n = count(t, 5.0, 60.0);
    let mut s = Shape { positions: (0..n).map(|_| r.point()).collect(), triangles: Vec::new() };
    for _ in 0..(r.within(1.0, 20.0) * n as f64) as usize {
        let t = [0; 3].map(|_| r.below(n) as u32);
        if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
            s.triangles.push(t);
        }
    }
    s.triangles.push([0, 1, 2]);
    s.compacted()
}

/// 2 to 12 sheets in one place, or 1e-12 to 1e-2 apart, of either winding.
pub fn coincident(r: &mut Random, t: f64) -> Shape {
    let (sheets, n) = (2 + (t * 10.0) as usize, 6 + r.below(20));
    let gap = if r.chance(0.5) { 0.0 } else { r.log(1e-12, 1e-2) };
    let mut s = Shape::default();
    for k in 0..sheets {
        let mut sheet = Shape::sheet(n, n, |u, v| [u, v, 0.1 * (4.0 * u).sin() + gap * k as f64]);
        if r.chance(0.5) {
            sheet.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        }
        s.join(&sheet);
    }
    s
}

/// A book: 3 to 40 pages on one spine.
pub fn book(r: &mut Random, t: f64) -> Shape {
    let (pages, n) = (3 + (t * 37.0) as usize, 4 + r.below(10));
    let mut s = Shape::default();
    for k in 0..pages {
        let a = TAU * k as f64 / pages as f64;
        s.join(&Shape::sheet(n, n, |u, v| [u * a.cos(), v, u * a.sin()]));
    }
    s
}

/// 2 to 300 patches in a row that touch at corners.
pub fn bowties(r: &mut Random, t: f64) -> Shape {
    let (patches, n) = (count(t, 2.0, 300.0), 1 + r.below(4));
    let mut s = Shape::default();
    for k in 0..patches {
        let (x, y) = (k as f64, if r.chance(0.5) { k as f64 } else { k as f64 * 0.999_999 });
        s.join(&Shape::sheet(n, n, |u, v| [x + u, y + v, 0.1 * u * v]));
    }
    s
}

/// A sheet whose triangles wind at random.
pub fn windings(r: &mut Random, t: f64) -> Shape {
    let n = 6 + r.below(30);
    let mut s = Shape::sheet(n, n, |u, v| [u, v, 0.2 * (5.0 * u * v).sin()]);
    s.triangles.iter_mut().filter(|_| r.chance(0.5 * t + 0.01)).for_each(|t| t.swap(0, 1));
    s
}

/// Rows of quads, each of them divided otherwise: T-junctions all along.
pub fn junctions(r: &mut Random, t: f64) -> Shape {
    let rows = 2 + (t * 30.0) as usize;
    let mut s = Shape::default();
    for k in 0..rows {
        let n = 2 + r.below(30);
        s.join(&Shape::sheet(n, 1, |u, v| [2.0 * u, (k as f64 + v) / rows as f64, 0.0]));
    }
    s
}

/// A sheet with triangles twice, thrice, and in the other winding.
pub fn copies(r: &mut Random, t: f64) -> Shape {
    let n = 6 + r.below(30);
    let mut s = Shape::sheet(n, n, |u, v| [u, v, 0.2 * (5.0 * u * v).sin()]);
    for k in 0..s.triangles.len() {
        for _ in 0..2 {
            if r.chance(t) {
                let [a, b, c] = s.triangles[k];
                s.triangles.push(if r.chance(0.5) { [b, c, a] } else { [b, a, c] });
            }
        }
    }
    s
}

/// A sheet in which vertices lie on the edges across from them: triangles of no, or hardly any, area.
pub fn caps(r: &mut Random, t: f64) -> Shape {
    let n = 10 + r.below(30);
    let thin = if r.chance(0.3) { 0.0 } else { between(t, 1e-4, 1e-16) };
    let s = Shape::sheet(n, n, |u, v| [u, v, 0.0]);
    let mut k = 0;
    let moves: Vec<bool> = (0..s.positions.len()).map(|_| r.chance(0.1)).collect();
    s.moved(|p| {
        k += 1;
        let inner = p[..2].iter().all(|x| (0.5 / n as f64..1.0 - 0.5 / n as f64).contains(x));
        // Half a step to the right and down lies on the diagonal of the quad.
        if inner && moves[k - 1] { [p[0] + (0.5 - thin) / n as f64, p[1] - (0.5 - thin) / n as f64, 0.0] } else { p }
    })
}

/// 2 to 1,000 loose tiles of one garment.
pub fn tiles(r: &mut Random, t: f64) -> Shape {
    let n = count(t, 2.0, 1000.0);
    let side = (n as f64).sqrt().ceil() as usize;
    let quads = 1 + r.below(4);
    let mut s = Shape::default();
    for k in 0..n {
        let (x, y) = ((k % side) as f64, (k / side) as f64);
        let size = r.within(0.3, 0.95);
        s.join(&Shape::sheet(quads, quads, |u, v| [x + size * u, y + size * v, 0.3 * (x + u).sin()]));
    }
    s
}

/// Hair: 3 to 150 strips that share their roots and touch one another.
pub fn hair(r: &mut Random, t: f64) -> Shape {
    let n = count(t, 3.0, 150.0);
    let mut s = Shape::default();
    let steps = 8 + r.below(12);
    for k in 0..n {
        let a = 2.0 * k as f64 / n as f64;
        let (curl, length) = (r.within(0.0, 0.4), r.within(1.0, 4.0));
        // The strip's left side begins where the right side of the last one ended.
        let next = a + 2.0 / n as f64;
        s.join(&Shape::sheet(1, steps, |u, v| {
            let root = a + (next - a) * u;
            let narrow = a + (next - a) * (u * (1.0 - 0.9 * v));
            let x = if v == 0.0 { root } else { narrow };
            [x.cos() + curl * v * (6.0 * v).sin(), -length * v, x.sin() + curl * v * (6.0 * v).cos()]
        }));
    }
    s
}

/// A zigzag of 1 to 500 triangles, flat or as a bent strip; the least meshes there are.
pub fn strip(r: &mut Random, t: f64) -> Shape {
    let n = count(t, 1.0, 500.0);
    let bend = r.within(0.0, 0.5);
    let mut s = Shape::default();
    for k in 0..n + 2 {
        let x = k as f64 * 0.5;
        s.positions.push([x, (k % 2) as f64, bend * (x * 0.7).sin()]);
    }
    for k in 0..n as u32 {
        s.triangles.push(if k % 2 == 0 { [k, k + 2, k + 1] } else { [k, k + 1, k + 2] });
    }
    s
}

/// Two tubes through one another that share the vertices where they cross.
pub fn crossing(r: &mut Random, t: f64) -> Shape {
    let n = 8 + 4 * (t * 8.0) as usize;
    let mut s = Shape::tube(n, n, |a, v| [0.3 * a.cos(), 2.0 * v - 1.0, 0.3 * a.sin()]);
    s.join(&Shape::tube(n, n, |a, v| [2.0 * v - 1.0, 0.3 * a.cos(), 0.3 * a.sin()]));
    let snap = r.log(0.02, 0.2);
    s.moved(|p| p.map(|x| (x / snap).round() * snap))
}
