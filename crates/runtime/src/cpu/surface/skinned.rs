//! The vertices of a surface where joints put them, at the start and at the end of a frame. Each is skinned when it is first asked for.

use crate::cloth::Rows;
use crate::collider::surface::{BodySurface, Tree};
use crate::number::real::{Real, V3, cast, dot, scale};

/// Matrices of joints as three rows.
type Matrices<T> = Vec<[[T; 4]; 3]>;

/// A vertex at the start and at the end of a frame.
#[derive(Clone, Copy)]
struct Vertex<T> {
    at: [V3<T>; 2],
    /// Of length 1.
    normal: [V3<T>; 2],
    /// The frame of which it is.
    frame: u32,
}

/// The vertices of a surface.
pub struct Skinned<T: Real> {
    list: Vec<Vertex<T>>,
    frame: u32,
    /// Empty for a surface that rests.
    ends: [Matrices<T>; 2],
    /// One over the length of the frame \[1/s\] in which vertices go from the first place to the second; 0 if they are there at once.
    rate: T,
    bounds: Vec<[V3<T>; 2]>,
    /// The frame of which the boxes are.
    fitted: u32,
}

impl<T: Real> Skinned<T> {
    /// Of a surface at rest.
    pub fn new(surface: &BodySurface) -> Self {
        let zero = [[T::of(0.0); 3]; 2];
        let list = vec![Vertex { at: zero, normal: zero, frame: 0 }; surface.rest.len()];
        let (frame, fitted, rate) = (0, 0, T::of(0.0));
        Skinned { list, frame, ends: [Vec::new(), Vec::new()], rate, bounds: Vec::new(), fitted }
    }

    /// Goes to where these matrices put it, from where the last ones did at `rate` \[1/s\], or at once if that is 0.
    pub fn lead(&mut self, matrices: &[Rows], rate: T) {
        let to: Matrices<T> = matrices.iter().map(|rows| rows.map(cast)).collect();
        let last = std::mem::replace(&mut self.ends[1], to);
        self.rate = if last.len() == self.ends[1].len() { rate } else { T::of(0.0) };
        self.ends[0] = if self.moves() { last } else { self.ends[1].clone() };
    }

    /// Begins a frame.
    pub fn begin(&mut self) {
        self.frame += 1;
    }

    /// Whether it moves in this frame.
    pub fn moves(&self) -> bool {
        self.rate > T::of(0.0)
    }

    /// One over the length of the frame \[1/s\], 0 if it does not move.
    pub fn rate(&self) -> T {
        self.rate
    }

    /// The corners of a triangle at the start of the frame.
    #[inline]
    pub fn corners(&mut self, surface: &BodySurface, triangle: u32) -> [V3<T>; 3] {
        let [a, b, c] = surface.triangles[triangle as usize];
        [self.vertex(surface, a).at[0], self.vertex(surface, b).at[0], self.vertex(surface, c).at[0]]
    }

    /// The corners of a triangle and their normals, at the start of the frame and at its end.
    pub fn both(&mut self, surface: &BodySurface, triangle: u32) -> [([V3<T>; 3], [V3<T>; 3]); 2] {
        let all = surface.triangles[triangle as usize].map(|v| *self.vertex(surface, v));
        [0, 1].map(|end| (all.map(|v| v.at[end]), all.map(|v| v.normal[end])))
    }

    /// A vertex at the start and at the end of the frame.
    pub fn ends(&mut self, surface: &BodySurface, v: u32) -> [V3<T>; 2] {
        self.vertex(surface, v).at
    }

    #[inline]
    fn vertex(&mut self, surface: &BodySurface, v: u32) -> &Vertex<T> {
        if self.list[v as usize].frame != self.frame {
            self.skin(surface, v as usize);
        }
        &self.list[v as usize]
    }

    #[inline(never)]
    fn skin(&mut self, surface: &BodySurface, v: usize) {
        let (rest, normal): (V3<T>, V3<T>) = (cast(surface.rest[v]), cast(surface.normals[v]));
        let place = |matrices: &Matrices<T>| {
            if surface.sets == 0 || matrices.is_empty() {
                return (rest, normal);
            }
            let mut blend = [[T::of(0.0); 4]; 3];
            for influence in &surface.influences[v * surface.sets..(v + 1) * surface.sets] {
                for (joint, weight) in influence.joints.iter().zip(influence.weights).filter(|x| x.1 > 0.0) {
                    let (matrix, weight) = (&matrices[*joint as usize], T::of(f64::from(weight)));
                    for (row, other) in blend.iter_mut().zip(matrix) {
                        row.iter_mut().zip(other).for_each(|(sum, x)| *sum = *sum + *x * weight);
                    }
                }
            }
            let turned = blend.map(|r| r[0] * normal[0] + r[1] * normal[1] + r[2] * normal[2]);
            let at = blend.map(|r| r[0] * rest[0] + r[1] * rest[1] + r[2] * rest[2] + r[3]);
            (at, unit(turned))
        };
        let (at, normal) = place(&self.ends[1]);
        let before = if self.moves() { place(&self.ends[0]) } else { (at, normal) };
        self.list[v] = Vertex { at: [before.0, at], normal: [before.1, normal], frame: self.frame };
    }

    /// The nearest point of all at the start of the frame, found by a tree: its triangle.
    pub fn search(&mut self, surface: &BodySurface, p: V3<T>) -> u32 {
        if self.fitted != self.frame {
            (0..surface.rest.len() as u32).for_each(|v| _ = self.vertex(surface, v));
            let mut bounds = std::mem::take(&mut self.bounds);
            let corners = |t: u32| surface.triangles[t as usize].map(|v| self.list[v as usize].at[0]);
            surface.tree.fit(corners, &mut bounds);
            (self.bounds, self.fitted) = (bounds, self.frame);
        }
        let corners = |t: u32| surface.triangles[t as usize].map(|v| self.list[v as usize].at[0]);
        Tree::nearest(&surface.tree, &self.bounds, p, |t| super::nearest::on_triangle(p, t, corners(t)).distance2).0
    }
}

/// A vector at length 1; itself where it has none.
pub fn unit<T: Real>(v: V3<T>) -> V3<T> {
    let length = dot(v, v).sqrt();
    if length > T::of(1e-18) { scale(v, T::of(1.0) / length) } else { v }
}
