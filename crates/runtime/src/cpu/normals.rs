//! Twin of shaders/normals.wgsl: the normal of every particle.

use super::facets::{self, Facets, Texels};
use super::neighbours::View;
use super::rows::Threads;
use crate::number::lanes::Machine;
use crate::number::real::{Real, V3, add, cross, dot, scale, sub, with_w};

/// Writes the unit sum of the normals of the triangles around each particle, weighed by area, and in the fourth
/// component the length of that sum \[m^2\]: the weight of a duplicate when seams are closed. 0 where there is none.
pub fn run<T: Real>(threads: &Threads, view: View<T>, normals: &mut [[T; 4]]) {
    facets::run(threads, Areas, Texels { view, before: &[], airs: &[], alone: |i, j| alone(view, i, j) }, normals);
}

/// Twice the areas of triangles, as vectors across them.
#[derive(Clone, Copy)]
struct Areas;

impl<T: Real> Facets<T> for Areas {
    const CORNERS: bool = false;

    #[inline(always)]
    fn quad<K: Machine<T>>(&self, k: K, [p, q, r, s]: [[K::V; 3]; 4], _: [[K::V; 3]; 4]) -> [[K::V; 3]; 2] {
        let across = k.minus(r, p);
        [k.cross(k.minus(q, p), across), k.cross(across, k.minus(s, p))]
    }

    #[inline(always)]
    fn particle<K: Machine<T>>(&self, k: K, sum: [K::V; 3], _: K::V) -> [K::V; 4] {
        let (zero, one) = (k.splat(T::of(0.0)), k.splat(T::of(1.0)));
        let length = k.sqrt(k.squares(sum));
        let by = k.choose(k.above(length, zero), k.div(one, length), zero);
        [k.mul(sum[0], by), k.mul(sum[1], by), k.mul(sum[2], by), length]
    }
}

/// That of the particle (i, j), by its own triangles.
fn alone<T: Real>(view: View<T>, i: usize, j: usize) -> [T; 4] {
    let k = j * view.width + i;
    let mut sum = [T::of(0.0); 3];
    if view.now[k][3] >= T::of(0.0) {
        let at = view.at(k);
        view.triangles(i, j, |a, b| sum = add(sum, cross(sub(view.at(a), at), sub(view.at(b), at))));
    }
    unit(sum)
}

/// The direction and the length of a vector.
pub fn unit<T: Real>(v: V3<T>) -> [T; 4] {
    let length = dot(v, v).sqrt();
    if length > T::of(0.0) { with_w(scale(v, T::of(1.0) / length), length) } else { [T::of(0.0); 4] }
}
