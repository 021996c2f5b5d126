//! A cloth in motion on the CPU.

use std::sync::Arc;

use super::fabric::Fabric;
use super::fabric::meeting::shadow::{Dawn, Shadow};
use super::fastest::larger;
use super::integrate::Air;
use super::lazy::Lazy;
use super::neighbours::View;
use super::route::Held;
use super::rows::Threads;
use super::start::Start;
use super::strain::Springs;
use super::{
    colliders, fastest, guard, gust, integrate, normals, restore, seam_normals, seams, skin, speed, springs, strain,
    wind,
};
use crate::choose::Settings;
use crate::cloth::{Cloth, Compliance, Grid, Poses, Rest, Rows, Tethers};
use crate::collider::solid::Solid;
use crate::memory::Tally;
use crate::number::real::{Real, cast};
use crate::options::Solver;
use crate::passes::{self, Pass, Soft};
use crate::step::Step;

/// Positions, previous positions and normals, and what the passes read beside them. The fourth component of a position
/// is the inverse mass. Normals are made when they are read, of the positions then.
pub struct Body<T: Real> {
    pub(super) now: Vec<[T; 4]>,
    pub(super) before: Vec<[T; 4]>,
    normals: Lazy<[T; 4]>,
    /// Triangles that are cut away, by texel; empty until the first cut.
    pub holes: Vec<u32>,
    /// Square of the longest displacement \[m^2\] in the last step of a frame, if that is asked for.
    pub fastest: T,
    /// The largest residual of springs at the end of a frame, if that is asked for.
    pub strain: Option<T>,
    partial: Vec<T>,
    /// Where particles were at the end of the last good frame; empty for the classic solver.
    pub(super) good: Vec<[T; 4]>,
    /// How many particles were nowhere at the end of the last frame, and the last of them.
    pub faulty: Option<(usize, usize)>,
    field: Vec<[T; 4]>,
    airs: Vec<[T; 4]>,
    pub(super) grids: Vec<Grid>,
    constant: Vec<[T; 4]>,
    pub(super) image: Arc<Vec<[T; 4]>>,
    /// Compliance of all springs, or of each.
    soft: T,
    softs: Arc<Vec<[T; 4]>>,
    starts: Arc<Vec<u32>>,
    members: Arc<Vec<u32>>,
    pub(super) fabric: Option<Box<Fabric<T>>>,
    /// Pins and tethers that hold it, from the first cut on.
    pub(crate) held: Option<Held<T>>,
    /// Whether texels were changed from outside since the last frame.
    pub(super) edited: bool,
    /// Whether a cut was made since then.
    pub(super) cut: bool,
}

impl<T: Real> Body<T> {
    /// A cloth at its start; its previous positions are those of a step of `dt` \[s\] ago.
    pub fn new(cloth: &Cloth, tethers: &Tethers, options: &Settings, dt: f64) -> Self {
        let Start { now, before, normals } = Start::new(cloth, options, dt);
        let list = |rest: &[[f32; 4]]| rest.iter().map(|r| cast(*r)).collect();
        let (constant, image) = match cloth.rest() {
            Rest::None => (Vec::new(), Vec::new()),
            Rest::Constant(r) => (list(r), Vec::new()),
            Rest::Image(r) => (Vec::new(), list(r)),
        };
        let (starts, members) = cloth.ring_lists();
        Body {
            good: if options.solver == Solver::Xpbd { now.clone() } else { Vec::new() },
            now,
            before,
            normals: Lazy::new(normals),
            holes: Vec::new(),
            fastest: T::of(0.0),
            strain: None,
            partial: Vec::new(),
            faulty: None,
            field: Vec::new(),
            airs: Vec::new(),
            grids: cloth.grids().to_vec(),
            constant,
            image: Arc::new(image),
            soft: T::of(cloth.softness().into()),
            softs: Arc::new(if let Compliance::Image(soft) = &cloth.compliance { list(soft) } else { Vec::new() }),
            starts,
            members,
            fabric: (options.solver == Solver::Xpbd).then(|| Box::new(Fabric::new(cloth, tethers, options))),
            held: None,
            edited: true,
            cut: false,
        }
    }

