//! The drawn surface of all cloths of a stepper, frame by frame.

use gimage::reconstruct::{ReconstructedPiece, Reconstruction};
use gimage_runtime::{Cloth, Stepper};

use crate::commands::engine::Engine;
use crate::commands::faults::is_lost;
use crate::exit::Failure;

/// The vertex of a particle without one.
const NONE: u32 = u32::MAX;
/// The normal of a vertex whose triangles have none, as `gimage reconstruct` has it.
pub const NO_NORMAL: [f32; 3] = [0.0, 0.0, 1.0];

/// The surface, and where its vertices come from.
pub struct GridSource {
    surface: Reconstruction,
    cloths: Vec<Welded>,
}

/// A cloth whose seam points are one vertex each.
struct Welded {
    cloth: Cloth,
    /// The first duplicate of each particle.
    points: Vec<u32>,
    uv: Vec<[f32; 2]>,
    /// The vertex of the surface at each first duplicate.
    vertices: Vec<u32>,
    /// The particles with a vertex, in the order of the vertices.
    particles: Vec<u32>,
    /// As [`Stepper::holes`].
    holes: Vec<u32>,
}

impl GridSource {
    /// The surface of the cloths at the start: a vertex for each point that has a triangle, so that cuts do not change vertices. Refuses
    /// cloths without triangles.
    pub fn new(stepper: &Stepper) -> Result<Self, Failure> {
        let mut count = 0;
        let cloths = stepper.scene().cloths.iter().map(|cloth| Welded::new(cloth, &mut count)).collect();
        let mut source = GridSource { surface: Reconstruction::default(), cloths };
        source.gather();
        if source.surface.triangles.is_empty() {
            let name = &stepper.scene().name;
            return Err(Failure::refused(format!("{name}: no cloth has a triangle; there is nothing to export")));
        }
        Ok(source)
    }

    /// Triangles and pieces.
    fn gather(&mut self) {
        let Reconstruction { triangles, pieces, .. } = &mut self.surface;
        (*triangles, *pieces) = Default::default();
        self.cloths.iter().for_each(|welded| welded.gather(triangles, pieces));
    }

    /// Triangles, pieces and the positions of the last frame.
    pub fn surface(&self) -> &Reconstruction {
        &self.surface
    }

    /// The surface as it is, at a fraction of the last step. Refuses positions that are not finite or too far away.
    pub fn read(&mut self, engine: &Engine, fraction: f32) -> Result<&Reconstruction, Failure> {
        let mut is_cut = false;
        (self.surface.positions, self.surface.normals) = Default::default();
        for (index, welded) in self.cloths.iter_mut().enumerate() {
            let holes = engine.holes(index)?;
            if holes != welded.holes {
                (welded.holes, is_cut) = (holes, true);
            }
            let (now, normals) = (engine.positions(index)?, engine.normals(index)?);
            refuse_lost(engine, index, &now)?;
            let before = if fraction < 1.0 { Some(engine.previous(index)?) } else { None };
            let at = |k: &u32| {
                let k = *k as usize;
                let mixed = |before: &Vec<[f32; 4]>, c: usize| before[k][c] + (now[k][c] - before[k][c]) * fraction;
                [0, 1, 2].map(|c| before.as_ref().map_or(now[k][c], |before| mixed(before, c)))
            };
            let normal = |k: &u32| {
                let [x, y, z, _] = normals[*k as usize];
                if [x, y, z] == [0.0; 3] { NO_NORMAL } else { [x, y, z] }
            };
            self.surface.positions.extend(welded.particles.iter().map(at));
            self.surface.normals.extend(welded.particles.iter().map(normal));
        }
        if is_cut {
            self.gather();
        }
        Ok(&self.surface)
    }
}

/// Refuses a cloth whose positions are not finite or too far away.
pub fn refuse_lost(engine: &Engine, cloth: usize, now: &[[f32; 4]]) -> Result<(), Failure> {
    let Some(particle) = now.iter().position(is_lost) else { return Ok(()) };
    let (name, time) = (engine.stepper.scene().cloths[cloth].name(), engine.time());
    Err(Failure::refused(format!(
        "cloth '{name}': particle {particle} is not finite or farther than 1e8 m away at {time:.3} s; no file is written; use \
         more --substeps, or smaller forces, speeds and stiffnesses, or --solver xpbd, which contains overflows"
    )))
}

impl Welded {
    /// Numbers the vertices of a cloth from `count` on.
    fn new(cloth: &Cloth, count: &mut u32) -> Self {
        let (points, uv, len) = (cloth.points(), cloth.uv(), cloth.len());
        let (vertices, particles, holes) = (vec![NONE; len], Vec::new(), Vec::new());
        let mut welded = Welded { cloth: cloth.clone(), points, uv, vertices, particles, holes };
        for corners in welded.triangles() {
            corners.iter().for_each(|k| welded.vertices[welded.points[*k as usize] as usize] = 0);
        }
        for (vertex, particle) in welded.vertices.iter_mut().zip(0..).filter(|(vertex, _)| **vertex != NONE) {
            *vertex = *count;
            *count += 1;
            welded.particles.push(particle);
        }
        welded
    }

    /// The drawn triangles of particles, but for those with two corners at one seam point.
    fn triangles(&self) -> Vec<[u32; 3]> {
        let indices = self.cloth.indices_left(&self.holes);
        let there = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|k| self.points[k as usize]);
            a != b && b != c && c != a
        };
        indices.as_chunks().0.iter().copied().filter(there).collect()
    }

    /// Adds the triangles of vertices, and a piece for each grid.
    fn gather(&self, triangles: &mut Vec<[u32; 3]>, pieces: &mut Vec<ReconstructedPiece>) {
        let all = self.triangles();
        let mut rest = &all[..];
        for grid in self.cloth.grids() {
            let count = rest.partition_point(|t| (t[0] as usize) < grid.range().end);
            let (own, after) = rest.split_at(count);
            rest = after;
            let start = triangles.len();
            triangles.extend(own.iter().map(|t| t.map(|k| self.vertices[self.points[k as usize] as usize])));
            let uv = own.iter().map(|t| t.map(|k| self.uv[k as usize])).collect();
            let (name, range) = (grid.name.clone(), start..triangles.len());
            pieces.push(ReconstructedPiece { name, triangles: range, uv: Some(uv) });
        }
    }
}
