//! Twin of shaders/normals.wgsl: the normal of every particle.

use super::neighbours::View;
use super::rows::Threads;
use crate::number::real::{Real, V3, add, cross, dot, scale, sub, with_w};

/// Writes the unit sum of the normals of the triangles around each particle, weighed by area, and in the fourth
/// component the length of that sum \[m^2\]: the weight of a duplicate when seams are closed. 0 where there is none.
pub fn run<T: Real>(threads: &Threads, view: View<T>, normals: &mut [[T; 4]]) {
    threads.chunks(normals, view.width, |j, row| {
        for (i, normal) in row.iter_mut().enumerate() {
            let k = j * view.width + i;
            let mut sum = [T::of(0.0); 3];
            if view.now[k][3] >= T::of(0.0) {
                let at = view.at(k);
                view.triangles(i, j, |a, b| sum = add(sum, cross(sub(view.at(a), at), sub(view.at(b), at))));
            }
            *normal = unit(sum);
        }
    });
}

/// The direction and the length of a vector.
pub fn unit<T: Real>(v: V3<T>) -> [T; 4] {
    let length = dot(v, v).sqrt();
    if length > T::of(0.0) { with_w(scale(v, T::of(1.0) / length), length) } else { [T::of(0.0); 4] }
}
