//! Twin of shaders/stretch.wgsl: springs of one direction and parity, with compliance.

use super::lanes::{LANES, Lanes, load, peek, splat, store, widest};
use super::real::Real;
use super::rows::Threads;
use super::sheet::{Sheet, Values, planes};

/// The springs of one direction.
pub struct Springs<T> {
    /// Rest lengths \[m\]; 0 is no spring.
    pub rest: Values<T>,
    /// Compliance \[m/N\].
    pub soft: Values<T>,
    /// Sums of multipliers of this step, if there is more than one relaxation and any compliance.
    pub sums: Option<Vec<T>>,
}

/// Relaxes the springs of a colour once. `rate` is 1 / dt^2 \[1/s^2\].
///
/// A spring of length l moves its ends along itself by w g, g = (l - rest - a s) / (w1 + w2 + a), a = compliance / dt^2,
/// s the sum of the g of earlier relaxations of this step (Macklin, Mueller, Chentanez, "XPBD", MIG 2016).
pub fn run<T: Real>(
    threads: &Threads,
    sheet: &mut Sheet<T>,
    springs: &mut Springs<T>,
    direction: u32,
    parity: u32,
    rate: T,
) {
    let (width, half, row) = (sheet.width, sheet.half, sheet.row());
    let w = &sheet.w[..];
    let Springs { rest, soft, sums } = springs;
    let spring = Spring { rest, soft, half, rate, columns: [width.div_ceil(2), width / 2, (width - 1) / 2] };
    let parity = parity as usize;
    let (first, step) = if direction == 0 { (0, 1) } else { (parity, 2) };
    let size = TOGETHER / step * step;
    let rows = &mut sheet.now[first * row..];
    let work = |chunk: usize, rows: &mut [T], sums: &mut [T]| {
        widest(
            #[inline(always)]
            || {
                for (n, rows) in rows.chunks_exact_mut(step * row).enumerate() {
                    let sums = sums.get_mut(n * step * 2 * half..).unwrap_or(&mut []);
                    spring.rows(rows, w, first + chunk * size + n * step, (direction, parity), sums);
                }
            },
        );
    };
    match sums {
        Some(sums) => threads.chunks2(rows, &mut sums[first * 2 * half..], (size * row, size * 2 * half), work),
        None => threads.chunks(rows, size * row, |chunk, rows| work(chunk, rows, &mut [])),
    }
}

/// Rows that are done in one go.
const TOGETHER: usize = 32;

struct Spring<'a, T> {
    rest: &'a Values<T>,
    soft: &'a Values<T>,
    half: usize,
    rate: T,
    /// Even columns, pairs from even to odd, pairs from odd to even.
    columns: [usize; 3],
}

/// One end of a list of springs.
struct End<'a, T> {
    at: [&'a mut [T]; 3],
    w: &'a [T],
}

