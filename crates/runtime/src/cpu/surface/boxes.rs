//! Twin of shaders/surface_boxes.wgsl: boxes around the patches of a surface, and their middles, at the start of a frame. Boxes are made where a search
//! needs them.

use super::passing::Passing;
use super::pose::Skinned;
use crate::cloth::surface::{BodySurface, Bound, apart, on_triangle};
use crate::number::lanes::{Machine, Work, widest};
use crate::number::real::{Real, V3};

/// Boxes and middles of all patches \[m\].
pub struct Boxes<T: Real> {
    bounds: Vec<Bound<T>>,
    /// The frame of which the boxes are.
    fitted: u32,
    passing: Passing<T>,
}

impl<T: Real> Boxes<T> {
    /// For a surface.
    pub fn new(surface: &BodySurface) -> Self {
        Boxes { bounds: Vec::new(), fitted: 0, passing: Passing::new(surface) }
    }

    /// Moves the middles to where they are.
    pub fn follow(&mut self, surface: &BodySurface, skinned: &mut Skinned<T>) {
        self.passing.follow(surface.middles.iter().map(|t| skinned.vertex(surface.triangles[*t as usize][0]).at));
    }

    /// The patch that comes to a particle at `p` in a frame in which the surface moves, if one does: [`Passing::nearest`].
    pub fn passes(&self, skinned: &Skinned<T>, p: V3<T>, goes: V3<T>, may_be_fast: bool) -> Option<u32> {
        if skinned.moves() { self.passing.nearest(p, goes, may_be_fast) } else { None }
    }

    /// The patch with the middle nearest to `p`.
    pub fn patch(&self, p: V3<T>) -> usize {
        nearest_of(self.passing.middles(), p)
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
        let (mut least, mut block) = (far, k.splat(T::of(-1.0)));
        for at in (0..self.points[0].len()).step_by(K::WIDE) {
            let d = k.squares(k.minus(k.loads(self.points, at), p));
            let nearer = k.above(least, d);
            least = k.choose(nearer, d, least);
            block = k.choose(nearer, k.splat(T::of(at as f64)), block);
        }
        *self.found = k.first_least(least, block).unwrap_or(0);
    }
}
