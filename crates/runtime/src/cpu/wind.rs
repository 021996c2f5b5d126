//! Twin of shaders/wind.wgsl: what air does to the triangles around each particle.

use super::gust::air;
use super::neighbours::View;
use super::rows::Threads;
use crate::number::real::{Real, V3, add, cross, dot, scale, sub, with_w, xyz};
use crate::step::Step;

/// Writes the acceleration of each particle by a third of the force on each of its triangles.
pub fn run<T: Real>(threads: &Threads, step: &Step<T>, view: View<T>, before: &[[T; 4]], field: &mut [[T; 4]]) {
    let zero = T::of(0.0);
    threads.chunks(field, view.width, |j, row| {
        for (i, out) in row.iter_mut().enumerate() {
            let k = j * view.width + i;
            let mut sum = [zero; 3];
            if view.now[k][3] > zero {
                let (at, was) = (view.at(k), xyz(before[k]));
                view.triangles(i, j, |a, b| {
                    let (pa, pb) = (view.at(a), view.at(b));
                    let area = scale(cross(sub(pa, at), sub(pb, at)), T::of(0.5));
                    let middle = scale(add(add(at, pa), pb), T::of(1.0 / 3.0));
                    let earlier = scale(add(add(was, xyz(before[a])), xyz(before[b])), T::of(1.0 / 3.0));
                    let flow = sub(air(step, middle), scale(sub(middle, earlier), step.rate));
                    sum = add(sum, force(step, area, flow));
                });
            }
            *out = with_w(scale(sum, view.now[k][3].max(zero) * T::of(1.0 / 3.0)), zero);
        }
    });
}

/// Force \[N\] of air that passes a triangle with the velocity `v`: drag along it, lift across it in the plane of v and
/// the normal, both as the area that the triangle shows to the wind.
fn force<T: Real>(step: &Step<T>, area: V3<T>, v: V3<T>) -> V3<T> {
    let speed = dot(v, v).sqrt().max(T::of(1e-9));
    let size = dot(area, area).sqrt().max(T::of(1e-18));
    let facing = dot(area, v);
    // (v x n) x v / |v| = (n |v|^2 - v (n.v)) / |v|; |facing| has the area in it, the normal only the direction.
    let across = scale(sub(scale(area, speed * speed), scale(v, facing)), T::of(1.0) / (speed * size));
    let sign = if facing < T::of(0.0) { T::of(-1.0) } else { T::of(1.0) };
    scale(add(scale(v, step.drag), scale(across, step.lift * sign)), facing.abs())
}
