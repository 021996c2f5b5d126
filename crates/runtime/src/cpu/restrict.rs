//! Twin of shaders/restrict.wgsl: the motion of a coarser image, from that of the finer one.

use crate::coarser::{FITS, Motion, ROUNDS, Table};
use crate::number::real::{Real, add, dot, scale, sub, with_w};

fn xyz<T: Real>([x, y, z, _]: [T; 4]) -> [T; 3] {
    [x, y, z]
}

/// Puts the particles of a coarse image where the finer one is, its triangles between the heights and depths of the fine surface: least
/// squares by Jacobi's method, then springs that are too short. On entry `coarse` has the inverse masses.
pub fn run(table: &Table, fine: &Motion, coarse: &mut Motion) {
    for (k, (now, before)) in coarse.now.iter_mut().zip(&mut coarse.before).enumerate() {
        let sample = table.sample(k);
        let w = now[3];
        (*now, *before) = (with_w(xyz(fine.now[sample]), w), with_w(xyz(fine.before[sample]), w));
    }
    let start = coarse.now.clone();
    for _ in 0..FITS {
        let from = coarse.now.clone();
        for (k, now) in coarse.now.iter_mut().enumerate().filter(|(_, p)| p[3] > 0.0) {
            *now = with_w(add(xyz(from[k]), fit(table, &fine.now, &from, k)), now[3]);
        }
    }
    follow(coarse, &start, |k| k);
    settle(table, &coarse.now.clone(), coarse);
}

/// How far the surface beside a coarse particle lies from the triangles, in the mean.
fn fit(table: &Table, fine: &[[f32; 4]], coarse: &[[f32; 4]], k: usize) -> [f32; 3] {
    let (mut sum, mut weight) = ([0.0; 3], 0.0);
    for (n, w) in table.near(k) {
        let (of, parts) = table.stencil(n);
        let part = |c: usize| scale(xyz(coarse[of[c]]), parts[c]);
        let at = add(add(part(0), part(1)), part(2));
        (sum, weight) = (add(sum, scale(sub(xyz(fine[n]), at), w)), weight + w);
    }
    scale(sum, 1.0 / weight.max(1e-9))
}

/// Previous positions move as positions have since `start`, so velocities stay.
fn follow(coarse: &mut Motion, start: &[[f32; 4]], point: impl Fn(usize) -> usize) {
    for (k, before) in coarse.before.iter_mut().enumerate() {
        let point = point(k);
        let way = sub(xyz(coarse.now[point]), xyz(start[point]));
        *before = with_w(add(xyz(*before), way), before[3]);
    }
}

/// Moves points apart until springs are no shorter than they are at rest: wrinkles that a coarse image cannot have leave its springs too
/// short, and the first step would throw the cloth apart.
fn settle(table: &Table, start: &[[f32; 4]], coarse: &mut Motion) {
    for round in 0..ROUNDS {
        for n in 0..table.colours() {
            let colour = if round % 2 == 0 { n } else { table.colours() - 1 - n };
            for (ends, rest) in table.springs(colour) {
                part(table, &mut coarse.now, ends, rest);
            }
        }
        for (k, (now, start)) in coarse.now.iter_mut().zip(start).enumerate() {
            let (from, way) = (xyz(*start), sub(xyz(*now), xyz(*start)));
            let (far, most) = (dot(way, way).sqrt(), table.most(k));
            if far > most {
                *now = with_w(add(from, scale(way, most / far)), now[3]);
            }
        }
    }
    follow(coarse, start, |k| table.point(k));
    for k in 0..coarse.now.len() {
        coarse.now[k] = with_w(xyz(coarse.now[table.point(k)]), coarse.now[k][3]);
    }
}

/// Draws the ends of a spring apart that is too short.
fn part(table: &Table, now: &mut [[f32; 4]], [a, b]: [usize; 2], rest: f32) {
    let (p, q) = (now[a], now[b]);
    let way = sub(xyz(q), xyz(p));
    let long = dot(way, way).sqrt();
    let [u, v] = [(p, a), (q, b)].map(|(p, k)| p[3].max(0.0) * table.share(k));
    if u + v > 0.0 && long > 1e-6 * rest && long < rest {
        let by = (rest - long) / (long * (u + v));
        now[a] = with_w(sub(xyz(p), scale(way, by * u)), p[3]);
        now[b] = with_w(add(xyz(q), scale(way, by * v)), q[3]);
    }
}
