//! The surface of a body that a cloth is worn on.

use std::sync::Arc;

use gimage_bundle::Bundle;

use super::surface::{BodySurface, Posed, heights};
use super::{Cloth, Rows};
use crate::collider::BODY_GROUP;
use crate::error::{Error, Result};
use crate::number::real::cast;

/// Least clearance \[m\] of cloth that was modelled nearer to the body.
pub(crate) const LEAST_CLEARANCE_M: f32 = 0.001;
/// Cloth that is to stay deeper \[m\] inside the body than this does not meet it: pins beside it are there too, and no normal tells where it came from.
pub(crate) const MODELLED_INSIDE_M: f32 = 0.005;

/// Loose cloth keeps the size of its cells from the body, at most this share of its distance at rest. Particles alone meet the body: nearer to it, those below a hem or a belt are held there, as
/// the way out leads around an edge that their springs cross already. Cloth that rests close to the body, as a shirt in an armpit, has no room for that.
const REST_SHARE: f32 = 0.25;

/// A surface, and what keeps particles off it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WornOn {
    pub surface: Arc<BodySurface>,
    /// The same where the cloth was modelled on it: a scene may have put both elsewhere.
    pub modelled: Arc<BodySurface>,
    /// The height \[m\] above it that each particle keeps if the cloth is not thinner.
    pub floors: Arc<[f32]>,
    /// The least thickness \[m\] of the cloth at each particle, by [`Cloth::keep_room`]; empty for none.
    pub coats: Arc<[f32]>,
}

impl Cloth {
    /// The surface that the cloth is worn on.
    pub fn body(&self) -> Option<&Arc<BodySurface>> {
        self.worn_on.as_ref().map(|worn| &worn.surface)
    }

    /// Influences per vertex by which that surface moves with the joints of the cloth; 0 if it rests.
    pub(crate) fn body_sets(&self) -> usize {
        self.body().filter(|_| self.follows_joints()).map_or(0, |surface| surface.sets)
    }

    /// Has the cloth collide with the surface of a body, or with none. The surface follows the joints of the cloth, and rests if the cloth follows none.
    /// [`Cloth::from_bundle`] does this for a bundle with a surface.
    ///
    /// Particles keep [`Cloth::thickness`] from it, or, if that is less, their distance from it at rest, at least 1 mm. Loose cloth of bundles keeps more, as long as it has the surface that came with it: the distance of its particles from one
    /// another, at most a quarter of its distance at rest. Particles that are more than 5 mm inside at rest may stay as deep. Its friction is 0.3 times [`Cloth::friction`]. The cloth does not meet colliders that are in [`BODY_GROUP`] alone. With [`crate::Solver::Xpbd`]
    /// only: with the classic solver the cloth meets those colliders in place of the surface, with a warning.
    ///
    /// A frame costs some 150 ns per particle near the body on the CPU. Takes some 400 bytes per particle and 200 per vertex of the surface; copies of the cloth share
    /// the surface itself on the CPU. Each call searches the nearest point of each particle, some microseconds each. Errors ([`Error::Surface`]) if the surface follows more
    /// joints than the cloth has.
    pub fn set_body(&mut self, surface: Option<Arc<BodySurface>>) -> Result<()> {
        let Some(surface) = surface else {
            self.worn_on = None;
            return Ok(());
        };
        let joints = self.skin().map_or(0, |skin| skin.joints().len());
        if surface.joints() > joints {
            return Err(Error::Surface {
                index: surface.joints() - 1,
                problem: "it follows a joint that the cloth does not have",
            });
        }
        let own = self.worn_on.as_ref().filter(|own| Arc::ptr_eq(&own.surface, &surface));
        let has_room = own.is_some_and(|own| !own.coats.is_empty());
        let modelled = own.map_or(&surface, |own| &own.modelled).clone();
        let at = |k: usize| self.at_rest(k);
        let there = |k: usize| if self.particles()[k].exists() { at(k) } else { [0.0; 3] };
        let floor = |h: f32| if h < -MODELLED_INSIDE_M { h } else { h.max(LEAST_CLEARANCE_M) };
        let floors = heights(&modelled, (0..self.len()).map(there)).into_iter().map(floor).collect();
        self.worn_on = Some(WornOn { surface, modelled, floors, coats: Arc::default() });
        if has_room {
            self.keep_room();
        }
        Ok(())
    }

    /// Moves the surface, which rests, with cloth that follows no joints: `by` has turned and shifted the cloth.
    #[cfg(any(feature = "scene-file", test))]
    pub(crate) fn carry_body(&mut self, by: impl Fn([f32; 3]) -> [f32; 3]) -> Result<()> {
        let has_skin = self.skin().is_some();
        let Some(worn) = &mut self.worn_on else { return Ok(()) };
        let BodySurface { rest, triangles, influences, .. } = &*worn.surface;
        let moved = rest.iter().map(|p| by(*p)).collect();
        worn.surface = Arc::new(BodySurface::new(moved, triangles.clone(), influences.clone())?);
        // Without a skin cloth was modelled where it is.
        if !has_skin {
            worn.modelled = worn.surface.clone();
        }
        Ok(())
    }

    /// Puts the surface back to where the joints of the cloth have it at rest.
    pub(super) fn bring_body_back(&mut self) {
        self.worn_on.iter_mut().for_each(|worn| worn.surface = worn.modelled.clone());
    }

