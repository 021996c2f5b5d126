//! The passes of a step, those that can in one walk down each sheet.

use super::meeting::Meeting;
use super::sweep::{self, Stage};
use super::{
    Fabric, backstop, bend, coarse_level, coarse_ties, follow, forget, integrate_rows, limit, membrane, moments,
    polish, pyramid, refine, seam_moments, seam_steps, sew, stitch, stretch, tethers,
};
use crate::collider::solid::Solid;
use crate::cpu::body::Body;
use crate::cpu::contact::{self, Posed, clear::Clear};
use crate::cpu::integrate::Air;
use crate::cpu::rows::Threads;
use crate::cpu::surface::Worn;
use crate::levels::carried;
use crate::number::aligned::Aligned;
use crate::number::real::Real;
use crate::passes::{self, Pass};
use crate::step::Step;

impl<T: Real> Fabric<T> {
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
        self.places.found = false;
        self.meeting.iter_mut().for_each(|m| m.elapsed = m.elapsed + step.dt);
        if let Some(worn) = &mut self.worn {
            worn.search(&self.sheets, &self.firsts);
        }
        let mut together = std::mem::take(&mut self.together);
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
        together.clear();
        self.together = together;
    }

    /// Whether a pass reaches no farther than the next row, on this thread.
    fn walks(&self, pass: Pass, threads: &Threads) -> bool {
        let reaches = match pass {
            Pass::Stretch { direction, .. } => !self.springs.iter().all(|s| s[direction as usize & 3].are_hard()),
            Pass::Integrate(_) | Pass::Tethers { .. } | Pass::Polish { .. } => false,
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
                Pass::Integrate(air) => Stage::Integrate(step, moving(air, self.fields.get(g))),
                _ => Stage::Integrate(step, Air::None),
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
            Pass::Gust => self.gust(threads, step),
            Pass::Wind { gusts, holes } => self.wind(threads, step, body, (gusts, holes)),
            Pass::Integrate(air) | Pass::IntegrateExact(air) => {
                let exact = matches!(pass, Pass::IntegrateExact(_));
                for (g, sheet) in self.sheets.iter_mut().enumerate() {
                    let air = moving(air, self.fields.get(g));
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
            Pass::Touch { .. } => self.meeting.iter_mut().for_each(|m| m.touch(&self.sheets, threads, step.dt)),
            Pass::Separate => self.meeting.iter().for_each(|m| m.separate(&mut self.sheets)),
            Pass::SurfaceContact => self.worn.iter().for_each(|worn| worn.run(threads, &mut self.sheets, step)),
            Pass::Contact(_) => {
                let posed = Posed::new(solids.iter().map(|s| s.posed(step.left)), step.dt, step.left);
                let each = self.sheets.iter_mut().zip(&mut self.clear);
                each.for_each(|(sheet, clear)| contact::run(threads, sheet, clear, &posed));
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
            | Pass::Wrap { .. }
            | Pass::Jump
            | Pass::WrapIndices
            | Pass::Blend { .. }
            // Of a frame, on the GPU.
            | Pass::SurfacePose { .. }
            | Pass::SurfaceBoxes
            | Pass::SurfaceSearch
            // Of all cloths of a scene together, between their steps.
            | Pass::Shadow
            | Pass::Extents
            | Pass::Others
            | Pass::Faces { .. }
            | Pass::Gather { .. }
            | Pass::Paths
            | Pass::Truncate
            | Pass::HoldBack { .. } => return false,
        }
        true
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

/// The air of a sheet, from the forces on its triangles.
fn moving<T: Real>(air: passes::Air, field: Option<&Aligned<T>>) -> Air<'_, T> {
    match air {
        passes::Air::None => Air::None,
        passes::Air::Push => Air::Push,
        passes::Air::Field => Air::Field(field.map_or(&[], |field| field)),
    }
}
