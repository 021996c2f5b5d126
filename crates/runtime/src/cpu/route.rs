//! The shortest way to what holds a particle, by way of the particles around it. Twin of shaders/part/route.wgsl.

use crate::cloth::{Bridges, Cloth, Grid, Tethers, groups, mates, ring};
use crate::number::real::Real;

/// Pins that hold each particle of a cloth that is cut, in slots, by texels.
pub struct Held<T> {
    grids: Vec<Grid>,
    /// The next duplicate of every texel.
    mates: Vec<u32>,
    bridges: Bridges,
    /// Tethers per particle.
    pub slots: usize,
    /// By particle and slot: a group of pins, any of which will do.
    pub groups: Vec<u32>,
    /// The pin; `u32::MAX` where there is none.
    pub anchors: Vec<u32>,
    /// Largest distance \[m\]; that of [`far`] where no pin can be reached any more.
    pub most: Vec<T>,
}

/// A distance that nothing reaches.
pub fn far<T: Real>() -> T {
    T::of(f64::from(f32::MAX))
}

/// A way that is longer than a tether by less than this share is the same: rounding.
const SAME: f64 = 1.0 + 1e-4;

/// No particle is nearer.
pub const UNSUPPORTED: u32 = u32::MAX - 1;

/// Right, down-right, down, down-left, left, up-left, up, up-right; the place of the spring there in the texel that
/// stores it, which is the neighbour for the fourth to the seventh.
const CIRCLE: [(isize, isize, usize); 8] =
    [(1, 0, 0), (1, 1, 2), (0, 1, 1), (-1, 1, 3), (-1, 0, 0), (-1, -1, 2), (0, -1, 1), (1, -1, 3)];

/// The triangles around a texel, each quad split both ways: two of [`CIRCLE`], and the spring between them as the one of
/// the two that stores it and its place there.
const TRIANGLES: [[usize; 4]; 12] = [
    [0, 1, 0, 1],
    [1, 2, 2, 0],
    [0, 2, 2, 3],
    [2, 3, 3, 0],
    [3, 4, 4, 1],
    [2, 4, 4, 2],
    [4, 5, 5, 1],
    [5, 6, 5, 0],
    [4, 6, 4, 3],
    [6, 7, 6, 0],
    [7, 0, 7, 1],
    [6, 0, 6, 2],
];

/// One of the circle: the texel, the spring to it (0 for none), and how far it is from which pin of a group.
#[derive(Clone, Copy)]
struct Near<T> {
    texel: usize,
    length: T,
    far: T,
    anchor: u32,
}

impl<T: Real> Held<T> {
    /// From the tethers of a cloth that is to be cut.
    pub fn new(cloth: &Cloth, tethers: &Tethers) -> Self {
        let each = || tethers.anchors.iter();
        let most = |a: &crate::Anchor| if a.exists() { T::of(f64::from(a.distance)) } else { far() };
        Held {
            grids: cloth.grids().to_vec(),
            mates: mates(cloth),
            bridges: Bridges::of(cloth),
            slots: tethers.per_particle,
            groups: groups(cloth, tethers),
            anchors: each().map(|a| a.particle).collect(),
            most: each().map(most).collect(),
        }
    }

    /// Calls `each` with all duplicates of a texel, itself first.
    pub fn ring(&self, k: usize, each: impl FnMut(usize)) {
        ring(&self.mates, k, each);
    }

    /// Calls `each` with every texel around the duplicates of one or at the other end of their stitches, and the duplicates of those. One may
    /// come twice.
    pub fn beside(&self, k: usize, mut each: impl FnMut(usize)) {
        self.ring(k, |m| {
            self.circle(m).into_iter().flatten().for_each(|(n, _, _)| self.ring(n, &mut each));
            self.bridges.at(m).iter().for_each(|(n, _, _)| self.ring(*n as usize, &mut each));
        });
    }

    /// The texels around one, and the texel and place where the spring to each is stored.
    fn circle(&self, m: usize) -> [Option<(usize, usize, usize)>; 8] {
        let grid = &self.grids[self.grids.partition_point(|g| g.first as usize <= m) - 1];
        let (first, w, h) = (grid.first as usize, grid.width as usize, grid.height as usize);
        let (i, j) = ((m - first) % w, (m - first) / w);
        std::array::from_fn(|c| {
            let (x, y, place) = CIRCLE[c];
            let (i, j) = (i.checked_add_signed(x)?, j.checked_add_signed(y)?);
            let n = first + j * w + i;
            (i < w && j < h).then_some((n, if c < 3 || c == 7 { m } else { n }, place))
        })
    }

    /// The texels around a texel, with their springs and their distances from pins of a group.
    fn look(&self, rest: &[[T; 4]], most: &[T], m: usize, group: u32) -> [Near<T>; 8] {
        self.circle(m).map(|at| {
            let Some((texel, stored, place)) = at else {
                return Near { texel: m, length: T::of(0.0), far: far(), anchor: u32::MAX };
            };
            self.near(most, texel, rest[stored][place], group)
        })
    }

    /// A texel that is `length` away, with its distance from pins of a group.
    fn near(&self, most: &[T], texel: usize, length: T, group: u32) -> Near<T> {
        let mut slots = texel * self.slots..(texel + 1) * self.slots;
        let slot = slots.find(|t| self.groups[*t] == group);
        let (far, anchor) = slot.map_or((far(), u32::MAX), |t| (most[t], self.anchors[t]));
        Near { texel, length, far, anchor }
    }

