//! The shadow of a piece in light from straight above.

use super::piece::{PLATE, Piece};

/// Side of a pixel \[m\].
const PIXEL: f64 = 2.5e-4;
/// Half the side of the screen \[m\].
const HALF: f64 = 0.16;

/// Which pixels of a screen are dark.
pub struct Shadow {
    side: usize,
    dark: Vec<bool>,
}

impl Shadow {
    /// The shadow of what hangs outside of the plate.
    pub fn of(piece: &Piece, now: &[[f64; 4]]) -> Self {
        let side = (2.0 * HALF / PIXEL) as usize;
        let mut shadow = Shadow { side, dark: vec![false; side * side] };
        let at = |k: usize| [0, 2].map(|c| (now[k][c] + HALF) / PIXEL - 0.5);
        for [a, b, c, d] in piece.quads() {
            shadow.triangle([at(a), at(b), at(c)]);
            shadow.triangle([at(a), at(c), at(d)]);
        }
        shadow
    }

    /// Darkens the pixels whose centres lie in a triangle, whichever way it turns.
    fn triangle(&mut self, corners: [[f64; 2]; 3]) {
        let last = self.side as f64 - 1.0;
        let range = |c: usize| {
            let all = corners.map(|p| p[c]);
            let low = all.into_iter().fold(f64::INFINITY, f64::min).ceil().clamp(0.0, last);
            let high = all.into_iter().fold(f64::NEG_INFINITY, f64::max).floor().clamp(0.0, last);
            low as usize..=high as usize
        };
        let side = |[a, b]: [[f64; 2]; 2], p: [f64; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
        let [a, b, c] = corners;
        for y in range(1) {
            for x in range(0) {
                let p = [x as f64, y as f64];
                let sides = [side([a, b], p), side([b, c], p), side([c, a], p)];
                if sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0) {
                    self.dark[y * self.side + x] = true;
                }
            }
        }
    }

    /// Its area outside of the plate \[m^2\].
    pub fn area(&self) -> f64 {
        let outside = |k: usize| {
            let [x, z] = [k % self.side, k / self.side].map(|i| (i as f64 + 0.5) * PIXEL - HALF);
            x.hypot(z) > PLATE
        };
        let dark = self.dark.iter().enumerate().filter(|(k, dark)| **dark && outside(*k));
        dark.count() as f64 * PIXEL * PIXEL
    }
}
