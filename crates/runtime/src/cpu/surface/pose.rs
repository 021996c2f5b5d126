//! Twin of shaders/surface_pose.wgsl: the vertices of a surface where joints put them, at the start and at the end of a frame. Each is skinned when it is first asked for.

use crate::cloth::Poses;
use crate::cloth::surface::BodySurface;
use crate::number::real::{Real, V3, add, cast, dot, scale};

/// A vertex at the start and at the end of a frame.
#[derive(Clone, Copy)]
pub struct Vertex<T> {
    pub at: [V3<T>; 2],
    /// Of about length 1.
    pub normal: [V3<T>; 2],
    /// The frame of which it is.
    frame: u32,
}

/// The vertices of a surface.
pub struct Skinned<T: Real> {
    list: Vec<Vertex<T>>,
    frame: u32,
    /// Positions and normals at rest.
    rest: Vec<[V3<T>; 2]>,
    /// Joints and weights above 0, and where those of each vertex begin.
    shares: Vec<(u32, T)>,
    starts: Vec<u32>,
    /// Empty for a surface that rests.
    ends: [Poses<T>; 2],
    /// One over the length of the frame \[1/s\] in which vertices go from the first place to the second; 0 if they are there at once.
    rate: T,
    /// The time in the frame at which corners are asked for: 0 at its start, 1 at its end.
    time: T,
    /// Whether it has gone elsewhere at once since the last frame, and whether this frame begins where that ended.
    jumps: bool,
    follows: bool,
}

impl<T: Real> Skinned<T> {
    /// Of a surface at rest.
    pub fn new(surface: &BodySurface) -> Self {
        let zero = [[T::of(0.0); 3]; 2];
        let list = vec![Vertex { at: zero, normal: zero, frame: 0 }; surface.rest.len()];
        let rest = surface.rest.iter().zip(&surface.normals).map(|(p, n)| [cast(*p), cast(*n)]).collect();
        let (mut shares, mut starts) = (Vec::new(), vec![0]);
        for v in 0..surface.rest.len() {
            let own = &surface.influences[v * surface.sets..(v + 1) * surface.sets];
            let pairs = own.iter().flat_map(|i| i.joints.into_iter().zip(i.weights)).filter(|pair| pair.1 > 0.0);
            shares.extend(pairs.map(|(joint, weight)| (joint, T::of(f64::from(weight)))));
            starts.push(shares.len() as u32);
        }
        let (frame, rate, time, ends) = (0, T::of(0.0), T::of(0.0), [Poses::none(), Poses::none()]);
        Skinned { list, frame, rest, shares, starts, ends, rate, time, jumps: true, follows: false }
    }

    /// Goes to where these poses put it, from where the last ones did at `rate` \[1/s\], or at once if that is 0.
    pub fn lead(&mut self, poses: &Poses<T>, rate: T) {
        let last = std::mem::replace(&mut self.ends[1], poses.clone());
        self.rate = if last.len() == self.ends[1].len() { rate } else { T::of(0.0) };
        // A jump begins elsewhere than the last frame ended.
        self.jumps |= !self.moves() && last != self.ends[1];
        self.ends[0] = if self.moves() { last } else { self.ends[1].clone() };
    }

    /// Begins a frame.
    pub fn begin(&mut self) {
        self.frame += 1;
        self.follows = !std::mem::take(&mut self.jumps);
    }

    /// The number of the frame, from 1.
    pub fn frame(&self) -> u32 {
        self.frame
    }

    /// Whether it moves in this frame.
    pub fn moves(&self) -> bool {
        self.rate > T::of(0.0)
    }

    /// One over the length of the frame \[1/s\], 0 if it does not move.
    pub fn rate(&self) -> T {
        self.rate
    }

    /// Corners are those of this time in the frame from here on, 0 at its start and 1 at its end.
    pub fn look(&mut self, time: T) {
        self.time = time;
    }

    /// The time in the frame at which corners are asked for.
    pub fn time(&self) -> T {
        self.time
    }

    /// The corners of a triangle.
    #[inline]
    pub fn corners(&mut self, surface: &BodySurface, triangle: u32) -> [V3<T>; 3] {
        let [a, b, c] = surface.triangles[triangle as usize];
        let time = self.time;
        if time > T::of(0.0) {
            return [a, b, c].map(|v| between(&self.vertex(v).at, time));
        }
        [self.vertex(a).at[0], self.vertex(b).at[0], self.vertex(c).at[0]]
    }

    /// The vertices of a triangle.
    #[inline]
    pub fn vertices(&mut self, surface: &BodySurface, triangle: u32) -> [&Vertex<T>; 3] {
        let own = surface.triangles[triangle as usize];
        own.iter().for_each(|v| self.make(*v));
        own.map(|v| &self.list[v as usize])
    }

    /// A vertex.
    #[inline]
    pub fn vertex(&mut self, v: u32) -> &Vertex<T> {
        self.make(v);
        &self.list[v as usize]
    }

    #[inline]
    fn make(&mut self, v: u32) {
        if self.list[v as usize].frame != self.frame {
            self.skin(v as usize);
        }
    }

    #[inline(never)]
    fn skin(&mut self, v: usize) {
        let [rest, normal] = self.rest[v];
        let shares = &self.shares[self.starts[v] as usize..self.starts[v + 1] as usize];
        let place = |poses: &Poses<T>| {
            if shares.is_empty() || poses.is_empty() {
                return (rest, normal);
            }
            let blend = poses.blend(shares.iter().copied());
            (blend.place(rest), blend.turn(normal))
        };
        let known = self.list[v];
        let is_last = known.frame != 0 && known.frame + 1 == self.frame && self.follows;
        let last = (known.at[1], known.normal[1]);
        let (at, normal) = if is_last && !self.moves() { last } else { place(&self.ends[1]) };
        let before = match self.moves() {
            true if is_last => last,
            true => place(&self.ends[0]),
            false => (at, normal),
        };
        self.list[v] = Vertex { at: [before.0, at], normal: [before.1, normal], frame: self.frame };
    }
}

/// A place that goes evenly from its start to its end, at a time from 0 to 1.
#[inline]
pub fn between<T: Real>([start, end]: &[V3<T>; 2], time: T) -> V3<T> {
    add(scale(*start, T::of(1.0) - time), scale(*end, time))
}

/// A vector at length 1; itself where it has none.
pub fn unit<T: Real>(v: V3<T>) -> V3<T> {
    let length = dot(v, v).sqrt();
    if length > T::of(1e-18) { scale(v, T::of(1.0) / length) } else { v }
}