impl<T: Real> Spring<'_, T> {
    #[inline(always)]
    fn rows(&self, rows: &mut [T], w: &[T], j: usize, (direction, parity): (u32, usize), sums: &mut [T]) {
        let [evens, even, odd] = self.columns;
        match direction {
            0 => self.right(rows, w, j, parity, [even, odd][parity], sums),
            1 => self.down(rows, w, j, [evens, even], sums),
            2 => self.down_right(rows, w, j, [even, odd], sums),
            _ => self.up_right(rows, w, j, [even, odd], sums),
        }
    }

    #[inline(always)]
    fn right(&self, row: &mut [T], w: &[T], j: usize, parity: usize, count: usize, sums: &mut [T]) {
        let half = self.half;
        let w = &w[j * 2 * half..][..2 * half];
        let [x, y, z] = planes(row, half).map(|p| p.split_at_mut(half));
        let (we, wo) = w.split_at(half);
        let stored = j * 2 * half + parity * half;
        let sums = sums.get_mut(parity * half..).unwrap_or(&mut []);
        let e = [x.0, y.0, z.0];
        let o = [x.1, y.1, z.1];
        if parity == 0 {
            self.relax(End { at: e, w: we }, End { at: o, w: wo }, stored, count, sums);
        } else {
            self.relax(End { at: o, w: wo }, End { at: e.map(|p| &mut p[1..]), w: &we[1..] }, stored, count, sums);
        }
    }

    #[inline(always)]
    fn down(&self, rows: &mut [T], w: &[T], j: usize, counts: [usize; 2], sums: &mut [T]) {
        for side in 0..2 {
            let (upper, lower) = ends(rows, w, j, self.half, [side, side], [0, 0]);
            let stored = (j * 2 + side) * self.half;
            self.relax(upper, lower, stored, counts[side], sums.get_mut(side * self.half..).unwrap_or(&mut []));
        }
    }

    #[inline(always)]
    fn down_right(&self, rows: &mut [T], w: &[T], j: usize, counts: [usize; 2], sums: &mut [T]) {
        for side in 0..2 {
            let (upper, lower) = ends(rows, w, j, self.half, [side, 1 - side], [0, side]);
            let stored = (j * 2 + side) * self.half;
            self.relax(upper, lower, stored, counts[side], sums.get_mut(side * self.half..).unwrap_or(&mut []));
        }
    }

    /// Stored at the lower left end.
    #[inline(always)]
    fn up_right(&self, rows: &mut [T], w: &[T], j: usize, counts: [usize; 2], sums: &mut [T]) {
        for side in 0..2 {
            let (upper, lower) = ends(rows, w, j, self.half, [1 - side, side], [side, 0]);
            let stored = ((j + 1) * 2 + side) * self.half;
            self.relax(lower, upper, stored, counts[side], sums.get_mut((2 + side) * self.half..).unwrap_or(&mut []));
        }
    }

    #[inline(always)]
    fn relax(&self, a: End<T>, b: End<T>, stored: usize, count: usize, sums: &mut [T]) {
        if matches!(self.soft, Values::Constant(x) if *x == T::of(0.0)) {
            self.list::<true>(a, b, stored, count, sums);
        } else {
            self.list::<false>(a, b, stored, count, sums);
        }
    }

    /// Plain loops over arrays: what compilers turn into vector instructions. Closures over many arrays are not.
    #[inline(always)]
    fn list<const HARD: bool>(&self, a: End<T>, b: End<T>, stored: usize, count: usize, sums: &mut [T]) {
        let (zero, closest, least) = (T::of(0.0), T::of(1e-9), T::of(1e-30));
        let whole = count / LANES * LANES;
        let [ax, ay, az] = a.at;
        let [bx, by, bz] = b.at;
        let mut at = 0;
        while at < count {
            let (pax, pay, paz) = (load(ax, at), load(ay, at), load(az, at));
            let (pbx, pby, pbz) = (load(bx, at), load(by, at), load(bz, at));
            let (wa, wb) = (load(a.w, at), load(b.w, at));
            let rest = value(self.rest, stored + at);
            let (mut dx, mut dy, mut dz) = ([zero; LANES], [zero; LANES], [zero; LANES]);
            for k in 0..LANES {
                dx[k] = pbx[k] - pax[k];
                dy[k] = pby[k] - pay[k];
                dz[k] = pbz[k] - paz[k];
            }
            let (mut far, mut g) = ([zero; LANES], [zero; LANES]);
            for k in 0..LANES {
                far[k] = (dx[k] * dx[k] + dy[k] * dy[k] + dz[k] * dz[k]).sqrt().max(closest);
            }
            if HARD {
                for k in 0..LANES {
                    g[k] = (far[k] - rest[k]) / (far[k] * (wa[k] + wb[k])).max(least);
                }
            } else {
                let (soft, sum) = (value(self.soft, stored + at), peek(sums, at));
                for k in 0..LANES {
                    let soft = soft[k] * self.rate;
                    g[k] = (far[k] - rest[k] - soft * sum[k]) / (far[k] * (wa[k] + wb[k] + soft)).max(least);
                }
            }
            for k in 0..LANES {
                g[k] = if rest[k] > zero { g[k] } else { zero };
            }
            if at == whole {
                for k in 0..LANES {
                    g[k] = if at + k < count { g[k] } else { zero };
                }
            }
            if !HARD && !sums.is_empty() {
                let mut sum = peek(sums, at);
                for k in 0..LANES {
                    sum[k] = sum[k] + g[k] * far[k];
                }
                store(sums, at, &sum);
            }
            let (mut ga, mut gb) = ([zero; LANES], [zero; LANES]);
            for k in 0..LANES {
                ga[k] = g[k] * wa[k];
                gb[k] = g[k] * wb[k];
            }
            let mut out = [zero; LANES];
            for k in 0..LANES {
                out[k] = pax[k] + dx[k] * ga[k];
            }
            store(ax, at, &out);
            for k in 0..LANES {
                out[k] = pay[k] + dy[k] * ga[k];
            }
            store(ay, at, &out);
            for k in 0..LANES {
                out[k] = paz[k] + dz[k] * ga[k];
            }
            store(az, at, &out);
            for k in 0..LANES {
                out[k] = pbx[k] - dx[k] * gb[k];
            }
            store(bx, at, &out);
            for k in 0..LANES {
                out[k] = pby[k] - dy[k] * gb[k];
            }
            store(by, at, &out);
            for k in 0..LANES {
                out[k] = pbz[k] - dz[k] * gb[k];
            }
            store(bz, at, &out);
            at += LANES;
        }
    }
}

#[inline(always)]
fn value<T: Real>(values: &Values<T>, at: usize) -> Lanes<T> {
    match values {
        Values::Constant(x) => splat(*x),
        Values::List(list) => load(list, at),
    }
}

/// The halves `side` of two rows, each from `from` on.
#[inline(always)]
fn ends<'a, T>(
    rows: &'a mut [T],
    w: &'a [T],
    j: usize,
    half: usize,
    side: [usize; 2],
    from: [usize; 2],
) -> (End<'a, T>, End<'a, T>) {
    let (upper, lower) = rows.split_at_mut(6 * half);
    let cut = |row: &'a mut [T], n: usize| {
        planes(row, half).map(|p| &mut p[side[n] * half + from[n]..(side[n] + 1) * half])
    };
    let weights = |n: usize| &w[((j + n) * 2 + side[n]) * half + from[n]..((j + n) * 2 + side[n] + 1) * half];
    (End { at: cut(upper, 0), w: weights(0) }, End { at: cut(lower, 1), w: weights(1) })
}