    /// Takes the lists that are only read from another instance of the same cloth, neither of which is cut.
    pub fn share(&mut self, other: &Self) {
        (self.image, self.softs) = (other.image.clone(), other.softs.clone());
        (self.starts, self.members) = (other.starts.clone(), other.members.clone());
        if let (Some(own), Some(others)) = (&mut self.fabric, &other.fabric) {
            own.share(others);
        }
    }

    /// Counts its lists. Seams are those of the description.
    pub fn tally(&self, tally: &mut Tally) {
        tally.image(&self.image);
        tally.image(&self.softs);
        [&self.now, &self.before, &self.good, &self.field, &self.airs].into_iter().for_each(|list| tally.state(list));
        tally.state(&self.holes);
        tally.state(&self.partial);
        // Normals, once they are asked for.
        tally.state(self.normals.known());
        self.fabric.iter().for_each(|fabric| fabric.tally(tally));
    }

    /// Number of its particles.
    pub fn count(&self) -> usize {
        self.now.len()
    }

    /// Whether there is room for cuts.
    pub fn is_cut(&self) -> bool {
        !self.holes.is_empty()
    }

    /// Positions.
    pub fn now(&self) -> &[[T; 4]] {
        &self.now
    }

    /// Unit normals by texels: of the start, then of the last frame that has the pass `normals`.
    pub fn normals(&self, threads: &Threads) -> &[[T; 4]] {
        self.normals.get(|normals| {
            make_normals(threads, &self.grids, (&self.now, &self.holes), (&self.starts, &self.members), normals);
        })
    }

    /// Normals have to be made again.
    pub fn forget_normals(&mut self) {
        self.normals.forget();
    }

    /// Positions one step before.
    pub fn before(&self) -> &[[T; 4]] {
        &self.before
    }

    /// Share of its rest length by which a hard diagonal may move its ends from here on; 0 means no bound.
    pub fn bound_diagonals(&mut self, bound: T) {
        if let Some(fabric) = &mut self.fabric {
            fabric.bound_diagonals(bound);
        }
    }

    /// From here on these are the targets \[m\] of the limits, and the limits, and the spheres of backstops.
    pub fn aim(&mut self, targets: &[[f32; 4]], spheres: &[[f32; 4]]) {
        if let Some(fabric) = &mut self.fabric {
            fabric.aim(targets, spheres);
        }
    }

    /// Takes in which particles follow joints while they are pinned, in ascending order.
    pub fn join(&mut self, joined: &[u32]) {
        if let Some(fabric) = &mut self.fabric {
            fabric.join(joined);
        }
    }

    /// The joints have moved; `rate` \[1/s\] is one over the length of the frame in which particles go from where the last call put them
    /// to where this one does, 0 if they are there at once.
    pub fn lead(&mut self, cloth: &Cloth, joined: &[u32], matrices: &[Rows], rate: T) {
        let (Some(fabric), Some(skin)) = (&mut self.fabric, cloth.skin()) else { return };
        let poses = Poses::new(cloth.skinning, matrices);
        let at = |particles: &[u32]| skin::run(skin, particles.iter().copied(), &poses);
        let behind = |points: &[(u32, [f32; 3])]| skin::points(skin, points, &poses);
        fabric.lead(&at(joined), at, behind, rate);
        fabric.lead_surface(&poses, rate);
    }

    /// The shadow of cloth that has contact, for other cloths in a frame of `length` \[s\]; `rate` \[1/s\] is one over the length of the last
    /// step, or 0 for cloth that is asleep, which contact at a speed above `wakes_at` \[m/s\] wakes.
    pub(crate) fn shadow(&mut self, rate: T, length: T, wakes_at: T) -> Option<Shadow<T>> {
        let dawn = Dawn { now: &self.now, before: &self.before, rate, length, wakes_at };
        self.fabric.as_mut()?.shadow(&dawn)
    }

