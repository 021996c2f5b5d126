//! Twin of shaders/wind.wgsl: what air does to the triangles around each particle.

use super::facets::{self, Facets, Planes, Texels};
use super::gust::{air, airs};
use super::neighbours::View;
use super::rows::Threads;
use super::sheet::Sheet;
use crate::number::lanes::Machine;
use crate::number::noise::Around;
use crate::number::real::{Real, V3, add, cross, dot, scale, sub, with_w, xyz};
use crate::step::Step;

/// Writes the acceleration of each particle by a third of the force on each of its triangles.
pub fn run<T: Real>(threads: &Threads, step: &Step<T>, view: View<T>, before: &[[T; 4]], field: &mut [[T; 4]]) {
    let alone = |i, j| alone(step, view, before, (i, j));
    facets::run(threads, Forces { step, around: Around::default() }, Texels { view, before, alone }, field);
}

/// The same for a sheet without gaps and holes; the field lies as [`Sheet::now`].
pub fn of_sheet<T: Real>(threads: &Threads, step: &Step<T>, sheet: &Sheet<T>, field: &mut [T]) {
    facets::run(threads, Forces { step, around: Around::default() }, Planes(sheet), field);
}

/// Forces \[N\] on triangles.
#[derive(Clone, Copy)]
struct Forces<'a, T> {
    step: &'a Step<T>,
    around: Around<T>,
}

impl<T: Real> Facets<T> for Forces<'_, T> {
    #[inline(always)]
    fn facet<K: Machine<T>>(&mut self, k: K, [p, q, r]: [[K::V; 3]; 3], [e, f, g]: [[K::V; 3]; 3]) -> [K::V; 3] {
        let third = k.splat(T::of(1.0 / 3.0));
        let area = k.times(k.cross(k.minus(q, p), k.minus(r, p)), k.splat(T::of(0.5)));
        let middle = k.times(k.plus(k.plus(p, q), r), third);
        let earlier = k.times(k.plus(k.plus(e, f), g), third);
        let moves = k.times(k.minus(middle, earlier), k.splat(self.step.rate));
        forces(k, self.step, area, k.minus(airs(k, self.step, &mut self.around, middle), moves))
    }

    #[inline(always)]
    fn particle<K: Machine<T>>(&self, k: K, sum: [K::V; 3], w: K::V) -> [K::V; 4] {
        let [x, y, z] = k.times(sum, k.mul(w, k.splat(T::of(1.0 / 3.0))));
        [x, y, z, k.splat(T::of(0.0))]
    }
}

/// The acceleration of the particle (i, j), by its own triangles.
fn alone<T: Real>(step: &Step<T>, view: View<T>, before: &[[T; 4]], (i, j): (usize, usize)) -> [T; 4] {
    let (k, zero) = (j * view.width + i, T::of(0.0));
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
    with_w(scale(sum, view.now[k][3].max(zero) * T::of(1.0 / 3.0)), zero)
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

/// The same for a vector of triangles.
#[inline(always)]
fn forces<T: Real, K: Machine<T>>(k: K, step: &Step<T>, area: [K::V; 3], v: [K::V; 3]) -> [K::V; 3] {
    let (zero, one, lift) = (k.splat(T::of(0.0)), k.splat(T::of(1.0)), k.splat(step.lift));
    let speed = k.most(k.sqrt(k.squares(v)), k.splat(T::of(1e-9)));
    let size = k.most(k.sqrt(k.squares(area)), k.splat(T::of(1e-18)));
    let facing = k.dot(area, v);
    let over = k.div(one, k.mul(speed, size));
    let across = k.times(k.minus(k.times(area, k.mul(speed, speed)), k.times(v, facing)), over);
    let back = k.above(zero, facing);
    let lift = k.choose(back, k.sub(zero, lift), lift);
    let shown = k.choose(back, k.sub(zero, facing), facing);
    k.times(k.plus(k.times(v, k.splat(step.drag)), k.times(across, lift)), shown)
}
