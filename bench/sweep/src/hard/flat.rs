//! Flat sheets with hard borders: holes, teeth, ribbons, spirals, fractals, necks, mazes.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::{between, count};
use crate::random::Random;
use crate::shape::{Shape, Wrap};

fn flat(u: f64, v: f64) -> [f64; 3] {
    [u, v, 0.0]
}

/// A sheet with 9 to 400 holes of `hole` x `hole` quads in cells of `cell` x `cell`.
fn holes(n: usize, cell: usize, hole: usize) -> Shape {
    let side = (n as f64).sqrt().ceil() as usize;
    let first = (cell - hole).div_ceil(2);
    let inside = |i: usize| (first..first + hole).contains(&(i % cell));
    let hole = |i: usize, j: usize| inside(i) && inside(j) && (j / cell) * side + i / cell < n;
    // A bar on the far side too.
    let size = cell * side + first;
    Shape::masked(size, size, |i, j| !hole(i, j), flat)
}

/// Lace of 9 to 400 holes, every other one bent to a cylinder.
pub fn lace(r: &mut Random, t: f64) -> Shape {
    let s = holes(count(t, 9.0, 400.0), 3 + r.below(2), 1);
    if r.chance(0.5) { s } else { s.moved(|[x, y, _]| [x.sin(), y, x.cos()]) }
}

/// A net of 9 to 400 meshes whose bars are one quad wide.
pub fn net(r: &mut Random, t: f64) -> Shape {
    let jitter = r.within(0.0, 0.2);
    let s = holes(count(t, 9.0, 400.0), 4, 3);
    let step = s.diagonal() / (s.positions.len() as f64).sqrt();
    s.moved(|[x, y, z]| [x + jitter * step * r.within(-0.5, 0.5), y + jitter * step * r.within(-0.5, 0.5), z])
}

/// A comb of 2 to 150 teeth, up to 1,000 times as long as wide.
pub fn comb(r: &mut Random, t: f64) -> Shape {
    let teeth = count(t, 2.0, 150.0);
    let (rows, length) = (4 + r.below(30), r.log(1.0, 1000.0));
    Shape::masked(
        2 * teeth + 1,
        rows + 2,
        |i, j| j < 2 || i % 2 == 0,
        move |u, v| {
            let x = u * (2 * teeth + 1) as f64;
            let y = v * (rows + 2) as f64;
            [x, if y <= 2.0 { y } else { 2.0 + (y - 2.0) * length / rows as f64 }, 0.0]
        },
    )
}

/// A ribbon of 1:10 to 1:10,000, straight or turned about its axis.
pub fn ribbon(r: &mut Random, t: f64) -> Shape {
    let (ratio, turns) = (between(t, 10.0, 10_000.0), if r.chance(0.5) { 0.0 } else { r.within(0.5, 20.0) });
    let across = 1 + r.below(4);
    Shape::sheet((ratio as usize).clamp(20, 3000), across, move |u, v| {
        let (a, w) = (TAU * turns * u, v - 0.5);
        [ratio * u, w * a.cos(), w * a.sin()]
    })
}

/// A flat spiral or a helix of 2 to 60 turns.
pub fn spiral(r: &mut Random, t: f64) -> Shape {
    let (turns, rise) = (between(t, 2.0, 60.0), if r.chance(0.5) { 0.0 } else { r.within(0.5, 3.0) });
    let width = r.within(0.1, 0.9);
    Shape::sheet((40.0 * turns) as usize, 2, move |u, v| {
        let a = TAU * turns * u;
        let radius = if rise > 0.0 { 3.0 } else { 1.0 + a / TAU } + width * (v - 0.5);
        [radius * a.cos(), radius * a.sin(), rise * a / TAU]
    })
}