    /// Takes in the shadows of all cloths, its own at `own`. Returns the cloths that are asleep and wake.
    pub(crate) fn meet(&mut self, shadows: &[Option<Shadow<T>>], own: usize) -> Vec<usize> {
        self.fabric.as_mut().map_or(Vec::new(), |fabric| fabric.meet(shadows, own))
    }

    /// Takes in where the particles that it found in other cloths are now.
    pub(crate) fn follow_others(&mut self, shadows: &[Option<Shadow<T>>], own: usize) {
        self.fabric.iter_mut().for_each(|fabric| fabric.follow_others(shadows, own));
    }

    /// Searches contact afresh in the next step, as cloth does that a state was loaded into.
    pub(crate) fn forget_contact(&mut self) {
        self.fabric.iter_mut().for_each(|fabric| fabric.forget_contact());
    }

    /// Searches the nearest points of a body afresh in the next step, as particles may be anywhere.
    pub(super) fn forget_surface(&mut self) {
        self.fabric.iter_mut().for_each(|fabric| fabric.forget_surface());
    }

    /// Positions so far, to texels, in the middle of a frame.
    pub(crate) fn show(&mut self) {
        self.end();
    }

    /// The state under the XPBD solver.
    pub(crate) fn fabric(&self) -> Option<&Fabric<T>> {
        self.fabric.as_deref()
    }

    pub(crate) fn fabric_mut(&mut self) -> Option<&mut Fabric<T>> {
        self.fabric.as_deref_mut()
    }

    /// Takes back its shadow.
    pub(crate) fn keep(&mut self, shadow: Shadow<T>) {
        if let Some(fabric) = &mut self.fabric {
            fabric.keep(shadow);
        }
    }

    /// To be called before the steps of a frame.
    pub fn begin(&mut self) {
        if let Some(fabric) = self.fabric.as_mut().filter(|_| self.edited) {
            fabric.load(&self.now, &self.before);
            if !self.holes.is_empty() {
                fabric.set_rest(&self.image, &self.now);
                fabric.cut_cells(&self.holes);
            }
            if std::mem::take(&mut self.cut) {
                fabric.cut_levels(&self.image);
            }
            self.edited = false;
        }
        self.fabric.iter_mut().for_each(|fabric| fabric.begin());
    }

    /// To be called after the steps of a frame, before its normals.
    pub fn end(&mut self) {
        if let Some(fabric) = &self.fabric {
            fabric.store(&mut self.now, &mut self.before);
        }
    }

