//! A cloth in motion under the XPBD solver: sheets, what holds them, and the passes that step them.

mod anchors;
mod backstop;
mod bend;
mod coarse_level;
mod coarse_ties;
mod cut_levels;
mod follow;
mod forget;
mod integrate_rows;
mod laplacian;
pub(crate) mod leaves;
mod limit;
pub(crate) mod meeting;
mod membrane;
mod moments;
pub(crate) mod partners;
pub(crate) mod polish;
mod pyramid;
mod refine;
mod seam_moments;
pub(crate) mod seam_steps;
mod separate;
mod sew;
mod share;
mod stitch;
pub(crate) mod stretch;
mod sweep;
mod tethers;
pub(crate) mod touch;
mod tree;

use std::sync::Arc;

use self::anchors::Places;
use self::backstop::Backstop;
use self::follow::Follow;
use self::limit::Limit;
use self::meeting::Meeting;
use self::meeting::shadow::{Dawn, Shadow};
use self::membrane::Cells;
use self::moments::Plate;
use self::pyramid::Pyramid;
use self::seam_steps::Member;
use self::stitch::Stitches;
use self::stretch::{Rests, Springs};
use self::sweep::Stage;
use self::tethers::Tethers;
use super::body::Body;
use super::contact::clear::Clear;
use super::integrate::Air;
use super::neighbours::View;
use super::rows::Threads;
use super::sheet::Sheet;
use super::surface::Worn;
use super::{contact, wind};
use crate::cloth::{self, Cloth, other_end};
use crate::collider::solid::Solid;
use crate::levels::ties::{Ties, ties};
use crate::levels::{carried, levels, masses};
use crate::number::aligned::Aligned;
use crate::number::real::{Real, V3, add, dot, scale, sub};
use crate::options::Options;
use crate::passes::{self, Pass};
use crate::step::Step;

/// Sheets of a cloth, and where its particles lie in them.
pub struct Fabric<T: Real> {
    sheets: Vec<Sheet<T>>,
    springs: Vec<[Springs<T>; 4]>,
    pyramids: Vec<Pyramid<T>>,
    ties: Vec<Ties>,
    /// As [`masses`], where there are pyramids.
    masses: Arc<Vec<f64>>,
    /// One a sheet, of cloth of a material.
    cells: Arc<Vec<Cells<T>>>,
    /// One a sheet, of cloth that bends.
    plates: Vec<Plate<T>>,
    tethers: Arc<Vec<Tethers<T>>>,
    /// One a sheet, of cloth that has any.
    limits: Vec<Limit<T>>,
    /// One a sheet, of cloth that has any.
    backstops: Vec<Backstop<T>>,
    /// One a sheet, of cloth that follows joints.
    follows: Vec<Follow<T>>,
    /// Of cloth that has any.
    stitches: Option<Stitches<T>>,
    anchors: Arc<Vec<Member>>,
    places: Places<T>,
    /// Those of every ring.
    members: Arc<Vec<Member>>,
    starts: Arc<Vec<u32>>,
    firsts: Vec<usize>,
    /// Whether all texels of a sheet are particles.
    whole: Vec<bool>,
    /// One a sheet.
    clear: Vec<Clear<T>>,
    /// The surface of a body that the cloth is worn on.
    worn: Option<Worn<T>>,
    /// Of cloth that has contact with cloth.
    meeting: Option<Meeting<T>>,
    /// Accelerations by air, by texels, and of each sheet as its positions lie.
    field: Vec<[T; 4]>,
    fields: Vec<Aligned<T>>,
}

