//! The drawn triangles of several cloths, with seams welded.

use super::exact::{Facet, on_a_line};
use super::{Drawn, Place};
use crate::cpu::indices::PER_TEXEL;
use crate::error::{Error, Result};

/// Triangles of all cloths. Corners are numbered over all cloths, duplicates of a seam point by the lowest.
pub struct Mesh {
    points: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// Twice the number of the quad's first particle, plus which of its triangles.
    codes: Vec<u32>,
    /// The first particle of each cloth.
    firsts: Vec<u32>,
    /// Triangles without area.
    pub degenerate: u64,
    /// Particles that are not finite.
    pub not_finite: u64,
}

impl Mesh {
    /// Gathers them. Errors on lists of the wrong length, too many particles, and too little memory.
    pub fn new(cloths: &[Drawn]) -> Result<Self> {
        let count: usize = cloths.iter().map(|drawn| drawn.cloth.len()).sum();
        if count >= 1 << 31 {
            let what = "the number of particles of all cloths";
            return Err(Error::Setting { what, value: count as f64, range: "less than 2^31" });
        }
        let mut mesh = Mesh {
            points: list(count, "positions")?,
            triangles: list(2 * count, "triangles")?,
            codes: list(2 * count, "names of triangles")?,
            firsts: Vec::new(),
            degenerate: 0,
            not_finite: 0,
        };
        cloths.iter().try_for_each(|drawn| mesh.add(drawn))?;
        Ok(mesh)
    }

    fn add(&mut self, drawn: &Drawn) -> Result<()> {
        let cloth = drawn.cloth;
        let expected = cloth.len();
        let lengths = [("positions", drawn.positions.map(<[_]>::len)), ("holes", drawn.holes.map(<[_]>::len))];
        for (what, found) in lengths.map(|(what, found)| (what, found.unwrap_or(expected))) {
            if found != expected {
                return Err(Error::Length { cloth: cloth.name().into(), what, found, expected });
            }
        }
        let first = self.points.len() as u32;
        self.firsts.push(first);
        match drawn.positions {
            Some(now) => self.points.extend(now.iter().map(|p| [p[0], p[1], p[2]])),
            None => self.points.extend(cloth.positions()),
        }
        let exists = |k: usize| cloth.inverse_mass(k) >= 0.0;
        let here = &self.points[first as usize..];
        self.not_finite += (0..expected).filter(|k| exists(*k) && !is_finite(here[*k])).count() as u64;
        let welded = cloth.points();
        let indices = cloth.all_indices(drawn.holes.unwrap_or(&[]));
        debug_assert_eq!(indices.len(), PER_TEXEL * expected);
        for (code, corners) in indices.chunks_exact(3).enumerate().filter(|(_, t)| t[0] != t[1]) {
            let [a, b, c] = [0, 1, 2].map(|n| first + welded[corners[n] as usize]);
            let corners = [a, b, c].map(|k| self.points[k as usize]);
            if !corners.into_iter().all(is_finite) {
                continue;
            }
            if a == b || b == c || a == c || on_a_line(&corners.map(|p| p.map(f64::from))) {
                self.degenerate += 1;
                continue;
            }
            self.triangles.push([a, b, c]);
            self.codes.push(2 * first + code as u32);
        }
        Ok(())
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// The low and the high corner of the box around a triangle.
    pub fn bounds(&self, triangle: u32) -> [[f32; 3]; 2] {
        let corners = self.triangles[triangle as usize].map(|k| self.points[k as usize]);
        let along =
            |pick: fn(f32, f32) -> f32| [0, 1, 2].map(|c| pick(pick(corners[0][c], corners[1][c]), corners[2][c]));
        [along(f32::min), along(f32::max)]
    }

    /// A triangle for the predicates.
    pub fn facet(&self, triangle: u32) -> Facet {
        let names = self.triangles[triangle as usize];
        Facet { corners: names.map(|k| self.points[k as usize].map(f64::from)), names }
    }

    /// Index of the cloth of a triangle.
    pub fn cloth(&self, triangle: u32) -> usize {
        let particle = self.codes[triangle as usize] / 2;
        self.firsts.partition_point(|first| *first <= particle).saturating_sub(1)
    }

    /// The name of a triangle for the caller.
    pub fn place(&self, triangle: u32, cloths: &[Drawn]) -> Place {
        let code = self.codes[triangle as usize];
        let cloth = self.cloth(triangle);
        let particle = code / 2 - self.firsts[cloth];
        let grids = cloths[cloth].cloth.grids();
        let grid = grids.partition_point(|g| g.first <= particle).saturating_sub(1);
        let (local, width) = (particle - grids[grid].first, grids[grid].width);
        Place { cloth, grid, texel: [local % width, local / width], triangle: code % 2 }
    }
}

/// An empty list for `count` entries.
pub fn list<T>(count: usize, what: &'static str) -> Result<Vec<T>> {
    let mut list = Vec::new();
    let need = (count as u64).saturating_mul(size_of::<T>() as u64);
    list.try_reserve_exact(count).map_err(|_| Error::Memory { what, need })?;
    Ok(list)
}

fn is_finite(p: [f32; 3]) -> bool {
    p.iter().all(|x| x.is_finite())
}
