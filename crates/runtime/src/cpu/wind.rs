//! Twin of shaders/wind.wgsl: what air does to the triangles around each particle.

use super::facets::{self, Facets, Planes, Texels};
use super::neighbours::View;
use super::rows::Threads;
use super::sheet::Sheet;
use crate::number::lanes::Machine;
use crate::number::real::{Real, V3, add, cross, dot, scale, sub, with_w, xyz};
use crate::step::Step;

/// The smallest product of squares whose root is computed; the force of a smaller one is negligible.
const TINY: f64 = 1e-36;

/// A third of a triangle's force is each corner's. Half of its cross product is its area, and a third of the sum of the flows past its
/// corners the flow past it, which force is a square of.
const SHARE: f64 = 1.0 / 54.0;

/// Writes the acceleration of each particle by a third of the force on each of its triangles, from positions now and one step before and
/// the velocities of the air, none for the same everywhere.
pub fn run<T: Real>(
    threads: &Threads,
    step: &Step<T>,
    view: View<T>,
    [before, airs]: [&[[T; 4]]; 2],
    field: &mut [[T; 4]],
) {
    let alone = |i, j| alone(step, view, [before, airs], (i, j));
    facets::run(threads, Forces { step }, Texels { view, before, airs, alone }, field);
}

/// The same for a sheet without gaps and holes; velocities and the field lie as [`Sheet::now`].
pub fn of_sheet<T: Real>(threads: &Threads, step: &Step<T>, sheet: &Sheet<T>, airs: &[T], field: &mut [T]) {
    facets::run(threads, Forces { step }, Planes { sheet, airs }, field);
}

/// Forces \[N\] on triangles, 18 times as large.
#[derive(Clone, Copy)]
struct Forces<'a, T> {
    step: &'a Step<T>,
}

impl<T: Real> Facets<T> for Forces<'_, T> {
    const CORNERS: bool = true;

    /// The velocity of the air at a particle.
    #[inline(always)]
    fn corner<K: Machine<T>>(&self, k: K, now: [K::V; 3], before: [K::V; 3], air: Option<[K::V; 3]>) -> [K::V; 3] {
        let air = air.unwrap_or(k.splats(self.step.wind));
        k.minus(air, k.times(k.minus(now, before), k.splat(self.step.rate)))
    }

    #[inline(always)]
    fn quad<K: Machine<T>>(&self, k: K, [p, q, r, s]: [[K::V; 3]; 4], corners: [[K::V; 3]; 4]) -> [[K::V; 3]; 2] {
        let across = k.minus(r, p);
        let areas = [k.cross(k.minus(q, p), across), k.cross(across, k.minus(s, p))];
        let both = k.plus(corners[0], corners[2]);
        let flows = [k.plus(both, corners[1]), k.plus(both, corners[3])];
        let squares = [k.squares(flows[0]), k.squares(flows[1])];
        let roots = [root(k, squares[0], areas[0]), root(k, squares[1], areas[1])];
        // One division for both.
        let over = k.div(k.splat(T::of(1.0)), k.mul(roots[0], roots[1]));
        [
            forces(k, self.step, (areas[0], flows[0]), (squares[0], k.mul(over, roots[1]))),
            forces(k, self.step, (areas[1], flows[1]), (squares[1], k.mul(over, roots[0]))),
        ]
    }

    #[inline(always)]
    fn particle<K: Machine<T>>(&self, k: K, sum: [K::V; 3], w: K::V) -> [K::V; 4] {
        let [x, y, z] = k.times(sum, k.mul(w, k.splat(T::of(SHARE))));
        [x, y, z, k.splat(T::of(0.0))]
    }
}

/// The acceleration of the particle (i, j), by its own triangles.
fn alone<T: Real>(step: &Step<T>, view: View<T>, [before, airs]: [&[[T; 4]]; 2], (i, j): (usize, usize)) -> [T; 4] {
    let (k, zero) = (j * view.width + i, T::of(0.0));
    let mut sum = [zero; 3];
    if view.now[k][3] > zero {
        let air = |k: usize| airs.get(k).map_or(step.wind, |air| xyz(*air));
        let flow = |k: usize| sub(air(k), scale(sub(view.at(k), xyz(before[k])), step.rate));
        let (at, own) = (view.at(k), flow(k));
        view.triangles(i, j, |a, b| {
            let area = cross(sub(view.at(a), at), sub(view.at(b), at));
            sum = add(sum, force(step, area, add(add(own, flow(a)), flow(b))));
        });
    }
    with_w(scale(sum, view.now[k][3].max(zero) * T::of(SHARE)), zero)
}

/// Force \[N\] of air on a triangle, 18 times as large, from twice its area as a vector across it, and three times the velocity of the air
/// that passes it: drag along that, lift across it in the plane of it and the normal, both as the area that the triangle shows to the wind.
///
/// With A twice the area, v the flow and f = A.v, (v x n) x v / |v| = (n |v|^2 - v (n.v)) / |v|, on the side that the air goes to, times
/// |f| is (A |v|^2 - v f) f / (|A| |v|).
fn force<T: Real>(step: &Step<T>, area: V3<T>, flow: V3<T>) -> V3<T> {
    let (facing, square) = (dot(area, flow), dot(flow, flow));
    let root = (square * dot(area, area)).max(T::of(TINY)).sqrt();
    let lift = facing * (step.lift / root);
    add(scale(flow, step.drag * facing.abs() - facing * lift), scale(area, square * lift))
}

/// The product of the lengths of a flow, given its square, and of an area.
#[inline(always)]
fn root<T: Real, K: Machine<T>>(k: K, square: K::V, area: [K::V; 3]) -> K::V {
    k.sqrt(k.most(k.mul(square, k.squares(area)), k.splat(T::of(TINY))))
}