    /// Has loose cloth keep the size of its cells from its surface, by [`REST_SHARE`].
    pub(super) fn keep_room(&mut self) {
        let cells = self.cells();
        let Some(worn) = &mut self.worn_on else { return };
        worn.coats = cells.iter().zip(&*worn.floors).map(|(cell, h)| cell.min(REST_SHARE * h.max(0.0))).collect();
    }

    /// The mean rest length \[m\] of the springs between each particle and its neighbours in its row and column; 0 without any.
    fn cells(&self) -> Vec<f32> {
        let mut sums = vec![(0.0f32, 0.0f32); self.len()];
        for (index, grid) in self.grids().iter().enumerate() {
            for (k, direction) in (0..grid.texels()).flat_map(|k| [(k, 0), (k, 1)]) {
                let length = self.spring(index, k, direction);
                let ends = self.neighbour(index, k, direction).filter(|_| length > 0.0);
                for end in ends.into_iter().flat_map(|other| [grid.first as usize + k, other]) {
                    sums[end] = (sums[end].0 + length, sums[end].1 + 1.0);
                }
            }
        }
        sums.into_iter().map(|(sum, count)| sum / count.max(1.0)).collect()
    }

    /// Where a particle is in the pose in which the cloth was modelled \[m\].
    pub(crate) fn at_rest(&self, k: usize) -> [f32; 3] {
        self.skin().map_or(self.positions()[k], |skin| skin.rest[k])
    }

    /// The thickness \[m\] with which a particle meets the surface; `thickness` \[m\] is that of cloth without its own.
    pub(crate) fn coat(&self, k: usize, thickness: f32) -> f32 {
        let coat = self.worn_on.as_ref().and_then(|worn| worn.coats.get(k)).copied().unwrap_or(0.0);
        self.thickness.unwrap_or(thickness).max(coat)
    }

    /// The height \[m\] above the surface that each particle keeps, as [`Cloth::coat`]; empty without a surface.
    pub(crate) fn clearances(&self, thickness: f32) -> Vec<f32> {
        let floors = self.worn_on.as_ref().map_or(&[][..], |worn| &worn.floors[..]);
        floors.iter().enumerate().map(|(k, floor)| floor.min(self.coat(k, thickness))).collect()
    }

    /// The surface of a body, and the heights \[m\] above it that particles keep if the cloth is not thinner.
    pub(crate) fn worn_on(&self) -> Option<(&Arc<BodySurface>, &[f32])> {
        self.worn_on.as_ref().map(|worn| (&worn.surface, &worn.floors[..]))
    }

    /// The same with the surface where the cloth was modelled: beside [`Cloth::at_rest`].
    pub(crate) fn modelled_on(&self) -> Option<(&Arc<BodySurface>, &[f32])> {
        self.worn_on.as_ref().map(|worn| (&worn.modelled, &worn.floors[..]))
    }

    /// Has particles keep other heights \[m\] above its surface: `floors` has those of points, and `points` the point of each particle, `u32::MAX` for
    /// none.
    pub(crate) fn set_floors(&mut self, points: &[u32], floors: &[f64]) {
        let Some(worn) = &mut self.worn_on else { return };
        let own = worn.floors.iter().zip(points);
        worn.floors = own.map(|(old, point)| floors.get(*point as usize).map_or(*old, |floor| *floor as f32)).collect();
    }

    /// The largest depth \[m\] of a free particle at `now` \[m\] inside the surface that it is worn on, where these matrices put it; 0 outside,
    /// and without a surface. Some microseconds per particle.
    pub(crate) fn depth_in_body(&self, now: &[[f32; 4]], matrices: &[Rows]) -> f64 {
        let Some((surface, _)) = self.worn_on() else { return 0.0 };
        let posed = Posed::by_joints(surface, self.skinning, matrices);
        let free = now.iter().filter(|p| p[3] > 0.0 && p.iter().all(|x| x.is_finite()));
        let mut winding = None;
        // A point behind the nearest triangle may be outside of a surface that is open.
        let depth = |p: &[f32; 4]| {
            let p = cast([p[0], p[1], p[2]]);
            let near = posed.near(p);
            let is_deep = near.height < -f64::from(MODELLED_INSIDE_M);
            let is_outside =
                near.is_beside || (is_deep && winding.get_or_insert_with(|| posed.winding()).number(p) < 0.5);
            if is_outside { 0.0 } else { -near.height }
        };
        free.map(depth).fold(0.0, f64::max)
    }

    /// The groups of colliders that it meets.
    pub(crate) fn met_groups(&self) -> u32 {
        if self.worn_on.is_some() { self.collision_groups & !BODY_GROUP } else { self.collision_groups }
    }

    /// The surface of a finer image of this cloth, whose particles `samples` names.
    pub(crate) fn take_body(&mut self, fine: &Cloth, samples: &[u32]) {
        self.worn_on = fine.worn_on.as_ref().map(|worn| WornOn {
            surface: worn.surface.clone(),
            modelled: worn.modelled.clone(),
            floors: samples.iter().map(|k| worn.floors[*k as usize]).collect(),
            coats: samples.iter().filter_map(|k| worn.coats.get(*k as usize).copied()).collect(),
        });
    }

    /// Leaves its surface out, for a solver that has no contact with it; whether it had one.
    pub(crate) fn leave_body(&mut self) -> bool {
        self.worn_on.take().is_some()
    }

    /// The surface of a bundle that has one.
    pub(super) fn keep_body(&mut self, bundle: &Bundle) -> Result<()> {
        self.set_body(BodySurface::of_bundle(bundle)?.map(Arc::new))?;
        self.keep_room();
        Ok(())
    }
}
