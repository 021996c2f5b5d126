//! Twin of shaders/pick.wgsl: the nearest triangle that a ray meets.

use super::neighbours::View;
use crate::number::real::{Real, V3, cross, dot, sub};

/// A triangle on a ray: its distance, its code (twice the texel, plus 1 for the second of a quad), and the barycentric
/// weights of its second and third corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate<T> {
    pub distance: T,
    pub code: u32,
    pub weights: [T; 2],
}

/// An edge belongs to both of its triangles, so that no ray slips through between them.
pub const EDGE: f64 = 1e-6;

/// The nearest triangle of each row of one grid whose first particle is `first`.
pub fn run<T: Real>(view: View<T>, first: u32, origin: V3<T>, direction: V3<T>) -> Vec<Candidate<T>> {
    let rows = (view.now.len() / view.width).saturating_sub(1);
    let of = |j: usize| {
        let quads = (0..view.width).flat_map(move |i| {
            let (count, corners) = view.quad(i, j);
            let k = j * view.width + i;
            let bits = view.removed(k);
            (0..count as usize).filter(move |n| bits >> n & 1 == 0).filter_map(move |n| {
                let code = 2 * (first + k as u32) + n as u32;
                meet(corners[n].map(|k| view.at(k)), code, origin, direction)
            })
        });
        quads.reduce(nearer)
    };
    (0..rows).filter_map(of).collect()
}

/// The nearer one; equal distances go to the lower code.
pub fn nearer<T: Real>(a: Candidate<T>, b: Candidate<T>) -> Candidate<T> {
    if a.distance < b.distance || (a.distance == b.distance && a.code <= b.code) { a } else { b }
}

/// After T. Moeller and B. Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", 1997, from both sides.
pub fn meet<T: Real>(corners: [V3<T>; 3], code: u32, origin: V3<T>, d: V3<T>) -> Option<Candidate<T>> {
    let [a, b, c] = corners;
    let (e, f, s) = (sub(b, a), sub(c, a), sub(origin, a));
    let h = cross(d, f);
    let det = dot(e, h);
    if det == T::of(0.0) {
        return None;
    }
    let over = T::of(1.0) / det;
    let v = dot(s, h) * over;
    let q = cross(s, e);
    let (w, t) = (dot(d, q) * over, dot(f, q) * over);
    let (zero, edge) = (T::of(0.0), T::of(EDGE));
    // Written so that no number is outside too.
    let met = v >= -edge && w >= -edge && v + w <= T::of(1.0) + edge && t >= zero && t < T::of(3.4e38);
    met.then(|| Candidate { distance: t.abs(), code, weights: [v, w] })
}
