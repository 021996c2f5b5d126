//! The skin of a cloth: which joints each particle follows, and where.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use gimage_bundle::{Bundle, MapKind};

use super::poses::Poses;
use super::{Cloth, Grid};
use crate::error::{Error, Result};
use crate::number::real::{Real, V3, cast};

/// A joint matrix as three rows: `p` goes to `row . (p, 1)`.
pub(crate) type Rows = [[f32; 4]; 3];

/// A joint of a [`Skin`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SkinJoint {
    /// Its name in the file that the bundle was built from.
    pub name: String,
    /// Index of its parent; `None` for a root.
    pub parent: Option<u32>,
    /// Takes a position of the cloth at rest \[m\] to the space of the joint; column-major.
    pub inverse_bind: [f32; 16],
}

/// Four joints that a particle follows, and their weights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Influence {
    /// Indices of joints.
    pub joints: [u32; 4],
    /// At least 0; the weights of all sets of a particle sum to 1.
    pub weights: [f32; 4],
}

/// The joints of a cloth, and the share that each particle follows of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    joints: Vec<SkinJoint>,
    /// Positions at rest \[m\], one per particle.
    pub(crate) rest: Vec<[f32; 3]>,
    /// Influences per particle.
    pub(crate) sets: usize,
    /// `sets` per particle; duplicates of a seam point have those of the first.
    pub(crate) influences: Vec<Influence>,
}

impl Skin {
    /// Its joints, in the order of the matrices that [`Cloth::follow_joints`] and [`crate::Stepper::set_joints`] take.
    pub fn joints(&self) -> &[SkinJoint] {
        &self.joints
    }

    /// Joint matrices from the transforms of the joints to world space, column-major, one per joint: each times the inverse bind
    /// matrix. An error if their number is another one.
    pub fn matrices(&self, worlds: &[[f32; 16]]) -> Result<Vec<[f32; 16]>> {
        self.count(worlds.len())?;
        let product = |(a, joint): (&[f32; 16], &SkinJoint)| {
            let b = &joint.inverse_bind;
            let at = |n: usize| (0..4).map(|k| f64::from(a[4 * k + n % 4]) * f64::from(b[n / 4 * 4 + k])).sum::<f64>();
            std::array::from_fn(|n| at(n) as f32)
        };
        Ok(worlds.iter().zip(&self.joints).map(product).collect())
    }

    fn count(&self, found: usize) -> Result<()> {
        match found == self.joints.len() {
            true => Ok(()),
            false => Err(Error::Joints { found, expected: self.joints.len() }),
        }
    }

    /// Checks joint matrices and turns them into rows.
    pub(crate) fn rows(&self, matrices: &[[f32; 16]]) -> Result<Arc<[Rows]>> {
        self.count(matrices.len())?;
        if let Some(joint) = matrices.iter().position(|m| m.iter().any(|x| !x.is_finite())) {
            return Err(Error::JointNotFinite { joint: self.joints[joint].name.clone(), index: joint });
        }
        Ok(matrices.iter().map(|m| [0, 1, 2].map(|r| [m[r], m[4 + r], m[8 + r], m[12 + r]])).collect())
    }

    /// Where a particle is by these poses \[m\].
    pub(crate) fn at<T: Real>(&self, poses: &Poses<T>, k: usize) -> V3<T> {
        self.point_at(poses, k, self.rest[k])
    }

    /// Where a point that moves as a particle is by these poses \[m\], from where it is at rest.
    pub(crate) fn point_at<T: Real>(&self, poses: &Poses<T>, k: usize, rest: [f32; 3]) -> V3<T> {
        poses.place(&self.influences[k * self.sets..(k + 1) * self.sets], cast(rest))
    }

    /// The skin of other particles, each with what `samples` names of this one.
    pub(crate) fn take(&self, samples: &[u32]) -> Skin {
        let own = |k: &u32| &self.influences[*k as usize * self.sets..(*k as usize + 1) * self.sets];
        Skin {
            joints: self.joints.clone(),
            rest: samples.iter().map(|k| self.rest[*k as usize]).collect(),
            sets: self.sets,
            influences: samples.iter().flat_map(own).copied().collect(),
        }
    }
}

impl Cloth {
    /// The joints that its particles can follow: those of its bundle, or of [`Cloth::set_skin`].
    pub fn skin(&self) -> Option<&Skin> {
        self.skin.as_deref()
    }

