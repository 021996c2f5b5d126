//! Twin of shaders/backstop.wgsl: no particle is in the sphere behind it.
//!
//! As the backstops of Unreal's Chaos Cloth (distance and radius) and the separation constraints of NvCloth (centre and radius of the
//! sphere). Those take the normal of the animated mesh in each frame; here the centre is skinned by the joints of its particle, which is
//! the same where these move alike, and one row per particle as for limits.

use super::limit::{self, Hold, Limit};
use crate::cloth::Cloth;
use crate::cpu::rows::Threads;
use crate::cpu::sheet::Sheet;
use crate::memory::Tally;
use crate::number::lanes::Machine;
use crate::number::real::{Real, V3};

/// The backstops of a sheet.
pub struct Backstop<T: Real> {
    /// Centres of the spheres as targets, their radii as limits.
    spheres: Limit<T>,
    /// Centres at rest \[m\] of the texels that have one, in order.
    pub rest: Vec<[f32; 3]>,
}

impl<T: Real> Backstop<T> {
    /// From the sphere of each texel: centre \[m\] and radius \[m\], below 0 for none.
    fn new(sheet: &Sheet<T>, of: impl Fn(usize) -> [f32; 4]) -> Self {
        let spheres = Limit::new(sheet, |k| {
            let [x, y, z, radius] = of(k);
            ([x, y, z], radius)
        });
        let rest = spheres.limited.iter().map(|k| of(*k as usize)).map(|[x, y, z, _]| [x, y, z]).collect();
        Backstop { spheres, rest }
    }

    /// Puts the spheres elsewhere.
    pub fn aim(&mut self, sheet: &Sheet<T>, of: impl Fn(usize) -> [f32; 4]) {
        self.spheres = Backstop::new(sheet, of).spheres;
    }

    /// Other centres \[m\], in the order of `rest`, each on its way there at `rate` \[1/s\].
    pub fn lead(&mut self, sheet: &Sheet<T>, ends: &[V3<T>], rate: T) {
        self.spheres.lead(sheet, ends, rate);
    }

    /// The texels of the sheet that have one.
    pub fn texels(&self) -> &[u32] {
        &self.spheres.limited
    }

    /// Numbers that it takes.
    pub fn tally(&self, tally: &mut Tally) {
        self.spheres.tally(tally);
        tally.state(&self.rest);
    }
}

/// Those of a cloth at rest; empty for cloth without backstops.
pub fn backstops<T: Real>(cloth: &Cloth, sheets: &[Sheet<T>]) -> Vec<Backstop<T>> {
    let spheres = cloth.spheres();
    if spheres.is_empty() {
        return Vec::new();
    }
    let firsts = cloth.grids().iter().map(|grid| grid.first as usize);
    sheets.iter().zip(firsts).map(|(sheet, first)| Backstop::new(sheet, |k| spheres[first + k])).collect()
}

/// Pushes every particle out of its sphere, with `left` \[s\] of the frame to go after the step.
pub fn run<T: Real>(threads: &Threads, sheet: &mut Sheet<T>, backstop: &Backstop<T>, left: T) {
    limit::run_with::<T, Outside>(threads, sheet, &backstop.spheres, left);
}

/// At least the radius.
struct Outside;

impl Hold for Outside {
    #[inline(always)]
    fn hold<T: Real, K: Machine<T>>(k: K, p: [&mut [T]; 3], at: usize, to: [K::V; 3], limits: (K::V, K::V)) {
        keep_out(k, p, at, to, limits);
    }
}

/// Pushes the free particles of a vector, at `at`, out of spheres around `to`; a radius of `f32::MAX` means none.
#[inline(always)]
fn keep_out<T: Real, K: Machine<T>>(
    k: K,
    [x, y, z]: [&mut [T]; 3],
    at: usize,
    to: [K::V; 3],
    (w, radius): (K::V, K::V),
) {
    let (zero, least) = (k.splat(T::of(0.0)), k.splat(T::of(1e-30)));
    let none = k.splat(T::of(f64::from(f32::MAX)));
    let p = [k.load(x, at), k.load(y, at), k.load(z, at)];
    let d = [k.sub(p[0], to[0]), k.sub(p[1], to[1]), k.sub(p[2], to[2])];
    let radius = k.choose(k.above(w, zero), k.choose(k.above(none, radius), radius, zero), zero);
    let far = k.sqrt(k.squares(d));
    let inside = k.above(radius, far);
    if !k.any(inside) {
        return;
    }
    let keep = k.div(radius, k.most(far, least));
    k.store(x, at, k.choose(inside, k.add(to[0], k.mul(d[0], keep)), p[0]));
    k.store(y, at, k.choose(inside, k.add(to[1], k.mul(d[1], keep)), p[1]));
    k.store(z, at, k.choose(inside, k.add(to[2], k.mul(d[2], keep)), p[2]));
}
