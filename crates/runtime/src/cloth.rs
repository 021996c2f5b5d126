//! The description of a cloth before it is stepped: grids of particles, pins, rest lengths and masses.

mod backstop;
mod body;
mod charts;
mod check;
mod contact;
mod flat;
mod from_bundle;
mod groups;
mod loops;
mod loose;
mod pin;
mod poses;
mod select;
mod share;
pub(crate) mod shear;
mod sheet;
mod skin;
mod stitch;
pub(crate) mod surface;
mod tether;
mod texture;
mod weigh;

pub use backstop::Backstop;
pub(crate) use body::{LEAST_CLEARANCE_M, MODELLED_INSIDE_M};
pub use contact::{ClothContact, ContactTier};
pub(crate) use contact::{Kin, SKIPPED_CELLS};
pub use flat::Flat;
pub(crate) use gimage_bundle::other_end;
pub use gimage_bundle::{Anchor, MAX_STITCHES_AT_POINT, Particle, Stitch, Tethers};
pub(crate) use groups::{Bridges, groups, mates, of_pins, ring};
pub(crate) use poses::Poses;
pub use poses::{JointPoses, Skinning};
pub use select::Select;
pub(crate) use sheet::{Bending, Membrane, Woven};
pub(crate) use skin::Rows;
pub use skin::{Influence, Skin, SkinJoint};
pub(crate) use stitch::{ENDS, NO_STITCH, Sewing, Thread};
pub use surface::BodySurface;

use std::sync::Arc;

use crate::error::{Result, check as range};
use crate::moving_frame::Inertia;

/// One grid of particles, a piece of a bundle. Texel (i, j) is particle `first + j * width + i`.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Its name; dumps are named by it.
    pub name: String,
    /// Index of texel (0, 0) among the particles of the cloth.
    pub first: u32,
    /// Texels in a row, at least 2.
    pub width: u32,
    /// Rows, at least 2.
    pub height: u32,
}

impl Grid {
    /// Texels of the grid.
    pub fn texels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The particles of the grid among those of the cloth.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..self.first as usize + self.texels()
    }
}

/// Rest lengths \[m\] of the springs stored at a texel: right, down, down-right, up-right. 0 means no spring: such a spring
/// moves neither of its ends, which is also how a cut spring is written.
#[derive(Clone, Debug, PartialEq)]
pub enum Rest {
    /// No springs at all: the spring passes do not run.
    None,
    /// The same lengths for every texel of a grid, one entry a grid. Needs no image.
    Constant(Vec<[f32; 4]>),
    /// One entry a particle.
    Image(Vec<[f32; 4]>),
}

/// Compliance \[m/N\] of springs, the inverse of their stiffness; the classic solver has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Compliance {
    /// As stiff as the solver can.
    #[default]
    None,
    /// The same for every spring.
    Constant(f32),
    /// One entry a particle, as rest lengths.
    Image(Arc<[[f32; 4]]>),
}

/// Masses \[kg\]. Each duplicate of a seam point holds the mass of the whole point.
#[derive(Clone, Debug, PartialEq)]
pub enum Mass {
    /// The same for every particle.
    Constant(f32),
    /// One for each particle; without meaning where there is no particle.
    Image(Vec<f32>),
}

/// The parts of a cloth. [`Cloth::new`] checks them.
#[derive(Clone, Debug, PartialEq)]
pub struct Parts {
    /// A name for messages.
    pub name: String,
    /// The grids, without gaps between their particles.
    pub grids: Vec<Grid>,
    /// Position \[m\] of every particle.
    pub positions: Vec<[f32; 3]>,
    /// The state of every particle; seam links lead from duplicate to duplicate in a closed ring.
    pub particles: Vec<Particle>,
    /// Rest lengths.
    pub rest: Rest,
    /// Masses.
    pub mass: Mass,
}

