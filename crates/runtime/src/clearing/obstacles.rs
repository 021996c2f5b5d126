//! The obstacles of a garment: planes at the points that are near them.

use gimage_bundle::Winding;

use super::layers::Garment;
use super::net::Net;
use crate::cloth::surface::{Near, Posed};
use crate::collider::solid::{Exit, Solid};
use crate::number::real::{V3, add, dot, scale};

/// A point farther \[m\] than this from an obstacle has no plane of it.
pub const NEAR_M: f64 = 0.01;
/// A point deeper \[m\] in a surface than this is not moved: no normal tells where it came from.
const LOST_M: f64 = 0.2;
/// Points deeper \[m\] than this are inside of a surface only if it winds around them.
const SHALLOW_M: f64 = 0.005;
/// Winding number from which a point is inside.
pub const WOUND: f64 = 0.5;
/// Points do not go farther along the way that the cloth faces than this times their depth.
const MAX_DETOUR: f64 = 2.5;
/// Points deeper \[m\] than this behind a garment belong there: they may be of another limb.
const BEHIND_M: f64 = 0.04;
/// Distance \[m\] of a garment from one below that it crosses.
const GAP_M: f64 = 0.001;

/// A point `p` must have `dot(normal, p) >= offset`.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    pub normal: V3<f64>,
    pub offset: f64,
}

/// A triangle of a garment that must be in front of a point of a garment below.
#[derive(Clone, Copy, Debug)]
pub struct Over {
    /// Its points, and the weights of the point of it that is nearest.
    pub points: [u32; 3],
    pub weights: V3<f64>,
    pub plane: Plane,
}

/// The surface of a body.
pub struct Worn<'a> {
    posed: Posed<'a>,
    /// The height \[m\] that each point of the net keeps.
    floors: Vec<f64>,
    /// Where points of the net were at the start, and the points of the surface nearest to them.
    start: Vec<(V3<f64>, Near)>,
    /// Points that are not inside of it, though the nearest triangle faces away from them.
    beyond: Vec<bool>,
    /// The ways out of it that points take from deep inside: those in which the cloth faces at the start. Neighbours then leave on one side.
    ways: Vec<V3<f64>>,
}

impl<'a> Worn<'a> {
    /// For a net whose points are at `at` \[m\] and keep heights of `floors` \[m\].
    /// `ways` are the unit normals of the cloth, 0 for none.
    pub fn new(posed: Posed<'a>, at: &[V3<f64>], floors: Vec<f64>, mut ways: Vec<V3<f64>>) -> Self {
        let start: Vec<(V3<f64>, Near)> = at.iter().map(|p| (*p, posed.near(*p))).collect();
        let mut winding: Option<Winding> = None;
        let mut is_outside = |p: V3<f64>| winding.get_or_insert_with(|| posed.winding()).number(p) < WOUND;
        let beyond = start.iter().map(|(p, near)| near.height < -SHALLOW_M && is_outside(*p)).collect();
        // Cloth whose triangles are turned inside out faces the body.
        let faces = |((_, near), way): (&(V3<f64>, Near), &V3<f64>)| dot(near.normal, *way).clamp(-1.0, 1.0);
        if start.iter().zip(&ways).map(faces).sum::<f64>() < 0.0 {
            ways.iter_mut().for_each(|way| *way = scale(*way, -1.0));
        }
        Worn { posed, floors, start, beyond, ways }
    }

    /// Where a point of the net at `p` leaves the surface or is to stay in front of it: a point, and the normal there.
    fn front(&self, point: usize, p: V3<f64>, near: &Near) -> Option<(V3<f64>, V3<f64>)> {
        if near.height >= -SHALLOW_M {
            return Some((near.at, near.normal));
        }
        let way = self.ways[point];
        match self.posed.exit(p, way, -MAX_DETOUR * near.height) {
            Some((far, normal)) => Some((add(p, scale(way, far)), normal)),
            None => (dot(near.normal, way) >= 0.0).then_some((near.at, near.normal)),
        }
    }

    /// The point of the surface nearest to a point of the net at `p`, if it may be met.
    fn near(&self, point: usize, p: V3<f64>) -> Option<Near> {
        let (from, known) = &self.start[point];
        let near = if *from == p { *known } else { self.posed.near(p) };
        (!self.beyond[point] && !near.is_beside && near.height > -LOST_M).then_some(near)
    }

    /// The height \[m\] of a point of the net at `p`, if it may meet the surface.
    pub fn height(&self, point: usize, p: V3<f64>) -> Option<f64> {
        self.near(point, p).map(|near| near.height)
    }
}

/// A garment below that a garment crosses.
pub struct Below<'a> {
    posed: Posed<'a>,
    /// Points of it near the garment \[m\].
    points: Vec<V3<f64>>,
}

