//! Selections of particles by place, texel, boundary loop or map.

use super::{Cloth, Grid};
use crate::error::{Error, Result, check};

/// A rule that selects particles of a cloth, as `select` of a scene file (SCENE.md) does. Places are those at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Select<'a> {
    /// All particles.
    All,
    /// The particles that are pinned.
    Pinned,
    /// The particles inside a box \[m\], faces included. Sides may be infinite: `low: [f32::NEG_INFINITY, 1.3, ..]`.
    Box {
        /// The lowest corner.
        low: [f32; 3],
        /// The highest corner.
        high: [f32; 3],
    },
    /// The particles inside a sphere, its surface included.
    Sphere {
        /// Its centre \[m\].
        center: [f32; 3],
        /// Its radius \[m\], above 0.
        radius: f32,
    },
    /// A block of texels of a grid, both ends included.
    Texels {
        /// The name of the grid, which is that of the piece; `None` is the first grid.
        piece: Option<&'a str>,
        /// Column and row of the first texel.
        from: [u32; 2],
        /// Column and row of the last texel.
        to: [u32; 2],
    },
    /// A boundary loop, by its place in [`Cloth::loops`]: 0 is the longest.
    Loop(usize),
    /// The particles at which a map is above a value.
    Map {
        /// One value per texel of every grid, as [`Cloth::len`] counts them; [`Cloth::map_values`] takes them from a bundle.
        values: &'a [f32],
        /// The value.
        above: f32,
    },
}

impl Cloth {
    /// The particles that a rule selects, as indices in ascending order: texel (i, j) of a grid is particle
    /// `first + j * width + i`. A seam particle comes with all its duplicates, texels without a particle never come. The list
    /// may be empty. Time linear in the texels, n log n for a loop.
    ///
    /// Errors on a radius that is not above 0, a piece or a loop that the cloth does not have, and a map of another length.
    ///
    /// ```
    /// use gimage_runtime::{Flat, Select};
    ///
    /// let mut cloth = Flat { width: 4, height: 3, ..Flat::square("towel", 2) }.cloth()?;
    /// let row = cloth.select(&Select::Texels { piece: None, from: [0, 0], to: [3, 0] })?;
    /// assert_eq!(row, [0, 1, 2, 3]);
    /// assert_eq!(cloth.select(&Select::Loop(0))?.len(), 10);
    /// cloth.pin(&row)?;
    /// assert_eq!(cloth.select(&Select::Pinned)?, row);
    /// # Ok::<(), gimage_runtime::Error>(())
    /// ```
    pub fn select(&self, select: &Select) -> Result<Vec<u32>> {
        let at = |k: usize| self.positions()[k];
        let all = 0..self.len();
        let chosen: Vec<usize> = match *select {
            Select::All => all.collect(),
            Select::Pinned => all.filter(|k| self.particles()[*k].is_pinned()).collect(),
            Select::Box { low, high } => {
                all.filter(|k| (0..3).all(|c| (low[c]..=high[c]).contains(&at(*k)[c]))).collect()
            }
            Select::Sphere { center, radius } => {
                check("the radius of a selection [m]", radius.into(), "above 0", |r| r > 0.0)?;
                let square = |k: usize| (0..3).map(|c| (at(k)[c] - center[c]).powi(2)).sum::<f32>();
                all.filter(|k| square(*k) <= radius * radius).collect()
            }
            Select::Texels { piece, from, to } => {
                let grid = self.piece(piece)?;
                let inside = |k: &usize| {
                    let local = *k as u32 - grid.first;
                    let (i, j) = (local % grid.width, local / grid.width);
                    (from[0]..=to[0]).contains(&i) && (from[1]..=to[1]).contains(&j)
                };
                grid.range().filter(inside).collect()
            }
            Select::Loop(index) => {
                let mut loops = self.loops();
                let count = loops.len();
                if index >= count {
                    return Err(Error::NoSuch { what: "boundary loop", index, count });
                }
                return Ok(loops.swap_remove(index));
            }
            Select::Map { values, above } => {
                if values.len() != self.len() {
                    let (cloth, found, expected) = (self.name().into(), values.len(), self.len());
                    return Err(Error::Length { cloth, what: "values of a map", found, expected });
                }
                all.filter(|k| values[*k] > above).collect()
            }
        };
        let exist = chosen.into_iter().filter(|k| self.particles()[*k].exists());
        let exist: Vec<u32> = exist.map(|k| k as u32).collect();
        Ok(self.with_duplicates(&exist)?.into_iter().map(|[k, _]| k).collect())
    }

    /// A grid by its name, or the first.
    fn piece(&self, name: Option<&str>) -> Result<&Grid> {
        let found = self.grids().iter().find(|g| name.is_none_or(|name| g.name == name));
        found.ok_or_else(|| {
            let names: Vec<_> = self.grids().iter().map(|g| g.name.as_str()).collect();
            let (cloth, piece) = (self.name().into(), name.unwrap_or_default().into());
            Error::NoPiece { cloth, piece, pieces: names.join(", ") }
        })
    }
}
