//! Twin of shaders/part/even.wgsl: where cloth is so even that no two of its features that are near on the surface can come into contact.
//!
//! The reasons are those of [`crate::cpu::truncation`] (flat.rs, spread.rs) for one time: each particle may be anywhere in its ball.

use super::Ball;
use crate::levels::safe::{EVEN_APART, EVEN_AREA2, EVEN_CHANGE, EVEN_ROOM};
use crate::number::real::{Real, V3, add, dot, scale, sub};

/// Whether the four cells around a texel cannot cross one another while their particles, row by row, stay in their balls, with a least gap \[m\].
pub fn is_even<T: Real>(balls: &[Ball<T>; 9], floor: T) -> bool {
    let at = balls.map(|ball| sub(ball.center, balls[4].center));
    let reach = balls.iter().map(|ball| ball.radius).fold(T::of(0.0), T::max);
    let (half, quarter) = (T::of(0.5), T::of(0.25));
    let (right, down) = (scale(sub(at[5], at[3]), half), scale(sub(at[7], at[1]), half));
    let (rr, rd, dd) = (dot(right, right), dot(right, down), dot(down, down));
    let (edges2, area2) = (rr * dd, rr * dd - rd * rd);
    if area2 <= edges2 * T::of(EVEN_AREA2) {
        return false;
    }
    // Coordinates in the plane of the block that are 1 longer per column, and per row.
    let u = sub(scale(right, dd / area2), scale(down, rd / area2));
    let v = sub(scale(down, rr / area2), scale(right, rd / area2));
    let (uu, uv, vv) = (dot(u, u), dot(u, v), dot(v, v));
    // The most that both together differ by, per distance.
    let root = (quarter * (uu - vv) * (uu - vv) + uv * uv).sqrt();
    let most = (half * (uu + vv) + root).sqrt();
    let need = most * (T::of(EVEN_CHANGE) * reach + floor * T::of(1.0 / EVEN_APART)) + T::of(EVEN_ROOM);
    let flat = at.map(|p| [dot(u, p), dot(v, p)]);
    // Whichever way the diagonal of a cell goes.
    [0, 1, 3, 4].into_iter().all(|n| {
        let (rights, downs) = ([[n, n + 1], [n + 3, n + 4]], [[n, n + 3], [n + 1, n + 4]]);
        rights.into_iter().all(|[p, q]| {
            downs.into_iter().all(|[r, s]| {
                let (a, b) = (flat[q][0] - flat[p][0], flat[q][1] - flat[p][1]);
                let (c, d) = (flat[s][0] - flat[r][0], flat[s][1] - flat[r][1]);
                let mean = half * (a + d) - need;
                let rest = quarter * ((a - d) * (a - d) + (b + c) * (b + c));
                mean > T::of(0.0) && mean * mean > rest
            })
        })
    })
}

/// How the edges of cells spread: bounds of those along rows and along columns \[m\], the largest radius of a ball, and whether all blocks are
/// even and all cells have two triangles.
#[derive(Clone, Copy, Debug)]
pub struct Spread<T> {
    pub right: [V3<T>; 2],
    pub down: [V3<T>; 2],
    pub reach: T,
    pub even: bool,
}

/// A low and a high corner around both of two pairs.
fn both<T: Real>([a, b]: [V3<T>; 2], [c, d]: [V3<T>; 2]) -> [V3<T>; 2] {
    [[0, 1, 2].map(|n| a[n].min(c[n])), [0, 1, 2].map(|n| b[n].max(d[n]))]
}

impl<T: Real> Spread<T> {
    /// That of no cell.
    pub fn none() -> Self {
        let far = T::of(f64::from(f32::MAX));
        let bound = [[far; 3], [-far; 3]];
        Spread { right: bound, down: bound, reach: T::of(0.0), even: true }
    }

    /// That of a cell with these corners, around it from the upper left one downwards.
    pub fn of(balls: &[Ball<T>; 4]) -> Self {
        let edge = |a: usize, b: usize| [sub(balls[b].center, balls[a].center); 2];
        let reach = balls.iter().map(|ball| ball.radius).fold(T::of(0.0), T::max);
        Spread { right: both(edge(0, 3), edge(1, 2)), down: both(edge(0, 1), edge(3, 2)), reach, even: true }
    }

    /// That of both.
    pub fn with(&self, other: &Self) -> Self {
        Spread {
            right: both(self.right, other.right),
            down: both(self.down, other.down),
            reach: self.reach.max(other.reach),
            even: self.even && other.even,
        }
    }

    /// Whether no two features of a rectangle of cells that share no point can come nearer to one another than a floor \[m\].
    pub fn is_apart(&self, floor: T) -> bool {
        let ball = |[low, high]: [V3<T>; 2]| {
            let half = scale(sub(high, low), T::of(0.5));
            (scale(add(low, high), T::of(0.5)), dot(half, half).sqrt())
        };
        let ((a, off_a), (b, off_b)) = (ball(self.right), ball(self.down));
        let (long_a, long_b) = (dot(a, a).sqrt(), dot(b, b).sqrt());
        let ab = dot(a, b).abs();
        let left = (long_a - ab / long_a).min(long_b - ab / long_b) - (off_a + off_b);
        self.even && T::of(0.999) * left > T::of(2.0) * self.reach + floor
    }
}