    /// The texels at the other ends of the stitches of a texel; a stitch whose quad has lost a triangle has the length 0.
    fn over<'a>(
        &'a self,
        rest: &'a [[T; 4]],
        most: &'a [T],
        m: usize,
        group: u32,
    ) -> impl Iterator<Item = Near<T>> + 'a {
        self.bridges.at(m).iter().map(move |(n, length, quad)| {
            let whole = rest[*quad as usize][2] > T::of(0.0);
            let length = if whole { T::of(f64::from(*length)) } else { T::of(0.0) };
            self.near(most, *n as usize, length, group)
        })
    }

    /// Support of tether `t` of texel `k`. 0: particles nearer to its pin hang on that pin too, and the path through them,
    /// along a spring, across a triangle or over a stitch, is at most as long as the tether. Else, beside pins that share the cloth, paths
    /// may lead between particles that hang on others: [`UNSUPPORTED`] minus the number of springs, triangles, stitches and
    /// nearer particles around it; [`UNSUPPORTED`] if no particle is nearer.
    pub fn support(&self, rest: &[[T; 4]], most: &[T], k: usize, t: usize) -> u32 {
        let (anchor, own) = (self.anchors[t], most[t]);
        let (mut way, mut nearer, mut there) = (far::<T>(), 0, 0);
        self.ring(k, |m| {
            let near = self.look(rest, most, m, self.groups[t]);
            for n in near.into_iter().chain(self.over(rest, most, m, self.groups[t])) {
                let joined = n.length > T::of(0.0);
                there += u32::from(joined);
                nearer += u32::from(n.far < own);
                if joined && n.far < own && n.anchor == anchor {
                    way = way.min(n.far + n.length);
                }
            }
            for e in TRIANGLES {
                let (x, y) = (near[e[0]], near[e[1]]);
                there += u32::from(side(rest, &near, e) > T::of(0.0));
                if x.far.max(y.far) < own && x.anchor == anchor && y.anchor == anchor {
                    way = way.min(through(rest, &near, e));
                }
            }
        });
        if way <= own * T::of(SAME) {
            0
        } else if nearer > 0 {
            UNSUPPORTED - nearer - there
        } else {
            UNSUPPORTED
        }
    }

    /// The shortest way to any anchor of a group by way of any neighbour, and which; ties go to the lower one.
    pub fn nearest(&self, rest: &[[T; 4]], k: usize, group: u32) -> (T, u32) {
        let mut best = (far::<T>(), u32::MAX);
        self.ring(k, |m| {
            let near = self.look(rest, &self.most, m, group);
            let over = self.over(rest, &self.most, m, group);
            for n in near.into_iter().chain(over).filter(|n| n.length > T::of(0.0) && n.far < far()) {
                let way = (n.far + n.length, n.anchor);
                best = if way < best { way } else { best };
            }
            for e in TRIANGLES {
                let (x, y) = (near[e[0]], near[e[1]]);
                if x.far.max(y.far) < far() && x.anchor == y.anchor {
                    let way = (through(rest, &near, e), x.anchor);
                    best = if way < best { way } else { best };
                }
            }
        });
        best
    }
}

/// The spring between the two of one of [`TRIANGLES`], 0 where any of its springs is missing.
fn side<T: Real>(rest: &[[T; 4]], near: &[Near<T>; 8], e: [usize; 4]) -> T {
    let (x, y, zero) = (near[e[0]], near[e[1]], T::of(0.0));
    if x.length > zero && y.length > zero { rest[near[e[2]].texel][e[3]] } else { zero }
}

/// The way through one of [`TRIANGLES`]; [`far`] where a spring is missing or the way does not lead through it.
fn through<T: Real>(rest: &[[T; 4]], near: &[Near<T>; 8], e: [usize; 4]) -> T {
    let (x, y, side) = (near[e[0]], near[e[1]], side(rest, near, e));
    if side > T::of(0.0) { unfold(x.far, y.far, side, x.length, y.length) } else { far() }
}

/// How far C is from a point that is `far_a` from A and `far_b` from B, straight through the side `ab`; [`self::far`] where
/// the line goes past that side. M. Novotni, R. Klein, "Computing Geodesic Distances on Triangular Meshes", WSCG 2002.
fn unfold<T: Real>(far_a: T, far_b: T, ab: T, ac: T, bc: T) -> T {
    // A at the origin, B along x, C below and the point above. Differences of squares as products: they lose less.
    let half = T::of(0.5) / ab;
    let cx = ((ac - bc) * (ac + bc) + ab * ab) * half;
    let sx = ((far_a - far_b) * (far_a + far_b) + ab * ab) * half;
    let (cy, sy) = ((ac - cx) * (ac + cx), (far_a - sx) * (far_a + sx));
    if cy > T::of(0.0) && sy >= T::of(0.0) {
        let (cy, sy) = (cy.sqrt(), sy.sqrt());
        let (height, cross) = (cy + sy, sx * cy + cx * sy);
        if cross >= T::of(0.0) && cross <= ab * height {
            return ((cx - sx) * (cx - sx) + height * height).sqrt();
        }
    }
    far()
}