impl<T: Real> Fabric<T> {
    /// Room for a cloth; [`Fabric::load`] fills it.
    pub fn new(cloth: &Cloth, held: &cloth::Tethers, options: &Options) -> Self {
        let sheets: Vec<Sheet<T>> = cloth.grids().iter().map(Sheet::new).collect();
        let firsts = cloth.grids().iter().map(|g| g.first as usize).collect();
        let (starts, members) = cloth.ring_lists();
        let springs = sheets.iter().enumerate().map(|(g, sheet)| stretch::springs(cloth, g, sheet)).collect();
        let grids = if options.pyramid > 0 { 0..sheets.len() } else { 0..0 };
        let masses = if grids.is_empty() { Vec::new() } else { masses(cloth) };
        let pyramids: Vec<Pyramid<T>> =
            grids.map(|g| Pyramid::new(&levels(cloth, g, &masses), sheets[g].width)).collect();
        let (cells, plates) = (membrane::cells(cloth, &sheets), moments::plates(cloth, &sheets));
        let mut fabric = Fabric {
            springs,
            ties: if pyramids.is_empty() { Vec::new() } else { ties(cloth) },
            pyramids,
            masses: Arc::new(masses),
            cells: Arc::new(cells),
            plates,
            limits: limit::limits(cloth, &sheets),
            backstops: backstop::backstops(cloth, &sheets),
            follows: Vec::new(),
            worn: None,
            meeting: Meeting::of(cloth, &sheets, options.thickness),
            stitches: None,
            sheets,
            whole: cloth.grids().iter().map(|g| cloth.particles()[g.range()].iter().all(|p| p.exists())).collect(),
            tethers: Default::default(),
            anchors: Default::default(),
            places: Places::default(),
            members: Default::default(),
            starts,
            firsts,
            clear: cloth.grids().iter().map(|_| Clear::default()).collect(),
            field: Vec::new(),
            fields: Vec::new(),
        };
        fabric.worn = Worn::of(cloth, &fabric.sheets, options.thickness, |k| {
            let (sheet, at) = fabric.place(k);
            (sheet as usize, single(at as usize, fabric.sheets[sheet as usize].half), at as usize)
        });
        let members = members.iter().map(|k| fabric.member(*k)).collect();
        let stitches = stitch::stitches(cloth, |k| fabric.member(k));
        (fabric.members, fabric.stitches) = (Arc::new(members), stitches);
        let of = |t: usize| held.anchors.get(t).filter(|a| a.exists());
        fabric.hold(held.per_particle, |t| of(t).map(|a| (a.particle, T::of(f64::from(a.distance)))));
        fabric
    }

    fn place(&self, k: usize) -> (u32, u32) {
        let g = self.firsts.partition_point(|f| *f <= k) - 1;
        (g as u32, self.sheets[g].triple(k - self.firsts[g]) as u32)
    }

    /// Where a particle lies in the sheets.
    pub fn member(&self, k: u32) -> Member {
        let (sheet, at) = self.place(k as usize);
        Member { sheet, at, single: single(at as usize, self.sheets[sheet as usize].half) as u32 }
    }

    /// Takes over the tethers, `slots` per particle: the pin and the distance \[m\] of each, by particle and slot.
    pub fn hold(&mut self, slots: usize, held: impl Fn(usize) -> Option<(u32, T)>) {
        let count: usize = self.sheets.iter().map(|s| s.width * s.height).sum();
        let mut order: Vec<u32> = (0..count * slots).filter_map(|t| Some(held(t)?.0)).collect();
        order.sort_unstable();
        order.dedup();
        self.anchors = Arc::new(order.iter().map(|k| self.member(*k)).collect());
        self.places = Places::default();
        let mut tethers = Vec::with_capacity(self.sheets.len());
        for (g, sheet) in self.sheets.iter().enumerate() {
            let each = (0..slots).map(|slot| {
                tethers::Slot::new(sheet, |k| {
                    let (anchor, most) = held((self.firsts[g] + k) * slots + slot)?;
                    Some((order.binary_search(&anchor).ok()? as u32, most))
                })
            });
            tethers.push(Tethers { slots: each.collect() });
        }
        self.tethers = Arc::new(tethers);
    }

    /// Positions and inverse masses from texels.
    pub fn load(&mut self, now: &[[T; 4]], before: &[[T; 4]]) {
        self.meeting.iter_mut().for_each(Meeting::forget);
        for (sheet, first) in self.sheets.iter_mut().zip(&self.firsts) {
            let range = *first..first + sheet.width * sheet.height;
            sheet.load(&now[range.clone()], &before[range]);
            // A NaN in a texel without a particle would stay NaN when multiplied by a weight of 0.
            let gaps = (0..sheet.width * sheet.height).filter(|k| now[first + k][3] < T::of(0.0));
            if !self.plates.is_empty() {
                gaps.for_each(|k| sheet.put(sheet.triple(k), [T::of(0.0); 3]));
            }
            sheet.weigh(|k| now[first + k][3]);
        }
    }