impl<'a> Below<'a> {
    /// That of a garment over another one; `None` where no point of either is on the wrong side.
    pub fn new(garment: &Garment, below: &'a Garment, nets: &[Net]) -> Option<Self> {
        let (upper, lower) = (garment.surface.as_ref()?, below.surface.as_ref()?);
        let [own, others] = [garment, below].map(|g| &nets[g.cloth].at);
        let (over, posed) = (Posed::put(upper, own.clone()), Posed::put(lower, others.clone()));
        let behind = |k: &u32| {
            let near = posed.near(own[*k as usize]);
            is_over(&near) && near.height < 0.0
        };
        let mut crosses = garment.points.iter().any(behind);
        let mut points = Vec::new();
        for p in below.points.iter().map(|k| others[*k as usize]) {
            let near = over.near(p);
            if !near.is_beside && near.height.abs() < BEHIND_M + NEAR_M {
                crosses |= near.height > 0.0 && near.height < BEHIND_M;
                points.push(p);
            }
        }
        crosses.then_some(Below { posed, points })
    }

    /// The triangles of the garment, whose surface is `posed`, that must be in front of its points.
    pub fn over(&self, posed: &Posed, triangles: &[[u32; 3]], found: &mut Vec<Over>) {
        for p in &self.points {
            let near = posed.near(*p);
            if !near.is_beside && near.height > -GAP_M && near.height < BEHIND_M {
                let plane = Plane { normal: near.normal, offset: dot(near.normal, *p) + GAP_M };
                found.push(Over { points: triangles[near.triangle as usize], weights: near.weights, plane });
            }
        }
    }
}

/// All that a garment must be outside of.
pub struct Obstacles<'a> {
    pub body: Option<Worn<'a>>,
    /// Colliders, and the distance \[m\] from them.
    pub solids: Vec<Solid<f64>>,
    pub thickness: f64,
    pub below: Vec<Below<'a>>,
}

impl Obstacles<'_> {
    pub fn is_empty(&self) -> bool {
        self.body.is_none() && self.solids.is_empty() && self.below.is_empty()
    }

    /// Adds the planes that a point at `p` must be in front of. Returns how far \[m\] it may move before other ones count.
    pub fn planes(&self, point: usize, p: V3<f64>, planes: &mut Vec<Plane>) -> f64 {
        let mut safe = NEAR_M;
        let mut put = |normal: V3<f64>, at: V3<f64>, keep: f64| {
            planes.push(Plane { normal, offset: dot(normal, at) + keep });
        };
        if let Some((worn, near)) = self.body.as_ref().and_then(|worn| Some((worn, worn.near(point, p)?))) {
            let front = if near.height < NEAR_M { worn.front(point, p, &near) } else { None };
            if let Some((at, normal)) = front {
                put(normal, at, worn.floors[point]);
            }
            safe = safe.min(near.height - NEAR_M);
        }
        for solid in &self.solids {
            if let Some(Exit { at, normal, .. }) = solid.coated(self.thickness + NEAR_M).exit(p) {
                put(normal, at, -NEAR_M);
                safe = 0.0;
            }
        }
        for below in &self.below {
            let near = below.posed.near(p);
            if is_over(&near) && near.height < NEAR_M {
                put(near.normal, near.at, GAP_M);
            }
            safe = safe.min(near.height.abs() - NEAR_M);
        }
        safe.max(0.0)
    }

    /// How deep \[m\] a point at `p` is inside of any; 0 outside of all.
    pub fn depth(&self, point: usize, p: V3<f64>) -> f64 {
        let body = self.body.as_ref().and_then(|worn| worn.height(point, p)).map_or(0.0, |height| (-height).max(0.0));
        let out = |solid: &Solid<f64>| solid.exit(p).map_or(0.0, |out| out.depth);
        let behind = |below: &Below| {
            let near = below.posed.near(p);
            if is_over(&near) { (-near.height).max(0.0) } else { 0.0 }
        };
        let solids = self.solids.iter().map(out).fold(body, f64::max);
        self.below.iter().map(behind).fold(solids, f64::max)
    }
}

/// Whether a point near a garment below is over it, or was to be.
fn is_over(near: &Near) -> bool {
    !near.is_beside && near.height > -BEHIND_M
}

impl Over {
    /// How far \[m\] the triangle is from being in front of the point.
    pub fn short(&self, at: &[V3<f64>]) -> f64 {
        self.plane.offset - dot(self.plane.normal, self.place(at))
    }

    /// The point of the triangle that is nearest to the point below.
    fn place(&self, at: &[V3<f64>]) -> V3<f64> {
        (0..3).fold([0.0; 3], |sum, k| add(sum, scale(at[self.points[k] as usize], self.weights[k])))
    }

    /// Moves the points of a triangle, those that are free, so that it is in front of the point.
    pub fn apply(&self, at: &mut [V3<f64>], free: &[bool]) {
        let ends = self.points.map(|k| k as usize);
        let short = self.short(at);
        let shares = [0, 1, 2].map(|k| if free[ends[k]] { self.weights[k] } else { 0.0 });
        let sum = (0..3).map(|k| shares[k] * self.weights[k]).sum::<f64>();
        if short > 0.0 && sum > 1e-6 {
            for k in 0..3 {
                at[ends[k]] = add(at[ends[k]], scale(self.plane.normal, short * shares[k] / sum));
            }
        }
    }
}