    /// Gives the cloth joints to follow. `influences` are as many per particle, in the order of the particles; positions at the time of the
    /// call are those at rest. Weights are divided by their sum, and duplicates of a seam point take the influences of the first. Errors on a
    /// list of another length, on joints that do not exist, and on weights that are negative, not finite or all 0.
    pub fn set_skin(&mut self, joints: Vec<SkinJoint>, influences: &[Influence]) -> Result<()> {
        let sets = influences.len() / self.len().max(1);
        if sets == 0 || influences.len() != sets * self.len() {
            let (found, expected) = (influences.len(), self.len());
            return Err(Error::Length { cloth: self.name().into(), what: "influences", found, expected });
        }
        let points = self.points();
        let mut list = Vec::with_capacity(influences.len());
        for (k, point) in points.iter().enumerate() {
            let own = &influences[*point as usize * sets..(*point as usize + 1) * sets];
            if !self.particles()[k].exists() {
                list.extend(std::iter::repeat_n(Influence::default(), sets));
                continue;
            }
            let bad = |problem| Error::Particle { cloth: self.name().into(), index: k, problem };
            let (mut all, mut sum) = (own.to_vec(), 0.0);
            for (joint, weight) in all.iter().flat_map(|i| i.joints.iter().zip(i.weights)) {
                if !(weight.is_finite() && weight >= 0.0) {
                    return Err(bad("a weight of a joint is negative or not finite"));
                }
                if weight > 0.0 && *joint as usize >= joints.len() {
                    return Err(bad("it follows a joint that does not exist"));
                }
                sum += f64::from(weight);
            }
            if sum <= 0.0 {
                return Err(bad("the weights of its joints are all 0"));
            }
            for i in &mut all {
                for (joint, weight) in i.joints.iter_mut().zip(&mut i.weights) {
                    *weight = (f64::from(*weight) / sum) as f32;
                    // Shaders read the matrix of each.
                    *joint = if *weight > 0.0 { *joint } else { 0 };
                }
            }
            list.extend(all);
        }
        self.skin = Some(Arc::new(Skin { joints, rest: self.positions().to_vec(), sets, influences: list }));
        self.joints = None;
        Ok(())
    }