    /// Rest lengths \[m\] by texels, after a cut; empty if there are no springs. Springs without a particle at an end are
    /// none.
    pub fn set_rest(&mut self, image: &[[T; 4]], now: &[[T; 4]]) {
        if image.is_empty() {
            return;
        }
        self.break_plates(image);
        let there = |k: usize| now[k][3] >= T::of(0.0);
        for ((sheet, springs), first) in self.sheets.iter().zip(&mut self.springs).zip(&self.firsts) {
            for (d, of) in springs.iter_mut().enumerate() {
                let length = |k: usize| {
                    let other = other_end(sheet.width, sheet.height, k, d)?;
                    (there(first + k) && there(first + other)).then_some(image[first + k][d])
                };
                of.rest = Rests::List(Arc::new(sheet.list(T::of(0.0), |k| length(k).unwrap_or(T::of(0.0)))));
            }
        }
    }

    /// Rebuilds the coarser grids from rest lengths \[m\] by texels, after a cut.
    pub fn cut_levels(&mut self, image: &[[T; 4]]) {
        for ((pyramid, sheet), first) in self.pyramids.iter_mut().zip(&self.sheets).zip(&self.firsts) {
            let range = *first..first + sheet.width * sheet.height;
            if let Some(rest) = image.get(range.clone()) {
                *pyramid = cut_levels::run(sheet.width, rest, &self.masses[range]);
            }
        }
    }

    /// As [`Springs::bound`], of all springs.
    pub fn bound_diagonals(&mut self, bound: T) {
        self.springs.iter_mut().flatten().for_each(|s| s.bound = bound);
    }

    /// Ends bending where springs are missing around a particle.
    fn break_plates(&mut self, image: &[[T; 4]]) {
        for ((sheet, plate), first) in self.sheets.iter().zip(&mut self.plates).zip(&self.firsts) {
            for k in 0..sheet.width * sheet.height {
                for (d, rest) in image[first + k].iter().enumerate() {
                    let broken = *rest <= T::of(0.0) && plate.weights.of(sheet.single(k), d) != T::of(0.0);
                    if let (true, Some(other)) = (broken, other_end(sheet.width, sheet.height, k, d)) {
                        let compliance = Arc::make_mut(&mut plate.compliance);
                        [k, other].iter().for_each(|k| compliance[sheet.single(*k)] = T::of(0.0));
                    }
                }
            }
        }
    }

    /// Triangles that are cut away leave the membrane; they are known by texels. Both of a cell that is divided otherwise. Stitches to a
    /// quad that lacks a triangle end.
    pub fn cut_cells(&mut self, holes: &[u32]) {
        if let Some(stitches) = &mut self.stitches {
            let each = stitches.holds.iter_mut().zip(&*stitches.threads);
            each.for_each(|(holds, thread)| *holds = holes[thread.cell as usize] == 0);
        }
        for ((sheet, cells), first) in self.sheets.iter().zip(Arc::make_mut(&mut self.cells)).zip(&self.firsts) {
            for k in (0..sheet.width * sheet.height).filter(|k| holes[first + k] != 0) {
                let place = sheet.single(k);
                let [p, q, r, s, e, f, g, h] = cells.inverse.each_ref().map(|list| list[place]);
                let up = p * s - q * r + e * h - f * g < T::of(0.0);
                for (triangle, bit) in [(0, 2), (4, 1)] {
                    if up || holes[first + k] & bit != 0 {
                        cells.inverse[triangle..triangle + 4].iter_mut().for_each(|list| list[place] = T::of(0.0));
                    }
                }
            }
        }
    }

    /// Positions to texels.
    pub fn store(&self, now: &mut [[T; 4]], before: &mut [[T; 4]]) {
        for (sheet, first) in self.sheets.iter().zip(&self.firsts) {
            let range = *first..first + sheet.width * sheet.height;
            sheet.store(&mut now[range.clone()], &mut before[range]);
        }
    }

    /// The position of a particle.
    #[inline]
    pub fn at(&self, member: Member) -> V3<T> {
        self.sheets[member.sheet as usize].at(member.at as usize)
    }

