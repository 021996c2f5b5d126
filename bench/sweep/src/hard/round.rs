//! Curved surfaces: fans, spheres, tubes, shells, twists and crumples.

use std::f64::consts::{PI, TAU};

use super::{between, count};
use crate::random::Random;
use crate::shape::{Shape, Wrap};

/// A fan of 100 to 10,000 triangles at a vertex: flat, a cone, or with far more than a full turn.
pub fn fan(r: &mut Random, t: f64) -> Shape {
    let n = count(t, 100.0, 10_000.0);
    let (height, waves) = ([0.0, 1.0, 5.0][r.below(3)], r.below(3) * (2 + r.below(20)));
    let mut s = Shape::default();
    s.positions.push([0.0, height, 0.0]);
    for k in 0..n {
        let a = TAU * k as f64 / n as f64;
        s.positions.push([a.cos(), 0.8 * (waves as f64 * a).sin(), a.sin()]);
        s.triangles.push([0, 1 + (k as u32 + 1) % n as u32, 1 + k as u32]);
    }
    s
}

/// Two cones base to base: closed, two vertices of 100 to 5,000 triangles.
pub fn bipyramid(r: &mut Random, t: f64) -> Shape {
    let (n, height) = (count(t, 100.0, 5_000.0), r.log(0.01, 100.0));
    let mut s = Shape::default();
    s.positions.extend([[0.0, height, 0.0], [0.0, -height, 0.0]]);
    for k in 0..n {
        let a = TAU * k as f64 / n as f64;
        s.positions.push([a.cos(), 0.0, a.sin()]);
        let (p, q) = (2 + k as u32, 2 + (k as u32 + 1) % n as u32);
        s.triangles.extend([[0, q, p], [1, p, q]]);
    }
    s
}

/// A sphere whose every n-th vertex is pulled out to 2 to 100 radii.
pub fn hedgehog(r: &mut Random, t: f64) -> Shape {
    let (length, every) = (between(t, 2.0, 100.0), 3 + r.below(20));
    let s = Shape::sphere(24 + r.below(24), 16 + r.below(16), |_| 1.0);
    let mut k = 0;
    s.moved(|p| {
        k += 1;
        if k % every == 0 { p.map(|x| x * length) } else { p }
    })
}

/// A sphere with 9 to 200 holes.
pub fn strainer(r: &mut Random, t: f64) -> Shape {
    let n = count(t, 9.0, 200.0);
    let side = (n as f64).sqrt().ceil() as usize;
    let cell = 3 + r.below(2);
    let size = cell * side;
    let hole = |i: usize, j: usize| i % cell == 1 && j % cell == 1 && (j / cell) * side + i / cell < n;
    Shape::grid(
        size,
        size,
        Wrap::Closed,
        Wrap::Open,
        |i, j| !hole(i, j),
        |u, v| {
            let (lon, lat) = (TAU * u, PI * (0.03 + 0.94 * v) - 0.5 * PI);
            [lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin()]
        },
    )
}

/// A sphere that one triangle was taken from, or that is open in a hole of 1e-1 to 1e-6 radii.
pub fn pinhole(r: &mut Random, t: f64) -> Shape {
    if r.chance(0.5) {
        let mut s = Shape::sphere(count(t, 8.0, 120.0), count(t, 6.0, 60.0), |_| 1.0);
        let gone = r.below(s.triangles.len());
        s.triangles.remove(gone);
        return s.compacted();
    }
    let least = between(t, 1e-1, 1e-6);
    Shape::tube(40, 40, move |a, v| {
        // Stereographic: rings of equal ratio from pole to pole.
        let d = (least / 2.0) * (4.0 / (least * least)).powf(v);
        let (sin, cos) = (2.0 * d / (1.0 + d * d), (1.0 - d * d) / (1.0 + d * d));
        [sin * a.cos(), cos, sin * a.sin()]
    })
}

/// Two to five balloons in a row with necks of 1e-1 to 1e-6 of their size, closed or open.
pub fn balloons(r: &mut Random, t: f64) -> Shape {
    let (n, neck, open) = (2 + r.below(4), between(t, 1e-1, 1e-6), r.chance(0.5));
    let ends = if open { 0.3 } else { 1e-3 };
    Shape::tube(24, 30 * n, move |a, v| {
        let x = v * n as f64;
        let middle = (PI * x).sin().abs();
        let radius = if v == 0.0 || v == 1.0 { ends } else { neck + (1.0 - neck) * middle };
        [radius * a.cos(), 2.0 * x, radius * a.sin()]
    })
}