    /// Binds the whole cloth to one joint, such as a flagpole, a vehicle or a hand, in place of the skin that it has: a skin of one joint that
    /// every particle follows alone. `inverse_bind` takes a position of the cloth as it is now \[m\] to the space of the joint, column-major.
    /// Pins that [`crate::Stepper::set_joints`] moves go there over the substeps of a frame; [`crate::Stepper::set_pins`] moves them at once: pins at
    /// 3 m/s then stretch a curtain of 48 x 48 by up to 5.2 % (p99) in place of 0.6.
    ///
    /// ```
    /// use gimage_runtime::{Flat, Options, Scene, Select, Stepper};
    ///
    /// let identity = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    /// let mut flag = Flat::square("flag", 9).cloth()?;
    /// let pole = flag.select(&Select::Texels { piece: None, from: [0, 0], to: [0, 8] })?;
    /// flag.pin(&pole)?;
    /// flag.bind_to_joint("pole", identity)?;
    /// flag.follow_joints(&[identity])?;
    /// let mut scene = Scene::new("a flag on a car");
    /// scene.cloths.push(flag);
    /// let mut stepper = Stepper::on_cpu(scene, Options::default())?;
    /// let mut car = identity;
    /// car[12] = 0.05;
    /// stepper.set_joints(0, &[car])?;
    /// stepper.advance(1.0 / 60.0)?;
    /// # Ok::<(), gimage_runtime::Error>(())
    /// ```
    ///
    /// Errors on a number of the matrix that is not finite.
    pub fn bind_to_joint(&mut self, name: &str, inverse_bind: [f32; 16]) -> Result<()> {
        if let Some(index) = inverse_bind.iter().position(|x| !x.is_finite()) {
            return Err(Error::NotFinite {
                cloth: self.name().into(),
                what: "number of the inverse bind matrix",
                index,
            });
        }
        let joint = SkinJoint { name: name.into(), parent: None, inverse_bind };
        let alone = Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] };
        self.set_skin(vec![joint], &vec![alone; self.len()])
    }

    /// Has the cloth follow its joints from its start on: it starts where these matrices put it, its pinned particles stay on the skin, and
    /// [`Cloth::limits`] are distances from the skin. [`crate::Stepper::set_joints`] moves it on.
    ///
    /// A joint matrix takes a position at rest \[m\] to where the joint moves it, column-major: the transform of the joint to world space
    /// times its inverse bind matrix, as in glTF ([`Skin::matrices`]). Costs nothing for cloth that does not follow joints; else 32 bytes
    /// per particle, and one pass per step. Errors if the cloth has no skin, on another number of matrices than [`Skin::joints`], and on
    /// numbers that are not finite.
    pub fn follow_joints(&mut self, matrices: &[[f32; 16]]) -> Result<()> {
        let skin = self.skin.clone().ok_or_else(|| Error::NoSkin { cloth: self.name().into() })?;
        let rows = skin.rows(matrices)?;
        let poses = Poses::new(self.skinning, &rows);
        let at = |k: usize| if self.particles()[k].exists() { skin.at(&poses, k) } else { self.positions()[k] };
        self.place((0..self.len()).map(at).collect())?;
        self.joints = Some(rows);
        self.bring_body_back();
        Ok(())
    }

    /// Whether it follows joints: [`Cloth::follow_joints`].
    pub fn follows_joints(&self) -> bool {
        self.joints.is_some()
    }

    /// Whether its particles have targets: those of limits, or of joints.
    pub(crate) fn is_aimed(&self) -> bool {
        self.limits.is_some() || self.follows_joints()
    }

    /// Whether it has anything that joints or teleports move beside its particles: targets, or backstops.
    pub(crate) fn has_aims(&self) -> bool {
        self.is_aimed() || self.backstops.is_some()
    }

    /// The matrices that it starts with, where it follows joints.
    pub(crate) fn first_joints(&self) -> Option<&Arc<[Rows]>> {
        self.joints.as_ref()
    }

    /// The skin of a finer image of this cloth, whose particles `samples` names, and its joints.
    pub(crate) fn take_skin(&mut self, fine: &Cloth, samples: &[u32]) {
        self.skin = fine.skin.as_ref().map(|skin| Arc::new(skin.take(samples)));
        self.start_with(fine);
    }

    /// The joint matrices that another image of this cloth starts with.
    pub(crate) fn start_with(&mut self, other: &Cloth) {
        self.joints = other.joints.clone();
    }

    /// The skin of a bundle of which every piece has one.
    pub(super) fn keep_skin(&mut self, bundle: &Bundle) -> Result<()> {
        let Some(skeleton) = &bundle.manifest.skeleton else { return Ok(()) };
        let Some(influences) = influences(bundle, self.grids()) else { return Ok(()) };
        let joint = |j: &gimage_bundle::manifest::Joint| SkinJoint {
            name: j.name.clone(),
            parent: j.parent,
            inverse_bind: j.inverse_bind,
        };
        self.set_skin(skeleton.joints.iter().map(joint).collect(), &influences)
    }
}

/// The influences of all particles, as many sets as the piece with the most has; `None` if a piece has none.
fn influences(bundle: &Bundle, grids: &[Grid]) -> Option<Vec<Influence>> {
    let image = |piece: usize, set: u8| {
        Some((bundle.image(piece, &MapKind::Joints(set))?, bundle.image(piece, &MapKind::Weights(set))?))
    };
    let of = |piece: usize| (0..u8::MAX).map_while(move |set| image(piece, set)).collect::<Vec<_>>();
    let sets: Vec<_> = (0..grids.len()).map(of).collect();
    let most = sets.iter().map(Vec::len).max()?;
    if sets.iter().any(Vec::is_empty) {
        return None;
    }
    let mut list = Vec::new();
    for (grid, sets) in grids.iter().zip(&sets) {
        for k in 0..grid.texels() {
            for set in 0..most {
                let Some((joints, weights)) = sets.get(set) else {
                    list.push(Influence::default());
                    continue;
                };
                let four = |image: &gimage_bundle::Image| image.at(k).try_into().unwrap_or([0.0; 4]);
                list.push(Influence { joints: four(joints).map(|j| j as u32), weights: four(weights) });
            }
        }
    }
    Some(list)
}

#[cfg(test)]
#[path = "skin_tests.rs"]
mod tests;