/// Koch's snowflake of 1 to 5 levels: every edge of the border grows a triangle.
pub fn koch(_: &mut Random, t: f64) -> Shape {
    let mut s = Shape::default();
    let corner = |k: u32| [(TAU * f64::from(k) / 3.0).cos(), (TAU * f64::from(k) / 3.0).sin(), 0.0];
    s.loose([corner(0), corner(1), corner(2)]);
    let mut border: Vec<[u32; 2]> = vec![[0, 1], [1, 2], [2, 0]];
    let mut owner: BTreeMap<[u32; 2], usize> = border.iter().map(|&e| (e, 0)).collect();
    for _ in 0..1 + (t * 4.0).round() as usize {
        let mut grown = Vec::with_capacity(4 * border.len());
        for &[a, b] in &border {
            let Some(&triangle) = owner.get(&[a, b]) else { continue };
            let Some(&apex) = s.triangles[triangle].iter().find(|&&v| v != a && v != b) else { continue };
            let (p, q) = (s.positions[a as usize], s.positions[b as usize]);
            let third = [0, 1, 2].map(|c| (q[c] - p[c]) / 3.0);
            let n = s.positions.len() as u32;
            let tip =
                [0.5 * (p[0] + q[0]) + third[1] * 0.75f64.sqrt(), 0.5 * (p[1] + q[1]) - third[0] * 0.75f64.sqrt(), 0.0];
            s.positions.extend([[0, 1, 2].map(|c| p[c] + third[c]), tip, [0, 1, 2].map(|c| q[c] - third[c])]);
            let (start, top, end) = (n, n + 1, n + 2);
            s.triangles[triangle] = [a, start, apex];
            let first = s.triangles.len();
            s.triangles.extend([[start, end, apex], [end, b, apex], [start, top, end]]);
            // The two other sides of the old triangle belong to parts of it now.
            owner.entry([apex, a]).and_modify(|o| *o = triangle);
            owner.entry([b, apex]).and_modify(|o| *o = first + 1);
            for (edge, of) in
                [([a, start], triangle), ([start, top], first + 2), ([top, end], first + 2), ([end, b], first + 1)]
            {
                owner.insert(edge, of);
                grown.push(edge);
            }
        }
        border = grown;
    }
    s
}

/// A star-shaped sheet whose radius is a fractal of 16 to 4,096 points.
pub fn coast(r: &mut Random, t: f64) -> Shape {
    let n = 1usize << (4 + (t * 7.0).round() as usize);
    let roughness = r.within(0.5, 0.9);
    let mut radius = vec![1.0; n];
    let (mut step, mut size) = (n / 2, 0.4);
    while step > 0 {
        for k in (step..n).step_by(2 * step) {
            let mean: f64 = 0.5 * (radius[k - step] + radius[(k + step) % n]);
            radius[k] = (mean + size * r.within(-1.0, 1.0)).max(0.05);
        }
        (step, size) = (step / 2, size * roughness);
    }
    let rings = (8000 / n).clamp(1, 12);
    Shape::grid(
        n,
        rings,
        Wrap::Closed,
        Wrap::Open,
        |_, _| true,
        move |u, v| {
            let (a, k) = (TAU * u, (u * n as f64).round() as usize % n);
            let d = 0.02 + (radius[k] - 0.02) * v;
            [d * a.cos(), -d * a.sin(), 0.0]
        },
    )
}

/// The largest part of a grid whose quads are there with a probability just above percolation.
pub fn percolation(r: &mut Random, t: f64) -> Shape {
    let n = 20 + (t * 80.0) as usize;
    let p = r.within(0.62, 0.75);
    let there: Vec<bool> = (0..n * n).map(|_| r.chance(p)).collect();
    let mut label = vec![0usize; n * n];
    let (mut best, mut most) = (0, 0);
    for start in 0..n * n {
        if !there[start] || label[start] > 0 {
            continue;
        }
        let (mut open, mut size) = (vec![start], 0);
        label[start] = start + 1;
        while let Some(k) = open.pop() {
            size += 1;
            let (i, j) = (k % n, k / n);
            let mut visit = |m: usize| {
                if there[m] && label[m] == 0 {
                    label[m] = start + 1;
                    open.push(m);
                }
            };
            if i > 0 {
                visit(k - 1)
            }
            if i + 1 < n {
                visit(k + 1)
            }
            if j > 0 {
                visit(k - n)
            }
            if j + 1 < n {
                visit(k + n)
            }
        }
        if size > most {
            (best, most) = (start + 1, size);
        }
    }
    Shape::masked(n, n, |i, j| label[j * n + i] == best, flat)
}