    /// Puts a particle at a position; the previous one is changed so that of the motion along the change only what led into it ends.
    pub fn hold_back(&mut self, member: Member, to: V3<T>) {
        let sheet = &mut self.sheets[member.sheet as usize];
        let at = member.at as usize;
        let change = sub(to, sheet.at(at));
        let long = dot(change, change).sqrt();
        if long <= T::of(0.0) {
            return;
        }
        let was: V3<T> = [0, 1, 2].map(|c| sheet.before[at + 2 * c * sheet.half]);
        let ahead = dot(sub(sheet.at(at), was), change) / long;
        // Contact pushes and lets previous positions follow: a push that is held back must leave no speed the other way.
        let follows = (ahead + long).min(long).max(T::of(0.0)) / long;
        let was = add(was, scale(change, follows));
        sheet.put(at, to);
        for (c, was) in was.into_iter().enumerate() {
            let place = at + 2 * c * sheet.half;
            sheet.before[place] = was;
            if let Some(lost) = sheet.lost.get_mut(place) {
                *lost = T::of(0.0);
            }
        }
    }

    /// The low bits that positions are too coarse for, to texels; where none are kept these stay.
    pub fn store_lost(&self, texels: &mut [[T; 4]]) {
        for (sheet, first) in self.sheets.iter().zip(&self.firsts) {
            sheet.store_lost(&mut texels[*first..first + sheet.width * sheet.height]);
        }
    }

    /// The same from texels; to be called after [`Fabric::load`].
    pub fn load_lost(&mut self, texels: &[[T; 4]]) {
        for (sheet, first) in self.sheets.iter_mut().zip(&self.firsts) {
            sheet.load_lost(&texels[*first..*first + sheet.width * sheet.height]);
        }
    }

    /// The shadow of cloth that has contact, for other cloths in a frame.
    pub fn shadow(&mut self, dawn: &Dawn<T>) -> Option<Shadow<T>> {
        self.meeting.as_mut().map(|meeting| meeting.shadow(dawn))
    }

    /// Takes in the shadows of all cloths, its own at `own`. Returns the cloths that are asleep and wake.
    pub fn meet(&mut self, shadows: &[Option<Shadow<T>>], own: usize) -> Vec<usize> {
        self.meeting.as_mut().map_or(Vec::new(), |meeting| meeting.meet(shadows, own))
    }

    /// Takes in where particles of other cloths that it may meet are now.
    pub fn follow_others(&mut self, shadows: &[Option<Shadow<T>>], own: usize) {
        self.meeting.iter_mut().for_each(|meeting| meeting.follow(shadows, own));
    }

    /// Searches contact afresh in the next step.
    pub fn forget_contact(&mut self) {
        self.meeting.iter_mut().for_each(Meeting::forget);
        self.forget_surface();
    }

    /// Searches the nearest points of a body afresh in the next step, where particles may be anywhere.
    pub fn forget_surface(&mut self) {
        self.worn.iter_mut().for_each(Worn::forget);
    }

    /// Takes back its shadow.
    pub fn keep(&mut self, shadow: Shadow<T>) {
        if let Some(meeting) = &mut self.meeting {
            meeting.keep(shadow);
        }
    }

    /// Forgets what holds within a frame only.
    pub fn begin(&mut self) {
        self.clear.iter_mut().for_each(Clear::begin);
        self.worn.iter_mut().for_each(Worn::begin);
    }

