//! Twin of shaders/wind.wgsl: what air does to the triangles around each particle.

use super::facets::{self, Facets, Planes, Texels};
use super::gust::{air, airs};
use super::neighbours::View;
use super::rows::Threads;
use super::sheet::Sheet;
use crate::number::lanes::Machine;
use crate::number::noise::LastCell;
use crate::number::real::{Real, V3, add, cross, dot, scale, sub, with_w, xyz};
use crate::step::Step;

/// Writes the acceleration of each particle by a third of the force on each of its triangles.
pub fn run<T: Real>(threads: &Threads, step: &Step<T>, view: View<T>, before: &[[T; 4]], field: &mut [[T; 4]]) {
    let alone = |i, j| alone(step, view, before, (i, j));
    facets::run(threads, Forces { step, last: LastCell::default() }, Texels { view, before, alone }, field);
}

/// The same for a sheet without gaps and holes; the field lies as [`Sheet::now`].
pub fn of_sheet<T: Real>(threads: &Threads, step: &Step<T>, sheet: &Sheet<T>, field: &mut [T]) {
    facets::run(threads, Forces { step, last: LastCell::default() }, Planes(sheet), field);
}

/// Forces \[N\] on triangles.
#[derive(Clone, Copy)]
struct Forces<'a, T> {
    step: &'a Step<T>,
    last: LastCell<T>,
}

impl<T: Real> Facets<T> for Forces<'_, T> {
    #[inline(always)]
    fn facet<K: Machine<T>>(&mut self, k: K, [p, q, r]: [[K::V; 3]; 3], [e, f, g]: [[K::V; 3]; 3]) -> [K::V; 3] {
        let third = k.splat(T::of(1.0 / 3.0));
        let area = k.times(k.cross(k.minus(q, p), k.minus(r, p)), k.splat(T::of(0.5)));
        let middle = k.times(k.plus(k.plus(p, q), r), third);
        let earlier = k.times(k.plus(k.plus(e, f), g), third);
        let moves = k.times(k.minus(middle, earlier), k.splat(self.step.rate));
        forces(k, self.step, area, k.minus(airs(k, self.step, &mut self.last, middle), moves))
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
        let (at, was, mut last) = (view.at(k), xyz(before[k]), LastCell::default());
        view.triangles(i, j, |a, b| {
            let (pa, pb) = (view.at(a), view.at(b));
            let area = scale(cross(sub(pa, at), sub(pb, at)), T::of(0.5));
            let middle = scale(add(add(at, pa), pb), T::of(1.0 / 3.0));
            let earlier = scale(add(add(was, xyz(before[a])), xyz(before[b])), T::of(1.0 / 3.0));
            let flow = sub(air(step, &mut last, middle), scale(sub(middle, earlier), step.rate));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloth::Grid;
    use crate::step::StepInput;
    use crate::wind::{Wind, WindForce};

    /// A rippled sheet in motion, and the numbers of a step in gusts.
    fn rippled(width: usize, height: usize) -> (Step<f32>, Vec<[f32; 4]>, Vec<[f32; 4]>) {
        let force = WindForce::Triangles { density: 1.2, drag: 0.9, lift: 0.7 };
        let wind = Wind { velocity: [4.0, 0.5, -2.0], gust: 0.8, gust_size: 0.13, force };
        let (gravity, dt) = ([0.0, -9.81, 0.0], 1.0 / 960.0);
        let step = StepInput { gravity, wind: Some(&wind), damping: 0.1, speed_limit: 50.0, dt, dt_old: dt, time: 1.3 };
        let at = |k: usize, t: f32| {
            let (x, y) = ((k % width) as f32, (k / width) as f32);
            [0.02 * x, -0.02 * y, 0.03 * (0.7 * x + 0.4 * y + t).sin(), if k % 7 == 3 { 0.0 } else { 1.0 + 0.1 * y }]
        };
        let all = |t| (0..width * height).map(|k| at(k, t)).collect();
        (Step::new(&step).cast(), all(0.02), all(0.0))
    }

    fn texels(step: &Step<f32>, width: usize, now: &[[f32; 4]], before: &[[f32; 4]]) -> Vec<[f32; 4]> {
        let mut field = vec![[0.0; 4]; now.len()];
        run(&Threads::one(), step, View { now, width, holes: &[] }, before, &mut field);
        field
    }

    #[test]
    fn planes_and_texels_have_the_same_bits() {
        for (width, height) in [(2, 2), (3, 9), (16, 16), (33, 18), (67, 23)] {
            let (step, now, before) = rippled(width, height);
            let mut sheet =
                Sheet::new(&Grid { name: String::new(), first: 0, width: width as u32, height: height as u32 });
            sheet.load(&now, &before);
            sheet.weigh(|k| now[k][3]);
            let (mut planes, mut expected) = (vec![0.0; sheet.now.len()], vec![0.0; sheet.now.len()]);
            of_sheet(&Threads::one(), &step, &sheet, &mut planes);
            sheet.arrange(&texels(&step, width, &now, &before), &mut expected);
            for k in 0..width * height {
                let places = [0, 2, 4].map(|c| sheet.triple(k) + c * sheet.half);
                assert_eq!(places.map(|p| planes[p]), places.map(|p| expected[p]), "{width} x {height}, texel {k}");
            }
        }
    }

    #[test]
    fn vectors_sum_what_single_particles_do_with_and_without_gaps() {
        for (width, gap) in [(16, usize::MAX), (33, usize::MAX), (33, 5), (20, 11)] {
            let (step, mut now, before) = rippled(width, 18);
            for k in (0..now.len()).filter(|k| k % 29 == gap) {
                now[k][3] = -1.0;
            }
            let field = texels(&step, width, &now, &before);
            let view = View { now: &now[..], width, holes: &[] };
            let most = field.iter().flat_map(|f| &f[..3]).fold(0.0f32, |m, x| m.max(x.abs()));
            assert!(most > 0.0);
            for (k, got) in field.iter().enumerate() {
                let single = alone(&step, view, &before, (k % width, k / width));
                let off = (0..3).map(|c| (got[c] - single[c]).abs()).fold(0.0, f32::max);
                assert!(off <= 2e-5 * most, "{width} wide, texel {k}: {got:?} {single:?}");
            }
        }
    }
}