/// A maze of corridors: a random spanning tree of up to 40 x 40 cells.
pub fn maze(r: &mut Random, t: f64) -> Shape {
    let n = 4 + (t * 36.0) as usize;
    let size = 2 * n - 1;
    let mut there = vec![false; size * size];
    let mut seen = vec![false; n * n];
    let mut path = vec![0usize];
    seen[0] = true;
    there[0] = true;
    while let Some(&k) = path.last() {
        let (i, j) = ((k % n) as isize, (k / n) as isize);
        let free: Vec<(isize, isize)> = [(1, 0), (-1, 0), (0, 1), (0, -1)]
            .into_iter()
            .filter(|&(di, dj)| {
                let (x, y) = (i + di, j + dj);
                (0..n as isize).contains(&x) && (0..n as isize).contains(&y) && !seen[(y * n as isize + x) as usize]
            })
            .collect();
        if free.is_empty() {
            path.pop();
            continue;
        }
        let (di, dj) = free[r.below(free.len())];
        let (x, y) = (i + di, j + dj);
        there[((2 * j + dj) * size as isize + 2 * i + di) as usize] = true;
        there[(2 * y * size as isize + 2 * x) as usize] = true;
        seen[(y * n as isize + x) as usize] = true;
        path.push((y * n as isize + x) as usize);
    }
    Shape::masked(size, size, |i, j| there[j * size + i], flat)
}

/// A sheet with 1 to 60 slits of no width.
pub fn slits(r: &mut Random, t: f64) -> Shape {
    let n = count(t, 1.0, 60.0);
    let (w, h) = (2 * n + 2, 12 + r.below(20));
    let mut s = Shape::sheet(w, h, flat);
    // Quads to the right of an odd column get vertices of their own there, but for the ends of the slit.
    for k in 0..n {
        let column = 2 * k + 1;
        let (from, to) = (1 + r.below(2), h - 1);
        let mut copy = BTreeMap::new();
        for j in from + 1..to {
            // `sheet` numbers vertices as triangles meet them, so they are found by position.
            let at = flat(column as f64 / w as f64, j as f64 / h as f64);
            let Some(old) = s.positions.iter().position(|p| *p == at) else { continue };
            copy.insert(old as u32, s.positions.len() as u32);
            s.positions.push(at);
        }
        let x = column as f64 / w as f64;
        for t in 0..s.triangles.len() {
            let right = s.triangles[t].iter().any(|&v| s.positions[v as usize][0] > x);
            if right {
                s.triangles[t] = s.triangles[t].map(|v| copy.get(&v).copied().unwrap_or(v));
            }
        }
    }
    // Equal positions are joined on import: a slit is open by a hair.
    let open = r.log(1e-9, 1e-3);
    let mut seen = BTreeMap::new();
    for p in &mut s.positions {
        let key = p.map(f64::to_bits);
        let nth = seen.entry(key).or_insert(0u32);
        p[0] += f64::from(*nth) * open / n as f64;
        *nth += 1;
    }
    s
}

/// Disks in a row, each joined to the next by one edge or by a neck of 0.1 to 1e-6 of its size.
pub fn necks(r: &mut Random, t: f64) -> Shape {
    let (n, neck) = (2 + r.below(6), between(t, 0.1, 1e-6));
    Shape::sheet(40 * n, 8, move |u, v| {
        let x = u * n as f64;
        let width = neck + (1.0 - neck) * (0.5 - 0.5 * (TAU * x).cos());
        let width = if u == 0.0 || u == 1.0 { neck.max(0.05) } else { width };
        [x, (v - 0.5) * width, 0.0]
    })
}

/// A ring whose hole is 0.5 to 1e-8 of it, or whose width is 0.1 to 1e-4.
pub fn ring(r: &mut Random, t: f64) -> Shape {
    let inner = if r.chance(0.6) { between(t, 0.5, 1e-8) } else { 1.0 - between(t, 0.1, 1e-4) };
    let around = 12 + r.below(200);
    Shape::tube(around, 1 + r.below(20), move |a, v| {
        let d = if inner < 0.5 { inner.powf(1.0 - v) } else { inner + (1.0 - inner) * v };
        [d * a.cos(), -d * a.sin(), 0.0]
    })
}

/// A disk of rings whose radii fall to 1e-2 to 1e-12: triangles of every size.
pub fn graded(r: &mut Random, t: f64) -> Shape {
    let (least, around, rings) = (between(t, 1e-2, 1e-12), 6 + r.below(30), 10 + r.below(60));
    let mut s = Shape::tube(around, rings, move |a, v| {
        let d = least.powf(1.0 - v);
        [d * a.cos(), -d * a.sin(), 0.0]
    });
    close(&mut s, least);
    s
}