/// A tube of 1:10 to 1:3,000, straight or a torus knot.
pub fn tube(r: &mut Random, t: f64) -> Shape {
    let (ratio, knot) = (between(t, 10.0, 3000.0), r.chance(0.5));
    let (p, q) = ([2.0, 3.0, 5.0][r.below(3)], [3.0, 5.0, 7.0][r.below(3)]);
    let along = if knot { Wrap::Closed } else { Wrap::Open };
    let steps = ((ratio * 2.0) as usize).clamp(60, 1500);
    let radius = if knot { (30.0 / ratio).clamp(0.01, 0.5) } else { 1.0 / ratio };
    Shape::grid(
        6 + r.below(6),
        steps,
        Wrap::Closed,
        along,
        |_, _| true,
        move |u, v| {
            let a = TAU * u;
            if !knot {
                return [radius * a.cos(), v, radius * a.sin()];
            }
            let b = TAU * v;
            let d = 2.0 + (q * b).cos();
            let centre = [d * (p * b).cos(), d * (p * b).sin(), (q * b).sin()];
            let out = [(p * b).cos(), (p * b).sin(), 0.0];
            [0, 1, 2].map(|c| centre[c] + radius * (a.cos() * out[c] + if c == 2 { a.sin() } else { 0.0 }))
        },
    )
}

/// A strip of 1 to 9 half turns: a Moebius strip where they are odd.
pub fn moebius(r: &mut Random, t: f64) -> Shape {
    let (half_turns, width) = (1 + (t * 8.0) as usize, r.within(0.05, 0.8));
    let wrap = if half_turns % 2 == 1 { Wrap::Twisted } else { Wrap::Closed };
    Shape::grid(
        40 + 20 * half_turns,
        4 + r.below(6),
        wrap,
        Wrap::Open,
        |_, _| true,
        move |u, v| {
            let (a, b) = (TAU * u, PI * half_turns as f64 * u);
            let w = width * (v - 0.5);
            let d = 1.0 + w * b.cos();
            [d * a.cos(), d * a.sin(), w * b.sin()]
        },
    )
}

/// Klein's bottle as a figure of eight, whole or with a hole.
pub fn klein(r: &mut Random, t: f64) -> Shape {
    let (n, hole) = (16 + (t * 60.0) as usize, r.chance(0.5));
    let radius = r.within(2.0, 4.0);
    let keep = move |i: usize, j: usize| !(hole && i < 2 && j < 2);
    Shape::grid(n, n, Wrap::Closed, Wrap::Twisted, keep, move |u, v| {
        // Along v the figure of eight makes half a turn, which takes u to 1 - u.
        let (a, b) = (TAU * u, TAU * v);
        let (x, y) = (a.sin(), (2.0 * a).sin());
        let (c, s) = ((0.5 * b).cos(), (0.5 * b).sin());
        let (d, z) = (radius + c * x - s * y, s * x + c * y);
        [d * b.cos(), d * b.sin(), z]
    })
}

/// Values on a lattice, smoothly joined: noise of one octave.
fn noise(seed: u64, p: [f64; 2]) -> f64 {
    let [i, j] = p.map(f64::floor);
    let value = |di: f64, dj: f64| {
        let key = ((i + di) as i64 as u64).wrapping_mul(0x9E37_79B9).wrapping_add(((j + dj) as i64 as u64) << 32);
        Random::new(seed, key).within(-1.0, 1.0)
    };
    let smooth = |x: f64| x * x * (3.0 - 2.0 * x);
    let (x, y) = (smooth(p[0] - i), smooth(p[1] - j));
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    mix(mix(value(0.0, 0.0), value(1.0, 0.0), x), mix(value(0.0, 1.0), value(1.0, 1.0), x), y)
}

/// A sheet crumpled by noise of several octaves in all three directions.
pub fn crumple(r: &mut Random, t: f64) -> Shape {
    let (n, strength) = (20 + r.below(30), between(t, 0.02, 5.0));
    let seed = r.next();
    Shape::sheet(n, n, move |u, v| {
        let mut p = [u, v, 0.0];
        for octave in 0..5 {
            let f = f64::from(1 << octave) * 2.0;
            for (c, x) in p.iter_mut().enumerate() {
                *x += strength / f * noise(seed + 8 * octave + c as u64, [f * u, f * v]);
            }
        }
        p
    })
}

/// A sheet of random points: every vertex anywhere in a box.
pub fn shaken(r: &mut Random, t: f64) -> Shape {
    let n = 4 + (t * 36.0) as usize;
    Shape::sheet(n, n, |u, v| [u, v, 0.0]).moved(|_| r.point())
}

/// A pleated skirt: 10 to 200 pleats, each as deep as asked.
pub fn pleats(r: &mut Random, t: f64) -> Shape {
    let (n, depth) = (count(t, 10.0, 200.0), r.within(0.1, 0.9));
    Shape::tube(6 * n, 12, move |a, v| {
        let k = (a * (6 * n) as f64 / TAU).round() as usize % 6;
        let fold = [0.0, 0.5, 1.0, 1.0, 0.5, 0.0][k];
        let d = 1.0 + 0.5 * v - depth * v * fold;
        [d * a.cos(), -v, d * a.sin()]
    })
}