/// The parts of a checked cloth, which its copies share.
#[derive(Clone, Debug, PartialEq)]
struct Lists {
    name: String,
    grids: Arc<Vec<Grid>>,
    positions: Arc<Vec<[f32; 3]>>,
    particles: Arc<Vec<Particle>>,
    rest: Arc<Rest>,
    mass: Arc<Mass>,
}

/// A checked cloth. Making one costs time and memory linear in its particles; stepping does not change it. Copies share all lists
/// until one of them changes a list, so a copy costs less than a kilobyte.
#[derive(Clone, Debug, PartialEq)]
pub struct Cloth {
    parts: Lists,
    /// Offsets into `ring_members`, one more than there are rings.
    ring_starts: Arc<Vec<u32>>,
    ring_members: Arc<Vec<u32>>,
    cut: bool,
    /// The rest lengths before the first cut, where cuts need an image of them.
    uncut: Option<Arc<Rest>>,
    /// Tethers that came with the cloth, as long as its pins and stitches are those they were made for.
    stored_tethers: Option<Arc<Tethers>>,
    /// Velocity \[m/s\] of all free particles at the start. Default 0.
    pub velocity: [f32; 3],
    /// Damping rate of the velocity \[1/s\]: after t seconds `exp(-damping t)` of it remains, whatever the step. At least 0,
    /// default 0; larger is calmer.
    pub damping: f32,
    /// A displacement faster than this \[m/s\] is treated as a collision and contributes no velocity to the next step. Above
    /// 0, default infinite; smaller values stop fast cloth.
    pub speed_limit: f32,
    /// Distance \[m\] that particles keep from the surfaces of colliders: half the thickness of the cloth. Default none:
    /// [`crate::Options::thickness`]. 0 to 1. Cloths of equal thickness and friction share colliders; each further pair of values
    /// takes 80 bytes per collider, for at least 16 colliders. No per-frame cost.
    pub thickness: Option<f32>,
    /// Factor of the friction of colliders: the coefficient of contact is the product of both. Default 1; 0 to 1e6; larger
    /// slides less. A collider without friction stays smooth.
    pub friction: f32,
    /// The groups of colliders that it meets, a bit each; see [`crate::Collider::collision_groups`]. Default all. Cloth
    /// that meets no collider has no pass for contact. Cloths of equal thickness, friction and groups share colliders.
    pub collision_groups: u32,
    /// Contact with itself and with other cloths that have contact, for [`crate::Solver::Xpbd`]. Default none, at no cost.
    pub contact: Option<ClothContact>,
    /// How its particles, the surface of a body that it is worn on, and vertices of a bound mesh that blend to the skin move between joints. Default linear.
    /// To be set before [`Cloth::follow_joints`].
    pub skinning: Skinning,
    /// Shares of the motion of its frame of reference that it feels ([`crate::Stepper::set_moving_frame`]). Default all.
    pub inertia: Inertia,
    /// Compliance of the springs. Default none. Cloth of a material has a membrane instead of springs.
    pub compliance: Compliance,
    /// Largest distance \[m\] of each particle from its initial position, or from the skin of cloth that follows joints, for [`crate::Solver::Xpbd`]: a motion constraint.
    /// 0 holds a free particle there, below 0 means none. Default none, at no cost; else one pass per step, of 36 bytes per
    /// particle. The same for all duplicates of a seam particle.
    pub limits: Option<Arc<[f32]>>,
    /// How far each particle may go behind its initial position, or behind the skin of cloth that follows joints, for [`crate::Solver::Xpbd`].
    /// Default none, at no cost; else one pass per step, of 36 bytes per particle. The same for all duplicates of a seam particle.
    pub backstops: Option<Arc<[Backstop]>>,
    /// The membrane that carries tension in place of springs; [`Cloth::set_material`] makes it.
    pub(crate) membrane: Option<Arc<Membrane>>,
    /// How stiff the cloth is against bending; [`Cloth::set_material`] makes it.
    pub(crate) bending: Option<Arc<Bending>>,
    /// Whether steps are so short that rounding of positions matters; so for cloth of a material.
    pub(crate) exact: bool,
    /// Bound on the correction by hard diagonals, over the square of a step \[1/s^2\]; 0 for none.
    pub(crate) shear: f64,
    /// Whether it is a coarser image of a cloth, whose cells may be so uneven that ways along them come out too short.
    pub(crate) coarse: bool,
    /// How many coarser grids, from the finest on, have all pins, as of when a stepper took it in.
    pub(crate) levels_with_pins: u32,
    /// Whether its pins came when it had none, so that no tether leads to them.
    pub(crate) untethered: bool,
    /// Texture coordinates along the fabric.
    grain: Option<Arc<Vec<[f32; 2]>>>,
    /// The stitches that tie its grids to each other.
    sewing: Option<Arc<Sewing>>,
    /// The joints that it can follow.
    skin: Option<Arc<Skin>>,
    /// The matrices of these joints at the start, where it follows them.
    joints: Option<Arc<[Rows]>>,
    /// The surface of a body that it collides with.
    worn_on: Option<body::WornOn>,
}