/// Fills the hole around the origin by a fan of the vertices within `radius`.
fn close(s: &mut Shape, radius: f64) {
    let mut rim: Vec<u32> = (0..s.positions.len() as u32)
        .filter(|&v| s.positions[v as usize].iter().map(|x| x * x).sum::<f64>().sqrt() < 1.001 * radius)
        .collect();
    let angle = |v: u32| s.positions[v as usize][1].atan2(s.positions[v as usize][0]);
    rim.sort_by(|&a, &b| angle(a).total_cmp(&angle(b)));
    let centre = s.positions.len() as u32;
    for k in 0..rim.len() {
        s.triangles.push([centre, rim[(k + 1) % rim.len()], rim[k]]);
    }
    s.positions.push([0.0; 3]);
}

/// A sheet whose rows are squeezed: triangles of aspect 1e2 to 1e8, along a border or in the middle.
pub fn slivers(r: &mut Random, t: f64) -> Shape {
    let (aspect, n) = (between(t, 1e2, 1e8), 8 + r.below(30));
    let (squeezed, sheared) = (r.below(n - 1), r.chance(0.5));
    let thin = 1.0 / (n as f64 * aspect);
    Shape::sheet(n, n, move |u, v| {
        let row = (v * n as f64).round() as usize;
        let y = if row > squeezed { (row - 1) as f64 / n as f64 + thin } else { row as f64 / n as f64 };
        [if sheared && row > squeezed { u + 0.37 / n as f64 } else { u }, y, 0.0]
    })
}

/// A sheet whose every triangle is a needle of aspect 1e1 to 1e6.
pub fn needles(r: &mut Random, t: f64) -> Shape {
    let (aspect, w, h) = (between(t, 10.0, 1e6), 1 + r.below(4), 50 + r.below(400));
    let slant = r.within(0.0, 2.0);
    Shape::sheet(w, h, move |u, v| [u * w as f64 * aspect + slant * v, v * h as f64, 0.1 * (TAU * v).sin() * h as f64])
}

/// A flat sheet after random flips of edges: slivers and vertices of many triangles.
pub fn flipped(r: &mut Random, t: f64) -> Shape {
    let n = 8 + r.below(24);
    let mut s = Shape::sheet(n, n, flat);
    let jitter = 0.3 / n as f64;
    s = s.moved(|[x, y, z]| {
        if [x, y].iter().all(|c| (0.01..0.99).contains(c)) {
            [x + r.within(-jitter, jitter), y + r.within(-jitter, jitter), z]
        } else {
            [x, y, z]
        }
    });
    let mut edge: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for (k, t) in s.triangles.iter().enumerate() {
        edge.extend((0..3).map(|c| ([t[c], t[(c + 1) % 3]], k)));
    }
    let rounds = (t * 20.0 * s.triangles.len() as f64) as usize;
    for _ in 0..rounds {
        let (k, c) = (r.below(s.triangles.len()), r.below(3));
        let [a, b, p] = [0, 1, 2].map(|d| s.triangles[k][(c + d) % 3]);
        let Some(&m) = edge.get(&[b, a]) else { continue };
        let Some(&q) = s.triangles[m].iter().find(|&&v| v != a && v != b) else { continue };
        let area = |i: u32, j: u32, l: u32| {
            let [i, j, l] = [i, j, l].map(|v| s.positions[v as usize]);
            (j[0] - i[0]) * (l[1] - i[1]) - (j[1] - i[1]) * (l[0] - i[0])
        };
        let least = 1e-9 / (n * n) as f64;
        if area(a, q, p) <= least || area(q, b, p) <= least || edge.contains_key(&[q, p]) || edge.contains_key(&[p, q])
        {
            continue;
        }
        edge.remove(&[a, b]);
        edge.remove(&[b, a]);
        s.triangles[k] = [a, q, p];
        s.triangles[m] = [q, b, p];
        for of in [k, m] {
            let t = s.triangles[of];
            edge.extend((0..3).map(|c| ([t[c], t[(c + 1) % 3]], of)));
        }
    }
    s
}
