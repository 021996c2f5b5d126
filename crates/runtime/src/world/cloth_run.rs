//! How a cloth runs.

use std::sync::{Arc, OnceLock};

use super::arrival::Arrival;
use super::follow::Joints;
use super::grabs::Grabs;
use super::images::Images;
use super::levels::Finer;
use super::moving::Moving;
use super::sleep::Calm;
use super::stir::PinPlaces;
use crate::choose::Hold;
use crate::cloth::{Anchor, Cloth, Poses, Tethers};
use crate::form::Fused;
use crate::limits::Warning;
use crate::number::real::{dot, sub, with_w};
use crate::passes::Schedule;
use crate::scene::Pose;
use crate::state::ClothState;
use crate::tile::{Order, Sequence};

/// Data that a world holds of one cloth beside the cloth itself.
#[derive(Default)]
pub struct ClothRun {
    /// Its tethers; without slots where it has none.
    pub tethers: Arc<Tethers>,
    /// Data that it shares with other cloths of the same images.
    pub images: Option<Arc<Images>>,
    /// The finer images that it goes back to, the finest first.
    pub finer: Vec<Finer>,
    /// Its last change of level, as long as bound meshes show it; on the CPU backend alone.
    pub arrival: Option<Arc<Arrival>>,
    /// Its place among the [`crate::coat::Coats`].
    pub coat: usize,
    /// Its passes.
    pub schedule: Schedule,
    /// Its whole frame in one dispatch, where it runs so.
    pub fused: Option<Fused>,
    /// Most steps of it in one dispatch.
    pub most: u32,
    /// Its dispatches where it shares them with other cloths step by step.
    pub sequence: Option<Arc<Sequence>>,
    /// How passes run together where it shares none, found when it is first asked for.
    pub order: OnceLock<Option<Order>>,
    /// Largest area of its particles over their mass \[m^2/kg\], found when air first acts on it.
    pub exposed: OnceLock<f64>,
    pub asleep: bool,
    /// Where teleports have moved its start.
    pub home: Pose,
    /// Its frame of reference, if it has one that moves.
    pub moving: Option<Moving>,
    /// Where the host has put its pins.
    pub pins: PinPlaces,
    /// Its points that drags hold.
    pub grabs: Grabs,
    /// The joints that it follows, if it does.
    pub joints: Option<Joints>,
    /// How long it has been calm.
    pub calm: Calm,
    /// How texture coordinates run along its rows and columns, found when tangents are first asked for.
    charts: OnceLock<Vec<[f32; 4]>>,
    /// Values of it that were changed because the solver cannot handle them.
    pub warnings: Vec<Warning>,
    /// Its last state in the host's memory, from which it continues if the device is lost.
    pub kept: Option<Kept>,
}

/// A state of a cloth, and the level on which it had it.
pub struct Kept {
    pub level: u32,
    pub state: ClothState,
}

impl ClothRun {
    /// A cloth with these images.
    pub fn new(images: Arc<Images>) -> Self {
        ClothRun { tethers: images.tethers().clone(), images: Some(images), ..ClothRun::default() }
    }

    /// Tethers per particle, and a number that only instances of the same cloth share.
    pub fn instance(&self) -> (usize, usize) {
        let images = self.images.as_ref().map_or(std::ptr::null(), Arc::as_ptr);
        (self.tethers.per_particle, images as usize)
    }

    /// Whether another cloth has the same images, and neither shares less than it did at the start.
    pub fn is_instance_of(&self, other: &ClothRun) -> bool {
        self.images.as_ref().zip(other.images.as_ref()).is_some_and(|(a, b)| Arc::ptr_eq(a, b))
    }

    /// As [`Cloth::charts`].
    pub fn charts(&self, cloth: &Cloth) -> &[[f32; 4]] {
        self.charts.get_or_init(|| cloth.charts())
    }

    /// The targets \[m\] of a cloth's particles where it is now, or where its joints are, and its limits, -1 for none; empty if it has
    /// neither limits nor joints.
    pub fn targets(&self, cloth: &Cloth) -> Vec<[f32; 4]> {
        if !cloth.is_aimed() {
            return Vec::new();
        }
        let skin = self.poses(cloth).zip(cloth.skin());
        let at = |(k, p): (usize, &[f32; 3])| match &skin {
            Some((poses, skin)) if cloth.particles()[k].exists() => skin.at(poses, k),
            _ => self.home.apply(*p),
        };
        let limit = |k: usize| cloth.limits.as_ref().map_or(-1.0, |limits| limits[k]);
        cloth.positions().iter().enumerate().map(|(k, p)| with_w(at((k, p)), limit(k))).collect()
    }

    /// The poses of the joints that a cloth follows, as they are now.
    fn poses(&self, cloth: &Cloth) -> Option<Poses<f32>> {
        self.joints.as_ref().map(|joints| Poses::new(cloth.skinning, joints.now()))
    }

    /// The spheres of a cloth's backstops where it is now, or where its joints are: centre \[m\] and radius \[m\], -1 for none; empty if it
    /// has no backstops.
    pub fn spheres(&self, cloth: &Cloth) -> Vec<[f32; 4]> {
        let skin = self.poses(cloth).zip(cloth.skin());
        let at = |(k, [x, y, z, radius]): (usize, [f32; 4])| match &skin {
            Some((poses, skin)) if cloth.particles()[k].exists() => with_w(skin.point_at(poses, k, [x, y, z]), radius),
            _ => with_w(self.home.apply([x, y, z]), radius),
        };
        cloth.spheres().into_iter().enumerate().map(at).collect()
    }

    /// The speeds \[m/s\] of targets that rest, and as w 1 for the particles that follow joints, else 0; empty if none does.
    pub fn drifts(&self, cloth: &Cloth) -> Vec<[f32; 4]> {
        let Some(joints) = &self.joints else { return Vec::new() };
        let mut drifts = vec![[0.0; 4]; cloth.len()];
        joints.joined.iter().for_each(|k| drifts[*k as usize][3] = 1.0);
        drifts
    }
}

/// The tethers of a cloth, in as many slots as are used.
pub fn hang(cloth: &Cloth, hold: Hold) -> Tethers {
    if hold.most == 0 || !cloth.particles().iter().any(|p| p.is_pinned()) {
        return Tethers::default();
    }
    let found = cloth.tethers(hold.most as usize);
    let used = (0..cloth.len()).map(|k| found.of(k).iter().filter(|a| a.exists()).count()).max().unwrap_or(0);
    let mut ends: Vec<u32> = found.anchors.iter().filter(|a| a.exists()).map(|a| a.particle).collect();
    ends.sort_unstable();
    ends.dedup();
    let mut anchors = Vec::with_capacity(used * cloth.len());
    for k in 0..cloth.len() {
        if ends.len() == used {
            // A slot for each pin: neighbours then hang on the same one, which is quicker.
            let of = |end: &u32| found.of(k).iter().find(|a| a.particle == *end).copied().unwrap_or(Anchor::NONE);
            anchors.extend(ends.iter().map(of));
        } else {
            anchors.extend(&found.of(k)[..used]);
        }
    }
    if cloth.coarse {
        // No shorter than straight through space at the start, or the first step would jerk the cloth.
        let place = |k: usize| cloth.positions()[k].map(f64::from);
        for (n, a) in anchors.iter_mut().enumerate().filter(|(_, a)| a.exists()) {
            let way = sub(place(n / used), place(a.particle as usize));
            a.distance = a.distance.max(dot(way, way).sqrt() as f32);
        }
    }
    anchors.iter_mut().for_each(|a| a.distance *= hold.slack);
    Tethers { per_particle: used, anchors }
}