impl Cloth {
    /// Checks the parts. Errors on lists of the wrong length, grids that leave gaps, values that are not finite, masses
    /// not above 0, negative rest lengths and seam links that do not close.
    pub fn new(parts: Parts) -> Result<Self> {
        let (ring_starts, ring_members) = check::rings(&parts)?;
        let Parts { name, grids, positions, particles, rest, mass } = parts;
        let (grids, positions, particles) = (Arc::new(grids), Arc::new(positions), Arc::new(particles));
        Ok(Cloth {
            parts: Lists { name, grids, positions, particles, rest: Arc::new(rest), mass: Arc::new(mass) },
            ring_starts: Arc::new(ring_starts),
            ring_members: Arc::new(ring_members),
            cut: false,
            uncut: None,
            stored_tethers: None,
            velocity: [0.0; 3],
            damping: 0.0,
            speed_limit: f32::INFINITY,
            thickness: None,
            friction: 1.0,
            collision_groups: u32::MAX,
            contact: None,
            skinning: Skinning::Linear,
            inertia: Inertia::default(),
            compliance: Compliance::None,
            limits: None,
            backstops: None,
            membrane: None,
            bending: None,
            exact: false,
            shear: 0.0,
            coarse: false,
            levels_with_pins: u32::MAX,
            untethered: false,
            grain: None,
            sewing: None,
            skin: None,
            joints: None,
            worn_on: None,
        })
    }

    /// Refuses a velocity, damping, thickness, friction, compliance, limit or speed limit outside their ranges.
    pub fn check(&self) -> Result<()> {
        for x in self.velocity {
            range("the velocity of a cloth [m/s]", f64::from(x), "finite", |_| true)?;
        }
        range("the damping of a cloth [1/s]", f64::from(self.damping), "at least 0", |d| d >= 0.0)?;
        let thickness = f64::from(self.thickness.unwrap_or(0.0));
        range("the thickness of a cloth [m]", thickness, "0 to 1", |t| (0.0..=1.0).contains(&t))?;
        range("the friction of a cloth", f64::from(self.friction), "0 to 1e6", |f| (0.0..=1e6).contains(&f))?;
        self.contact.iter().try_for_each(ClothContact::check)?;
        self.inertia.check()?;
        let soft: &[f32] = match &self.compliance {
            Compliance::None => &[],
            Compliance::Constant(c) => std::slice::from_ref(c),
            Compliance::Image(list) => {
                let whole = |n: f64| n == self.len() as f64;
                range("the number of compliances", list.len() as f64, "one per particle", whole)?;
                list.as_flattened()
            }
        };
        let limits = self.limits.as_deref().unwrap_or(&[]);
        if self.limits.is_some() {
            range("the number of limits", limits.len() as f64, "one per particle", |n| n == self.len() as f64)?;
            let member = |m: &u32| limits[*m as usize].max(-1.0);
            let rings = self.ring_starts.windows(2).map(|r| &self.ring_members[r[0] as usize..r[1] as usize]);
            let differ = rings.map(|ring| ring.iter().filter(|m| member(m) != member(&ring[0])).count()).sum::<usize>();
            range("the number of seam duplicates with another limit", differ as f64, "0", |n| n == 0.0)?;
        }
        for limit in limits {
            range("a limit [m]", f64::from(*limit), "finite", |_| true)?;
        }
        self.check_backstops()?;
        for c in soft {
            range("a compliance [m/N]", f64::from(*c), "at least 0", |c| c >= 0.0)?;
        }
        let limit = f64::from(self.speed_limit).min(f64::MAX);
        range("the speed limit of a cloth [m/s]", limit, "above 0", |s| s > 0.0)
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.parts.name
    }

