//! The plane of a patch that comes to a particle in a frame, such as a heel to a cape: the point that is nearest at the start of the frame may then pass by, or be of another part of
//! the body.

use super::contact::Plane;
use super::nearest::walk;
use super::search::{MARGIN_M, View, kept};
use super::{Pin, Worn, length};
use crate::cloth::surface::Spot;
use crate::number::real::{Real, V3, add, dot, scale, sub};

/// The farthest \[m\] that a particle and the surface go between two looks at the nearest point, and the most looks in a frame.
pub const LOOK_M: f64 = 0.01;
pub const LOOKS: f64 = 12.0;
/// Planes that are known keep a particle out if it stays at most this much \[m\] below its clearance.
pub const HELD_M: f64 = 0.001;

/// Where a particle is at the end of a frame in which a part of the surface comes to it.
pub(super) struct Struck<T> {
    /// The nearest point of that part, and its plane in the frame.
    pub spot: Spot<T>,
    pub view: View<T>,
    pub plane: Plane<T>,
    /// The distance \[m\] of the part that was nearest at the start, below 0 inside.
    pub other: T,
}

impl<T: Real> Worn<T> {
    /// A particle at `p` goes on by `goes` and gives way to a patch, whose nearest point it follows from look to look. If that is near at the end, and `planes` would let the particle in: the
    /// plane there, which begins at the particle, or below it, and ends where the surface does. `nearest` is a triangle near the particle at the start.
    pub(super) fn struck(
        &mut self,
        (patch, nearest): (u32, u32),
        (p, goes): (V3<T>, V3<T>),
        (clearance, pin): (T, &Option<Pin<T>>),
        planes: &[Option<Plane<T>>; 2],
    ) -> Option<Struck<T>> {
        let (zero, one) = (T::of(0.0), T::of(1.0));
        let mut spot = walk(&self.surface, &mut self.skinned, self.surface.middles[patch as usize], p);
        let mut view = self.view(&spot, p);
        if view.height < zero {
            return None;
        }
        let left = |time: T| (one - time) / self.skinned.rate();
        // Where the planes that are known leave it.
        let held = |time: T| {
            let mut q = add(p, scale(goes, time));
            for plane in planes.iter().flatten() {
                let at = sub(plane.at, scale(plane.drift, left(time)));
                let normal = sub(plane.normal, scale(plane.turn, left(time)));
                q = add(q, scale(normal, (plane.clearance - dot(sub(q, at), normal)).max(zero)));
            }
            q
        };
        let places = [T::of(0.5), one].map(|time| (time, held(time)));
        let is_held = places.into_iter().all(|(time, q)| {
            self.skinned.look(time);
            let below = walk(&self.surface, &mut self.skinned, spot.triangle, q);
            self.view(&below, q).height >= clearance - T::of(HELD_M)
        });
        self.skinned.look(zero);
        if is_held {
            return None;
        }
        let far = (length(goes) + view.way) / T::of(LOOK_M);
        let looks = far.min(T::of(LOOKS)).get().ceil().max(1.0) as u32;
        let share = one / T::of(f64::from(looks));
        let mut q = p;
        for n in 1..=looks {
            self.skinned.look(if n == looks { one } else { T::of(f64::from(n)) * share });
            q = add(q, scale(goes, share));
            spot = walk(&self.surface, &mut self.skinned, spot.triangle, q);
            view = self.view(&spot, q);
            if n < looks && view.height < clearance {
                q = add(q, scale(view.normal, clearance - view.height));
            }
        }
        let other = walk(&self.surface, &mut self.skinned, nearest, q);
        let other = self.view(&other, q).height;
        self.skinned.look(zero);
        if view.open || view.height > clearance + T::of(MARGIN_M) {
            return None;
        }
        let from = sub(p, sub(view.to, view.drift));
        let height = dot(from, view.normal);
        let clearance = kept(clearance, pin, p, (from, view.normal));
        let lower = scale(view.normal, (clearance - height).max(zero));
        let drift = scale(add(view.drift, lower), self.skinned.rate());
        let plane = Plane { at: view.to, normal: view.normal, drift, turn: [zero; 3], clearance };
        Some(Struck { spot, view, plane, other })
    }
}
