//! Twin of shaders/surface_boxes.wgsl: boxes around the patches of a surface, and their middles, at the start of a frame. Boxes are made where a search
//! needs them.

use super::passing::Passing;
use super::pose::Skinned;
use crate::cloth::surface::{BodySurface, Bound, apart, on_triangle};
use crate::number::lanes::{LANES, Machine, Work, widest};
use crate::number::real::{Real, V3};

/// Boxes and middles of all patches \[m\].
pub struct Boxes<T: Real> {
    bounds: Vec<Bound<T>>,
    /// The frame of which the boxes are.
    fitted: u32,
    /// A vertex in the middle of each patch; padded to whole blocks.
    middles: [Vec<T>; 3],
    passing: Passing<T>,
}

impl<T: Real> Boxes<T> {
    /// For a surface.
    pub fn new(surface: &BodySurface) -> Self {
        let far = T::of(f64::from(f32::MAX.sqrt()));
        let middles = [0, 1, 2].map(|_| vec![far; surface.middles.len().next_multiple_of(LANES)]);
        Boxes { bounds: Vec::new(), fitted: 0, middles, passing: Passing::new(surface) }
    }

    /// Moves the middles to where they are.
    pub fn follow(&mut self, surface: &BodySurface, skinned: &mut Skinned<T>) {
        for (n, t) in surface.middles.iter().enumerate() {
            let [from, _] = skinned.vertices(surface, *t)[0].at;
            (0..3).for_each(|c| self.middles[c][n] = from[c]);
        }
        if skinned.moves() {
            self.passing.follow(surface.middles.iter().map(|t| skinned.vertices(surface, *t)[0].at));
        }
    }

    /// The patch that comes to a particle at `p` in a frame in which the surface moves, if one does: [`Passing::nearest`].
    pub fn passes(&self, skinned: &Skinned<T>, p: V3<T>, goes: V3<T>, may_be_fast: bool) -> Option<u32> {
        if skinned.moves() { self.passing.nearest(p, goes, may_be_fast) } else { None }
    }

    /// The patch with the middle nearest to `p`.
    pub fn patch(&self, p: V3<T>) -> usize {
        nearest_of(&self.middles, p)
    }

    /// The triangle nearest to `p`, by the boxes that may have it.
    pub fn search(&mut self, surface: &BodySurface, skinned: &mut Skinned<T>, p: V3<T>) -> u32 {
        if self.fitted != skinned.frame() {
            self.fit(surface, skinned);
        }
        let (mut first, mut far) = (0, T::of(f64::from(f32::MAX)));
        for (n, bound) in self.bounds.iter().enumerate() {
            let d = apart(bound, p);
            if d < far {
                (first, far) = (n, d);
            }
        }
        let mut best = (surface.of_patch(first)[0], T::of(f64::from(f32::MAX)));
        let mut take = |n: usize, best: &mut (u32, T)| {
            for t in surface.of_patch(n) {
                let d = on_triangle(p, *t, skinned.corners(surface, *t)).distance2;
                if d < best.1 {
                    *best = (*t, d);
                }
            }
        };
        take(first, &mut best);
        for n in 0..self.bounds.len() {
            if n != first && apart(&self.bounds[n], p) < best.1 {
                take(n, &mut best);
            }
        }
        best.0
    }

    fn fit(&mut self, surface: &BodySurface, skinned: &mut Skinned<T>) {
        self.fitted = skinned.frame();
        self.bounds.clear();
        for n in 0..surface.middles.len() {
            let most = T::of(f64::from(f32::MAX));
            let mut own = [[most; 3], [T::of(0.0) - most; 3]];
            for p in surface.of_patch(n).iter().flat_map(|t| skinned.corners(surface, *t)) {
                for c in 0..3 {
                    (own[0][c], own[1][c]) = (own[0][c].min(p[c]), own[1][c].max(p[c]));
                }
            }
            self.bounds.push(own);
        }
    }
}

/// The first of the points nearest to `p`.
pub fn nearest_of<T: Real>(points: &[Vec<T>; 3], p: V3<T>) -> usize {
    let mut found = 0;
    widest(NearestOf { points, p, found: &mut found });
    found
}

struct NearestOf<'a, T> {
    points: &'a [Vec<T>; 3],
    p: V3<T>,
    found: &'a mut usize,
}

impl<T: Real> Work<T> for NearestOf<'_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let p = k.splats(self.p);
        let far = k.splat(T::of(f64::from(f32::MAX)));
        let (mut least, mut block) = (far, far);
        for at in (0..self.points[0].len()).step_by(K::WIDE) {
            let d = k.squares(k.minus(k.loads(self.points, at), p));
            let nearer = k.above(least, d);
            least = k.choose(nearer, d, least);
            block = k.choose(nearer, k.splat(T::of(at as f64)), block);
        }
        let mut lanes = [[T::of(0.0); LANES]; 2];
        k.store(&mut lanes[0], 0, least);
        k.store(&mut lanes[1], 0, block);
        // The first of those that are equally far, whatever the width of vectors.
        let mut best = (T::of(f64::from(f32::MAX)), T::of(0.0));
        for (lane, (d, at)) in lanes[0].iter().zip(&lanes[1]).take(K::WIDE).enumerate() {
            let (d, at) = (*d, *at + T::of(lane as f64));
            if d < best.0 || (d == best.0 && at < best.1) {
                best = (d, at);
            }
        }
        *self.found = best.1.get() as usize;
    }
}