    /// Runs the passes of a step.
    pub fn step<'a>(
        &mut self,
        passes: impl Iterator<Item = &'a Pass>,
        threads: &Threads,
        step: &Step<T>,
        solids: &[Solid<T>],
    ) {
        let Some(mut fabric) = self.fabric.take() else {
            passes.for_each(|pass| _ = self.run(*pass, threads, step, solids));
            return;
        };
        fabric.step(passes, threads, step, solids, self);
        self.fabric = Some(fabric);
    }

    /// Runs one pass on texels; false if it is not one of those, and nothing was done.
    pub fn run(&mut self, pass: Pass, threads: &Threads, step: &Step<T>, solids: &[Solid<T>]) -> bool {
        match pass {
            Pass::Gust => {
                self.airs.resize(self.now.len(), [T::of(0.0); 4]);
                gust::run(threads, step, &self.now, &mut self.airs);
            }
            Pass::Wind { gusts, .. } => {
                self.field.resize(self.now.len(), [T::of(0.0); 4]);
                for g in &self.grids {
                    let view = view(&self.now, &self.holes, g);
                    let airs = if gusts { &self.airs[g.range()] } else { &[] };
                    wind::run(threads, step, view, [&self.before[g.range()], airs], &mut self.field[g.range()]);
                }
            }
            Pass::Integrate(air) => {
                let air = match air {
                    passes::Air::None => Air::None,
                    passes::Air::Push => Air::Push,
                    passes::Air::Field => Air::Field(&self.field),
                };
                integrate::run(threads, step, &mut self.now, &mut self.before, air);
            }
            Pass::Springs { direction, parity, image } => self.springs(threads, (direction, parity), image),
            Pass::Seams => seams::run(&mut self.now, &self.starts, &self.members),
            Pass::Colliders(_) => colliders::run(threads, &mut self.now, &self.before, solids, step.dt),
            Pass::Normals { .. } | Pass::SeamNormals => self.normals.forget(),
            Pass::Guard => self.faulty = guard::run(&self.now),
            Pass::Restore => {
                self.edited |= self.faulty.is_some();
                restore::run(self.faulty.is_some(), &mut self.now, &mut self.before, &mut self.good);
            }
            Pass::Speed => speed::run(threads, &self.now, &self.before, &mut self.partial),
            Pass::Fastest => self.fastest = fastest::run(&self.partial),
            Pass::Strain { image, soft } => self.strain(threads, (image, soft), step.dt),
            // Passes of sheets, and of actions.
            _ => return false,
        }
        true
    }

    fn springs(&mut self, threads: &Threads, colour: (u32, u32), image: bool) {
        for (index, g) in self.grids.iter().enumerate() {
            let (now, width) = (&mut self.now[g.range()], g.width as usize);
            let d = colour.0 as usize;
            if image {
                let rest = &self.image[g.range()];
                springs::run(threads, now, width, colour, |k| rest[k][d]);
            } else {
                let length = self.constant[index][d];
                springs::run(threads, now, width, colour, |_| length);
            }
        }
    }

    fn strain(&mut self, threads: &Threads, (image, soft): (bool, Soft), dt: T) {
        let mut most = T::of(0.0);
        for (index, g) in self.grids.iter().enumerate() {
            let length = |k: usize, d: usize| if image { self.image[g.range()][k][d] } else { self.constant[index][d] };
            let gives = |k: usize, d: usize| match soft {
                Soft::None => T::of(0.0),
                Soft::Constant => self.soft,
                Soft::Image => self.softs[g.range()][k][d],
            };
            let springs = Springs { now: &self.now[g.range()], width: g.width as usize, length, gives, dt };
            most = larger(most, strain::run(threads, &springs, &mut self.partial));
        }
        self.strain = Some(most);
    }

    /// Makes room for cuts.
    pub fn open(&mut self, cloth: &Cloth, tethers: &Tethers) {
        if self.holes.is_empty() {
            self.holes = vec![0; self.now.len()];
            if let (true, Rest::Image(lengths)) = (self.image.is_empty(), cloth.rest()) {
                self.image = Arc::new(lengths.iter().map(|l| cast(*l)).collect());
            }
            let held = tethers.per_particle > 0 && !self.image.is_empty();
            self.held = held.then(|| Held::new(cloth, tethers));
        }
    }
}

/// Normals of particles at some positions, from the triangles that are left; all duplicates of a seam point have the same.
pub(crate) fn make_normals<T: Real>(
    threads: &Threads,
    grids: &[Grid],
    (now, holes): (&[[T; 4]], &[u32]),
    (starts, members): (&[u32], &[u32]),
    normals: &mut [[T; 4]],
) {
    for g in grids {
        normals::run(threads, view(now, holes, g), &mut normals[g.range()]);
    }
    seam_normals::run(normals, starts, members);
}

/// One grid of a cloth.
pub(crate) fn view<'a, T>(now: &'a [[T; 4]], holes: &'a [u32], grid: &Grid) -> View<'a, T> {
    let holes = holes.get(grid.range()).unwrap_or(&[]);
    View { now: &now[grid.range()], width: grid.width as usize, holes }
}