    /// Runs the passes of a step, those that can in one walk down each sheet.
    pub fn step<'a>(
        &mut self,
        passes: impl Iterator<Item = &'a Pass>,
        threads: &Threads,
        step: &Step<T>,
        solids: &[Solid<T>],
        body: &mut Body<T>,
    ) {
        self.meeting.iter_mut().for_each(|m| m.elapsed = m.elapsed + step.dt);
        if let Some(worn) = &mut self.worn {
            worn.search(&self.sheets, &self.firsts);
        }
        let mut together = Vec::new();
        for pass in passes {
            if self.walks(*pass, threads) {
                together.push(*pass);
                continue;
            }
            self.walk(&together, step);
            together.clear();
            self.run(*pass, threads, step, solids, body);
        }
        self.walk(&together, step);
    }

    /// Whether a pass reaches no farther than the next row, on this thread.
    fn walks(&self, pass: Pass, threads: &Threads) -> bool {
        let reaches = match pass {
            Pass::Stretch { direction, .. } => !self.springs.iter().all(|s| s[direction as usize & 3].are_hard()),
            Pass::Integrate(passes::Air::None) | Pass::Tethers { .. } | Pass::Polish { .. } => false,
            _ => true,
        };
        !reaches && self.sheets.iter().all(|s| threads.alone(&s.now))
    }

    fn walk(&mut self, passes: &[Pass], step: &Step<T>) {
        if passes.iter().any(|pass| matches!(pass, Pass::Tethers { .. })) {
            self.find_anchors();
        }
        for (g, sheet) in self.sheets.iter_mut().enumerate().filter(|_| !passes.is_empty()) {
            let stage = |pass: &Pass| match *pass {
                Pass::Stretch { direction, parity, .. } => {
                    Stage::Springs(&self.springs[g][direction as usize & 3], (direction & 3, parity), false)
                }
                Pass::Polish { direction, parity, .. } => {
                    Stage::Springs(&self.springs[g][direction as usize & 3], (direction & 3, parity), true)
                }
                Pass::Tethers { .. } => Stage::Tethers(&self.tethers[g], self.places.of(g)),
                _ => Stage::Integrate(step),
            };
            let stages: Vec<_> = passes.iter().map(stage).collect();
            sweep::run(sheet, &stages);
        }
    }

    /// Runs a pass of a step; false if it is not one, and nothing was done. Wind needs the texels of `body`.
    pub fn run(
        &mut self,
        pass: Pass,
        threads: &Threads,
        step: &Step<T>,
        solids: &[Solid<T>],
        body: &mut Body<T>,
    ) -> bool {
        match pass {
            Pass::Wind { holes } => self.wind(threads, step, body, holes),
            Pass::Integrate(air) | Pass::IntegrateExact(air) => {
                let exact = matches!(pass, Pass::IntegrateExact(_));
                for (g, sheet) in self.sheets.iter_mut().enumerate() {
                    let air = match air {
                        passes::Air::None => Air::None,
                        passes::Air::Push => Air::Push,
                        passes::Air::Field => Air::Field(&self.fields[g]),
                    };
                    integrate_rows::run(threads, step, sheet, air, exact);
                }
            }
            Pass::Membrane { column, row, .. } => {
                let at = (column as usize, row as usize);
                let each = self.sheets.iter_mut().zip(&*self.cells);
                each.for_each(|(sheet, cells)| membrane::run(threads, sheet, cells, at, step.dt));
            }
            Pass::Moments { .. } => {
                let each = self.sheets.iter().zip(&mut self.plates);
                each.for_each(|(sheet, plate)| moments::run(threads, sheet, plate, step.dt));
            }
            Pass::SeamMoments => self.seam_moments(),
            Pass::Bend => {
                let each = self.sheets.iter_mut().zip(&self.plates);
                each.for_each(|(sheet, plate)| bend::run(threads, sheet, plate));
            }
            Pass::Stretch { direction, parity, again, .. } => {
                for (sheet, springs) in self.sheets.iter_mut().zip(&mut self.springs) {
                    let springs = &mut springs[direction as usize & 3];
                    stretch::run(threads, sheet, springs, (direction, parity), again, step.dt);
                }
            }
            Pass::Polish { direction, parity, .. } => {
                for (sheet, springs) in self.sheets.iter_mut().zip(&mut self.springs) {
                    polish::run(threads, sheet, &mut springs[direction as usize & 3], (direction, parity));
                }
            }
            Pass::Forget => {
                for (sheet, springs) in self.sheets.iter().zip(&mut self.springs) {
                    springs.iter_mut().for_each(|s| forget::run(&mut s.sums, sheet.w.len()));
                }
            }
            Pass::Tethers { .. } => {
                self.find_anchors();
                for (g, (sheet, held)) in self.sheets.iter_mut().zip(&*self.tethers).enumerate() {
                    tethers::run(threads, sheet, held, &self.places.of(g));
                }
            }
            Pass::Follow => {
                let each = self.sheets.iter_mut().zip(&self.follows);
                each.for_each(|(sheet, follow)| follow::run(sheet, follow, step.left));
            }
            Pass::Limit { .. } => {
                let each = self.sheets.iter_mut().zip(&self.limits);
                each.for_each(|(sheet, limit)| limit::run(threads, sheet, limit, step.left));
            }
            Pass::Backstop { .. } => {
                let each = self.sheets.iter_mut().zip(&self.backstops);
                each.for_each(|(sheet, backstop)| backstop::run(threads, sheet, backstop, step.left));
            }
            Pass::Stitch { .. } => {
                self.stitches.iter_mut().for_each(|stitches| stitch::run(&self.sheets, stitches));
            }
            Pass::Sew => self.stitches.iter().for_each(|stitches| sew::run(&mut self.sheets, stitches)),
            Pass::Pyramid { directions, cut, finest, .. } => {
                let descent = pyramid::Descent { present: &directions, cut, finest: finest as usize };
                pyramid::run(&mut self.pyramids, &self.sheets, threads, descent, &self.ties);
            }
            Pass::CoarseLevel { level, directions, .. } => {
                coarse_level::run(&mut self.pyramids, threads, &directions, level as usize);
            }
            Pass::CoarseTies { level, cut } => {
                coarse_ties::run(&mut self.pyramids, level as usize, cut, &self.ties);
            }
            Pass::Refine { seams, .. } => {
                let each = self.pyramids.iter().zip(&mut self.sheets);
                each.for_each(|(pyramid, sheet)| refine::run(pyramid, sheet, carried(seams)));
            }
            Pass::Seams => self.seams(),
            Pass::SeamSteps => seam_steps::run(&mut self.sheets, &self.starts, &self.members),
            Pass::Leaves => self.meeting.iter_mut().for_each(|m| m.leaves(&self.sheets)),
            Pass::Tree => self.meeting.iter_mut().for_each(Meeting::refit),
            Pass::Partners { .. } => self.meeting.iter_mut().for_each(|m| m.search(threads)),
            Pass::Touch => self.meeting.iter_mut().for_each(|m| m.touch(&self.sheets, threads, step.dt)),
            Pass::Separate => self.meeting.iter().for_each(|m| m.separate(&mut self.sheets)),
            Pass::Contact(_) => {
                self.worn.iter().for_each(|worn| worn.run(threads, &mut self.sheets, step));
                let posed: Vec<_> = solids.iter().map(|s| s.posed(step.left)).collect();
                let each = self.sheets.iter_mut().zip(&mut self.clear);
                each.for_each(|(sheet, clear)| contact::run(threads, sheet, clear, &posed, (step.dt, step.left)));
            }
            // Passes of the classic solver, of a frame and of actions, which are made from texels.
            Pass::Springs { .. }
            | Pass::Colliders(_)
            | Pass::Guard
            | Pass::Restore
            | Pass::Normals { .. }
            | Pass::SeamNormals
            | Pass::Speed
            | Pass::Fastest
            | Pass::Strain { .. }
            | Pass::Cut
            | Pass::CutSprings
            | Pass::CutTethers { .. }
            | Pass::CutLevels
            | Pass::Transform
            | Pass::Place
            | Pass::Inertia
            | Pass::Skin { .. }
            | Pass::Restrict
            | Pass::Prolong
            | Pass::Pick { .. }
            | Pass::PickNearest
            | Pass::Bounds
            | Pass::Indices { .. }
            | Pass::Tangents { .. }
            | Pass::Wrap => return false,
        }
        true
    }

    fn wind(&mut self, threads: &Threads, step: &Step<T>, body: &mut Body<T>, holes: bool) {
        self.fields.resize_with(self.sheets.len(), Aligned::default);
        for (sheet, field) in self.sheets.iter().zip(&mut self.fields) {
            if field.len() != sheet.now.len() {
                *field = Aligned::zeros(sheet.now.len());
            }
        }
        if holes || self.whole.contains(&false) {
            self.field.resize(body.now.len(), [T::of(0.0); 4]);
            self.store(&mut body.now, &mut body.before);
        }
        let direct = self.whole.iter().map(|whole| *whole && !holes);
        let (now, before, holes) = (&body.now, &body.before, &body.holes);
        let each = self.sheets.iter().zip(&self.firsts).zip(&mut self.fields).zip(direct);
        for (((sheet, first), field), direct) in each {
            if direct {
                wind::of_sheet(threads, step, sheet, field);
                continue;
            }
            let range = *first..first + sheet.width * sheet.height;
            let holes = holes.get(range.clone()).unwrap_or(&[]);
            let view = View { now: &now[range.clone()], width: sheet.width, holes };
            wind::run(threads, step, view, &before[range.clone()], &mut self.field[range.clone()]);
            sheet.arrange(&self.field[range], field);
        }
    }

    fn seam_moments(&mut self) {
        seam_moments::run(&mut self.plates, &self.starts, &self.members);
    }

    fn seams(&mut self) {
        for ring in self.starts.windows(2) {
            seam_steps::close(&mut self.sheets, &self.members[ring[0] as usize..ring[1] as usize], |s| &mut s.now);
        }
    }
}

/// From a place of x in `now` to the place in `w`.
fn single(triple: usize, half: usize) -> usize {
    triple / (6 * half) * 2 * half + triple % (6 * half)
}
