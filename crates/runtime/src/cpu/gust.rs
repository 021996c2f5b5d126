//! Velocity of the air at a point: the wind, its heading turned by value noise. Twin of shaders/gust.wgsl and shaders/part/gust.wgsl.

use super::rows::Threads;
use super::sheet::{Sheet, columns, planes, planes_ref};
use crate::number::lanes::{Machine, Work, widest};
use crate::number::noise::{LastCell, noise, noises};
use crate::number::real::{Real, V3, with_w, xyz};
use crate::step::Step;

/// Rows, and texels, that are done in one go.
const TOGETHER: usize = 32;
const CHUNK: usize = 1024;

/// Writes the velocity \[m/s\] of the air at each particle.
pub fn run<T: Real>(threads: &Threads, step: &Step<T>, now: &[[T; 4]], airs: &mut [[T; 4]]) {
    threads.chunks(airs, CHUNK, |chunk, airs| {
        let mut last = LastCell::default();
        for (air_at, p) in airs.iter_mut().zip(&now[chunk * CHUNK..]) {
            *air_at = with_w(air(step, &mut last, xyz(*p)), T::of(0.0));
        }
    });
}

/// The same for a sheet, with the same bits; velocities lie as [`Sheet::now`].
pub fn of_sheet<T: Real>(threads: &Threads, step: &Step<T>, sheet: &Sheet<T>, airs: &mut [T]) {
    let row = sheet.row();
    threads.chunks(airs, TOGETHER * row, |chunk, airs| {
        widest(Rows { step, sheet, airs, now: &sheet.now[chunk * TOGETHER * row..] });
    });
}

/// Some rows of a sheet.
struct Rows<'a, 'b, T: Real> {
    step: &'a Step<T>,
    sheet: &'a Sheet<T>,
    airs: &'b mut [T],
    now: &'a [T],
}

impl<T: Real> Work<T> for Rows<'_, '_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let Rows { step, sheet, airs, now } = self;
        let (row, half) = (sheet.row(), sheet.half);
        let mut last = LastCell::default();
        for (airs, now) in airs.chunks_exact_mut(row).zip(now.chunks_exact(row)) {
            let (to, from) = (planes(airs, half), planes_ref(now, half));
            for at in columns(sheet.width, half, K::WIDE) {
                let p = [k.load(from[0], at), k.load(from[1], at), k.load(from[2], at)];
                let of = super::gust::airs(k, step, &mut last, p);
                k.store(to[0], at, of[0]);
                k.store(to[1], at, of[1]);
                k.store(to[2], at, of[2]);
            }
        }
    }
}

/// Velocity \[m/s\] of the air at `p`.
#[inline]
pub fn air<T: Real>(step: &Step<T>, last: &mut LastCell<T>, p: V3<T>) -> V3<T> {
    if step.turn == T::of(0.0) {
        return step.wind;
    }
    let q = [0, 1, 2].map(|c| p[c] * step.fineness - step.drift[c]);
    let t = step.turn * noise(last, q);
    // cos and sin by the tangent of the half angle: no trigonometry, so devices agree.
    let over = T::of(1.0) / (T::of(1.0) + t * t);
    let (cos, sin) = ((T::of(1.0) - t * t) * over, T::of(2.0) * t * over);
    let w = step.wind;
    [cos * w[0] + sin * w[2], w[1], cos * w[2] - sin * w[0]]
}

/// The same at a vector of points, with the same bits.
#[inline(always)]
pub fn airs<T: Real, K: Machine<T>>(k: K, step: &Step<T>, last: &mut LastCell<T>, p: [K::V; 3]) -> [K::V; 3] {
    let w = k.splats(step.wind);
    if step.turn == T::of(0.0) {
        return w;
    }
    let (one, fineness) = (k.splat(T::of(1.0)), k.splat(step.fineness));
    let q = k.minus(k.times(p, fineness), k.splats(step.drift));
    let t = k.mul(k.splat(step.turn), noises(k, last, q));
    let square = k.mul(t, t);
    let over = k.div(one, k.add(one, square));
    let cos = k.mul(k.sub(one, square), over);
    let sin = k.mul(k.mul(k.splat(T::of(2.0)), t), over);
    [k.add(k.mul(cos, w[0]), k.mul(sin, w[2])), w[1], k.sub(k.mul(cos, w[2]), k.mul(sin, w[0]))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloth::Grid;

    #[test]
    fn sheets_and_texels_have_the_same_bits() {
        let step =
            Step { wind: [4.0f32, 0.5, -2.0], turn: 0.6, fineness: 7.0, drift: [3.0, 0.2, 900.0], ..Step::default() };
        for (width, height) in [(2, 3), (33, 18), (40, 70)] {
            let place = |k: usize| [0.02 * (k % width) as f32, -0.02 * (k / width) as f32, 0.03 * (k % 7) as f32, 1.0];
            let now: Vec<_> = (0..width * height).map(place).collect();
            let grid = Grid { name: String::new(), first: 0, width: width as u32, height: height as u32 };
            let mut sheet = Sheet::new(&grid);
            sheet.load(&now, &now);
            let (mut rows, mut texels) = (vec![0.0; sheet.now.len()], vec![[0.0; 4]; now.len()]);
            of_sheet(&Threads::one(), &step, &sheet, &mut rows);
            run(&Threads::one(), &step, &now, &mut texels);
            let mut back = vec![[0.0; 4]; now.len()];
            sheet.gather(&rows, &mut back);
            assert_eq!(back, texels);
            let speed = |v: &[f32; 4]| (v[0] * v[0] + v[2] * v[2]).sqrt();
            assert!(texels.iter().all(|v| (speed(v) - 20f32.sqrt()).abs() < 1e-5 && v[1] == 0.5));
            assert!(width < 9 || texels.iter().any(|v| v[0] != texels[0][0]), "gusts turn the wind");
        }
    }
}
