//! The patch that comes nearest to a particle in a frame: a heel that goes by below a cape is far from it at the start of the frame, and may be far at its end.

use crate::cloth::surface::BodySurface;
use crate::number::lanes::{LANES, Machine, Work, widest};
use crate::number::real::{Real, V3, add, dot};

/// A patch or a particle that goes farther \[m\] in a frame than this is fast.
pub const FAST_WAY_M: f64 = 0.02;
/// A patch comes nearer to a particle by more than this \[m\], or the particle has known it before.
pub const NEARER_M: f64 = 0.01;

/// Patches, by the places of their middles.
struct Patches<T> {
    /// Middles \[m\] at the start of a frame, and how they go in it; padded to whole blocks.
    from: [Vec<T>; 3],
    way: [Vec<T>; 3],
    /// One over the squares of the distances \[m\] at which they pass near.
    reach: Vec<T>,
    /// Their numbers.
    patch: Vec<u32>,
}

impl<T: Real> Patches<T> {
    fn new() -> Self {
        let list = || [Vec::new(), Vec::new(), Vec::new()];
        Patches { from: list(), way: list(), reach: Vec::new(), patch: Vec::new() }
    }

    fn clear(&mut self) {
        self.from.iter_mut().chain(&mut self.way).for_each(Vec::clear);
        self.reach.clear();
        self.patch.clear();
    }

    fn push(&mut self, patch: usize, [from, way]: [V3<T>; 2], reach: T) {
        for c in 0..3 {
            self.from[c].push(from[c]);
            self.way[c].push(way[c]);
        }
        self.reach.push(reach);
        self.patch.push(patch as u32);
    }

    /// To whole blocks, by patches that never pass.
    fn fill(&mut self) {
        let (len, far) = (self.patch.len().next_multiple_of(LANES), T::of(f64::from(f32::MAX.sqrt() / 4.0)));
        self.from.iter_mut().for_each(|list| list.resize(len, far));
        self.way.iter_mut().for_each(|list| list.resize(len, T::of(0.0)));
        self.reach.resize(len, T::of(1.0));
    }
}

/// How the patches of a surface go in a frame.
pub struct Passing<T: Real> {
    /// One over the squares of the distances \[m\] at which they pass near.
    reach: Vec<T>,
    all: Patches<T>,
    fast: Patches<T>,
    /// The box around all that the fast ones may come near to \[m\].
    low: V3<T>,
    high: V3<T>,
}

impl<T: Real> Passing<T> {
    /// For a surface.
    pub fn new(surface: &BodySurface) -> Self {
        let reach = (0..surface.patches()).map(|n| T::of(surface.reach(n))).collect();
        let zero = [T::of(0.0); 3];
        Passing { reach, all: Patches::new(), fast: Patches::new(), low: zero, high: zero }
    }

    /// Takes the patches, by where the middle of each is at the start and at the end of the frame.
    pub fn follow(&mut self, middles: impl Iterator<Item = [V3<T>; 2]>) {
        let far = T::of(f64::from(f32::MAX));
        (self.low, self.high) = ([far; 3], [T::of(0.0) - far; 3]);
        self.all.clear();
        self.fast.clear();
        for (n, [from, to]) in middles.enumerate() {
            let (way, reach) = ([0, 1, 2].map(|c| to[c] - from[c]), self.reach[n]);
            self.all.push(n, [from, way], reach);
            if dot(way, way) <= T::of(FAST_WAY_M * FAST_WAY_M) {
                continue;
            }
            self.fast.push(n, [from, way], reach);
            let near = T::of(1.0) / reach.sqrt();
            for c in 0..3 {
                self.low[c] = self.low[c].min(from[c].min(to[c]) - near);
                self.high[c] = self.high[c].max(from[c].max(to[c]) + near);
            }
        }
        self.all.fill();
        self.fast.fill();
    }

    /// A vertex in the middle of each patch \[m\] at the start of the frame; padded to whole blocks.
    pub fn middles(&self) -> &[Vec<T>; 3] {
        &self.all.from
    }

    /// The patch that passes nearest to a particle at `p` that goes on by `goes`, measured by its extent, if one passes near: a fast one, or any if `may_be_fast` and the particle is fast.
    pub fn nearest(&self, p: V3<T>, goes: V3<T>, may_be_fast: bool) -> Option<u32> {
        let is_fast = may_be_fast && dot(goes, goes) > T::of(FAST_WAY_M * FAST_WAY_M);
        let to = add(p, goes);
        let misses = |c: usize| p[c].min(to[c]) > self.high[c] || p[c].max(to[c]) < self.low[c];
        if !is_fast && (0..3).any(misses) {
            return None;
        }
        let patches = if is_fast { &self.all } else { &self.fast };
        let mut found = None;
        widest(Nearest { patches, p, goes, found: &mut found });
        found.map(|at| patches.patch[at])
    }
}

struct Nearest<'a, T> {
    patches: &'a Patches<T>,
    p: V3<T>,
    goes: V3<T>,
    found: &'a mut Option<usize>,
}

impl<T: Real> Work<T> for Nearest<'_, T> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let (p, goes) = (k.splats(self.p), k.splats(self.goes));
        let (zero, one) = (k.splat(T::of(0.0)), k.splat(T::of(1.0)));
        let (tiny, nearer) = (k.splat(T::of(1e-12)), k.splat(T::of(NEARER_M)));
        let (mut least, mut block) = (one, k.splat(T::of(-1.0)));
        for at in (0..self.patches.reach.len()).step_by(K::WIDE) {
            let off = k.minus(k.loads(&self.patches.from, at), p);
            let way = k.minus(k.loads(&self.patches.way, at), goes);
            let along = k.sub(zero, k.dot(off, way));
            let time = k.least(k.most(k.div(along, k.most(k.squares(way), tiny)), zero), one);
            let d = k.squares(k.plus(off, k.times(way, time)));
            let comes = k.above(k.sqrt(k.squares(off)), k.add(k.sqrt(d), nearer));
            let d = k.mul(d, k.load(&self.patches.reach, at));
            let first = k.both(comes, k.above(least, d));
            least = k.choose(first, d, least);
            block = k.choose(first, k.splat(T::of(at as f64)), block);
        }
        *self.found = k.first_least(least, block);
    }
}