    /// Its grids.
    pub fn grids(&self) -> &[Grid] {
        &self.parts.grids
    }

    /// Number of particle slots: the texels of all grids.
    pub fn len(&self) -> usize {
        self.parts.positions.len()
    }

    /// Whether there is no texel; never so for a checked cloth.
    pub fn is_empty(&self) -> bool {
        self.parts.positions.is_empty()
    }

    /// Positions \[m\] at the start.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.parts.positions
    }

    /// The box around all particles at the start \[m\], its low and its high corner; `None` for cloth without particles.
    pub fn bounds(&self) -> Option<([f32; 3], [f32; 3])> {
        let all = self.positions().iter().zip(self.particles());
        let mut there = all.filter(|(_, particle)| particle.exists()).map(|(at, _)| *at);
        let first = there.next()?;
        let take = |(low, high): ([f32; 3], [f32; 3]), p: [f32; 3]| {
            ([0, 1, 2].map(|c| low[c].min(p[c])), [0, 1, 2].map(|c| high[c].max(p[c])))
        };
        Some(there.fold((first, first), take))
    }

    /// The state of each particle.
    pub fn particles(&self) -> &[Particle] {
        &self.parts.particles
    }

    /// The rest lengths.
    pub fn rest(&self) -> &Rest {
        &self.parts.rest
    }

    /// Mass \[kg\] of a particle; 0 past the end.
    pub fn mass(&self, index: usize) -> f32 {
        match &*self.parts.mass {
            Mass::Constant(m) if index < self.len() => *m,
            Mass::Constant(_) => 0.0,
            Mass::Image(m) => m.get(index).copied().unwrap_or(0.0),
        }
    }

    /// The fourth component of a particle as the solver reads it: 1/mass \[1/kg\], 0 for a pinned particle, -1 for none.
    pub fn inverse_mass(&self, index: usize) -> f32 {
        match self.parts.particles.get(index) {
            None | Some(Particle::None) => -1.0,
            Some(Particle::Pinned { .. }) => 0.0,
            Some(Particle::Free { .. }) => 1.0 / self.mass(index),
        }
    }

    /// The seam rings as offsets into a list of members: ring r is `members[starts[r]..starts[r + 1]]`. Without seams
    /// the list is empty.
    pub fn rings(&self) -> (&[u32], &[u32]) {
        (&self.ring_starts, &self.ring_members)
    }

    /// Number of seam rings.
    pub fn ring_count(&self) -> usize {
        self.ring_starts.len() - 1
    }

    /// Which of the four spring directions (right, down, down-right, up-right) have any spring.
    pub fn directions(&self) -> [bool; 4] {
        let any = |lengths: &[[f32; 4]]| [0, 1, 2, 3].map(|d| lengths.iter().any(|l| l[d] > 0.0));
        match &*self.parts.rest {
            Rest::None => [false; 4],
            Rest::Constant(lengths) | Rest::Image(lengths) => any(lengths),
        }
    }

    /// Sets the initial positions \[m\]; rest lengths stay. Errors as [`Cloth::new`].
    pub fn place(&mut self, positions: Vec<[f32; 3]>) -> Result<()> {
        check::positions(self.name(), &positions, self.particles())?;
        self.parts.positions = Arc::new(positions);
        Ok(())
    }

    /// Puts particles elsewhere at the start; positions are those of another image of the same cloth.
    pub(crate) fn put(&mut self, positions: Vec<[f32; 3]>) {
        self.parts.positions = Arc::new(positions);
    }

    pub(crate) fn rename(&mut self, name: &str) {
        self.parts.name = name.into();
    }

    /// Rest length \[m\] of the spring at texel `k` of a grid in a direction; 0 where an end is not a particle.
    pub(crate) fn spring(&self, grid: usize, k: usize, direction: usize) -> f32 {
        let Grid { first, width, height, .. } = self.parts.grids[grid];
        let there = |k: usize| self.parts.particles[first as usize + k].exists();
        match (&*self.parts.rest, other_end(width as usize, height as usize, k, direction)) {
            (Rest::Constant(r), Some(other)) if there(k) && there(other) => r[grid][direction],
            (Rest::Image(r), Some(other)) if there(k) && there(other) => r[first as usize + k][direction],
            _ => 0.0,
        }
    }

    /// The particle at the other end of the spring at texel `k` of a grid, if the grid has it.
    pub(crate) fn neighbour(&self, grid: usize, k: usize, direction: usize) -> Option<usize> {
        let Grid { first, width, height, .. } = self.parts.grids[grid];
        Some(first as usize + other_end(width as usize, height as usize, k, direction)?)
    }

    /// For every particle the first duplicate of its seam point, or itself: a mesh of these particles has one vertex per point of a seam.
    pub fn points(&self) -> Vec<u32> {
        let mut same: Vec<u32> = (0..self.len() as u32).collect();
        for ring in self.ring_starts.windows(2) {
            let ring = &self.ring_members[ring[0] as usize..ring[1] as usize];
            ring.iter().for_each(|k| same[*k as usize] = ring[0]);
        }
        same
    }

    /// Compliance \[m/N\] where it is the same everywhere, else 0. Along a square cell a membrane yields by one over its
    /// stiffness; the stiffer of warp and weft counts.
    pub(crate) fn softness(&self) -> f32 {
        match (self.membrane(), &self.compliance) {
            (Some(membrane), _) => membrane.soft[0].min(membrane.soft[1]),
            (None, Compliance::Constant(soft)) => *soft,
            (None, _) => 0.0,
        }
    }

    /// Share of its rest length by which a hard diagonal may move its ends in a relaxation of a step of `dt` \[s\]; 0 means
    /// no bound.
    pub(crate) fn bound(&self, dt: f64) -> f32 {
        shear::bound(self.shear, dt)
    }

    /// Whether integration keeps what rounding takes.
    pub(crate) fn is_exact(&self) -> bool {
        self.exact
    }

    /// Texture coordinates along the fabric, if it has any.
    pub(crate) fn grain(&self) -> Option<&[[f32; 2]]> {
        self.grain.as_ref().map(|uv| &uv[..])
    }

    pub(crate) fn keep_grain(&mut self, uv: Option<Vec<[f32; 2]>>) {
        self.grain = uv.map(Arc::new);
    }

    /// Whether a cut has been made, so that triangles may be missing.
    pub(crate) fn is_cut(&self) -> bool {
        self.cut
    }

    /// From here on triangles may be missing, and springs end one by one: constant rest lengths become an image.
    pub(crate) fn open(&mut self) {
        self.cut = true;
        if let Rest::Constant(lengths) = &*self.parts.rest {
            let each = self.parts.grids.iter().zip(lengths);
            let image = Rest::Image(each.flat_map(|(g, l)| std::iter::repeat_n(*l, g.texels())).collect());
            self.uncut = Some(std::mem::replace(&mut self.parts.rest, Arc::new(image)));
        }
    }

    /// Whole again, as the cloth of a new stepper is.
    pub(crate) fn close(&mut self) {
        self.cut = false;
        if let Some(rest) = self.uncut.take() {
            self.parts.rest = rest;
        }
    }
}

#[cfg(test)]
#[path = "cloth/tests.rs"]
mod tests;