/// [`force`] for a vector of triangles, from the square of the flow and one over the root.
#[inline(always)]
fn forces<T: Real, K: Machine<T>>(
    k: K,
    step: &Step<T>,
    (area, flow): ([K::V; 3], [K::V; 3]),
    (square, over): (K::V, K::V),
) -> [K::V; 3] {
    let facing = k.dot(area, flow);
    let lift = k.mul(facing, k.mul(k.splat(step.lift), over));
    let shown = k.most(facing, k.sub(k.splat(T::of(0.0)), facing));
    let along = k.sub(k.mul(k.splat(step.drag), shown), k.mul(facing, lift));
    k.plus(k.times(flow, along), k.times(area, k.mul(square, lift)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloth::Grid;
    use crate::cpu::gust;
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

    /// Velocities of gusts, or none.
    fn airs(step: &Step<f32>, now: &[[f32; 4]], gusts: bool) -> Vec<[f32; 4]> {
        let mut airs = vec![[0.0; 4]; if gusts { now.len() } else { 0 }];
        gust::run(&Threads::one(), step, now, &mut airs);
        airs
    }

    fn texels(step: &Step<f32>, width: usize, now: &[[f32; 4]], others: [&[[f32; 4]]; 2]) -> Vec<[f32; 4]> {
        let mut field = vec![[0.0; 4]; now.len()];
        run(&Threads::one(), step, View { now, width, holes: &[] }, others, &mut field);
        field
    }

    #[test]
    fn planes_and_texels_have_the_same_bits() {
        let sizes = [(2, 2), (3, 9), (16, 16), (33, 18), (67, 23), (64, 70)];
        for ((width, height), gusts) in sizes.into_iter().flat_map(|size| [(size, true), (size, false)]) {
            let (step, now, before) = rippled(width, height);
            let mut sheet =
                Sheet::new(&Grid { name: String::new(), first: 0, width: width as u32, height: height as u32 });
            sheet.load(&now, &before);
            sheet.weigh(|k| now[k][3]);
            let airs = airs(&step, &now, gusts);
            let list = || vec![0.0; sheet.now.len()];
            let (mut planes, mut expected, mut moving) = (list(), list(), if gusts { list() } else { Vec::new() });
            if gusts {
                sheet.arrange(&airs, &mut moving);
            }
            of_sheet(&Threads::one(), &step, &sheet, &moving, &mut planes);
            sheet.arrange(&texels(&step, width, &now, [&before, &airs]), &mut expected);
            for k in 0..width * height {
                let places = [0, 2, 4].map(|c| sheet.triple(k) + c * sheet.half);
                assert_eq!(places.map(|p| planes[p]), places.map(|p| expected[p]), "{width} x {height}, texel {k}");
            }
        }
    }

    #[test]
    fn vectors_sum_what_single_particles_do_with_and_without_gaps() {
        let cases = [(16, usize::MAX), (33, usize::MAX), (33, 5), (20, 11)];
        for ((width, gap), gusts) in cases.into_iter().flat_map(|case| [(case, true), (case, false)]) {
            let (step, mut now, before) = rippled(width, 18);
            for k in (0..now.len()).filter(|k| k % 29 == gap) {
                now[k][3] = -1.0;
            }
            let airs = airs(&step, &now, gusts);
            let field = texels(&step, width, &now, [&before, &airs]);
            let view = View { now: &now[..], width, holes: &[] };
            let most = field.iter().flat_map(|f| &f[..3]).fold(0.0f32, |m, x| m.max(x.abs()));
            assert!(most > 0.0);
            for (k, got) in field.iter().enumerate() {
                let single = alone(&step, view, [&before, &airs], (k % width, k / width));
                let off = (0..3).map(|c| (got[c] - single[c]).abs()).fold(0.0, f32::max);
                assert!(off <= 2e-5 * most, "{width} wide, texel {k}: {got:?} {single:?}");
            }
        }
    }

    #[test]
    fn a_force_is_drag_along_the_flow_and_lift_across_it() {
        let step = Step { drag: 0.54, lift: 0.42, ..Step::default() };
        let length = |v: V3<f64>| dot(v, v).sqrt();
        for (area, v) in [
            ([0.3, -0.2, 0.5], [4.0, 1.0, -2.0]),
            ([0.3, -0.2, 0.5], [-4.0, -1.0, 2.0]),
            ([1e-5, 0.0, 0.0], [3.0, 0.0, 0.0]),
            ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0]),
        ] {
            let n = scale(area, 1.0 / length(area));
            // Half the density times the area that faces the wind, as docs of `WindForce::Triangles` have it, n on the side that the air goes to.
            let facing = dot(area, v).abs();
            let n = if dot(n, v) < 0.0 { scale(n, -1.0) } else { n };
            let across = scale(cross(cross(v, n), v), 1.0 / length(v));
            let expected = scale(add(scale(v, step.drag), scale(across, step.lift)), facing);
            // From twice the area, and three times the flow, 18 times the force.
            let got = scale(force(&step, scale(area, 2.0), scale(v, 3.0)), 1.0 / 18.0);
            assert!(length(sub(got, expected)) <= 1e-12 * (1.0 + length(expected)), "{got:?} {expected:?}");
        }
        // A triangle without an area, and air that does not pass.
        assert_eq!(force(&step, [0.0; 3], [3.0, 0.0, 0.0]), [0.0; 3]);
        assert_eq!(force(&step, [1.0, 0.0, 0.0], [0.0; 3]), [0.0; 3]);
    }
}