/// A ruffle: a sheet whose edge is 2 to 500 times as long as its other edge.
pub fn ruffle(r: &mut Random, t: f64) -> Shape {
    let (growth, rows) = (between(t, 2.0, 500.0), 6 + r.below(10));
    Shape::sheet(600, rows, move |u, v| {
        let size = v * v * growth / 60.0;
        let a = TAU * 30.0 * u;
        [6.0 * u + 0.05 * size * a.cos(), v + 0.3 * size * (2.0 * a).sin(), size * a.sin()]
    })
}

/// A sheet that winds 2 to 12 times around a vertex.
pub fn cover(r: &mut Random, t: f64) -> Shape {
    let (turns, around) = (2 + (t * 10.0) as usize, 12 + r.below(12));
    let rise = r.within(0.0, 0.3);
    let n = turns * around;
    let mut s = Shape::tube(n, 8, move |u, v| {
        let (a, d) = (u * turns as f64, 0.1 + 0.9 * v);
        [d * a.cos(), -d * a.sin(), rise * d * u.sin()]
    });
    // The inmost ring is drawn together in one vertex.
    let rim: Vec<u32> = (0..s.positions.len() as u32)
        .filter(|&v| {
            let [x, y, _] = s.positions[v as usize];
            x.hypot(y) < 0.1001
        })
        .collect();
    let centre = s.positions.len() as u32;
    s.positions.push([0.0; 3]);
    s.triangles.iter_mut().for_each(|t| *t = t.map(|v| if rim.binary_search(&v).is_ok() { centre } else { v }));
    s.triangles.retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
    s.compacted()
}

/// A double shell, closed along its rims, 1e-1 to 1e-7 thick: a sheet or a tube.
pub fn shell(r: &mut Random, t: f64) -> Shape {
    let (thick, n, round) = (between(t, 1e-1, 1e-7), 16 + r.below(30), r.chance(0.5));
    // Around the profile: up the outside, over the rim, down the inside.
    if round {
        return Shape::grid(
            n,
            2 * n,
            Wrap::Closed,
            Wrap::Closed,
            |_, _| true,
            move |u, v| {
                let (a, y) = (TAU * u, if v < 0.5 { 2.0 * v } else { 2.0 - 2.0 * v });
                let d = 0.4 + if v < 0.5 { 0.0 } else { -thick };
                [d * a.cos(), y, d * a.sin()]
            },
        );
    }
    let bend = r.within(0.0, 0.3);
    let mut s = Shape::sheet(n, n, move |u, v| [u, v, bend * (3.0 * u).sin()]);
    let back = Shape::sheet(n, n, move |u, v| {
        let rim = u == 0.0 || u == 1.0 || v == 0.0 || v == 1.0;
        [u, v, bend * (3.0 * u).sin() - if rim { 0.0 } else { thick }]
    });
    let offset = s.positions.len() as u32;
    s.positions.extend(&back.positions);
    s.triangles.extend(back.triangles.iter().map(|&[a, b, c]| [a + offset, c + offset, b + offset]));
    s
}

/// A sheet or a ball with one to five vertices pulled 1 to 1e6 diagonals away.
pub fn spike(r: &mut Random, t: f64) -> Shape {
    let far = between(t, 1.0, 1e6);
    let n = 12 + r.below(24);
    let mut s = if r.chance(0.5) { Shape::sheet(n, n, |u, v| [u, v, 0.0]) } else { Shape::sphere(n, n, |_| 0.5) };
    for _ in 0..1 + r.below(5) {
        let (k, d) = (r.below(s.positions.len()), r.direction());
        (0..3).for_each(|c| s.positions[k][c] += far * d[c]);
    }
    s
}

/// A tube, a sheet or a ball of a size from 1e-18 to 1e18.
pub fn scale(r: &mut Random, t: f64) -> Shape {
    let size = between(t, 1e-18, 1e18);
    plain(r).moved(|p| p.map(|x| x * size))
}

/// The same, of 1 m and 1e2 to 1e9 m from the origin.
pub fn far(r: &mut Random, t: f64) -> Shape {
    let (distance, d) = (between(t, 1e2, 1e9), r.direction());
    plain(r).moved(|p| [0, 1, 2].map(|c| p[c] + distance * d[c]))
}

/// A tube, a sheet or a ball squeezed along one axis by 1e-1 to 1e-9.
pub fn squeezed(r: &mut Random, t: f64) -> Shape {
    let (axis, factor) = (r.below(3), between(t, 1e-1, 1e-9));
    plain(r).moved(|mut p| {
        p[axis] *= factor;
        p
    })
}

/// A clean surface.
fn plain(r: &mut Random) -> Shape {
    let n = 12 + r.below(30);
    match r.below(3) {
        0 => Shape::sheet(n, n, |u, v| [u, v, 0.1 * (5.0 * u).sin() * (4.0 * v).cos()]),
        1 => Shape::tube(n, n, |a, v| [0.4 * a.cos(), v, 0.4 * a.sin()]),
        _ => Shape::sphere(n, n, |d| 0.5 + 0.1 * d[0]),
    }
}
