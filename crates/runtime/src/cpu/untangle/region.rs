//! The cells in which crossings are searched, where it is known where cloth crosses.

use crate::cpu::truncation::surface::Surface;

/// Some cells of a surface.
pub struct Region {
    /// In ascending order.
    pub cells: Vec<u32>,
    known: Vec<bool>,
}

impl Region {
    /// No cell of a surface.
    pub fn new(surface: &Surface) -> Self {
        Region { cells: Vec::new(), known: vec![false; surface.corners.len()] }
    }

    /// Adds the cells around some points; whether there are new ones.
    pub fn grow(&mut self, surface: &Surface, points: impl Iterator<Item = u32>) -> bool {
        let before = self.cells.len();
        for cell in points.flat_map(|point| surface.cells_of(point as usize)) {
            if !std::mem::replace(&mut self.known[*cell as usize], true) {
                self.cells.push(*cell);
            }
        }
        self.cells.sort_unstable();
        self.cells.len() > before
    }

    /// Leaves out all cells but those around some points and their neighbours, into which these points may go until the next search.
    pub fn keep(&mut self, surface: &Surface, points: impl Iterator<Item = u32>) {
        self.cells.iter().for_each(|cell| self.known[*cell as usize] = false);
        self.cells.clear();
        self.grow(surface, points);
        let ring: Vec<u32> = self.points(surface).map(|point| point as u32).collect();
        self.grow(surface, ring.into_iter());
    }

    /// The points at the corners of all cells, some of them more than once.
    pub fn points<'a>(&'a self, surface: &'a Surface) -> impl Iterator<Item = usize> + 'a {
        self.cells.iter().flat_map(|cell| surface.triangles(*cell as usize)).flatten().map(|point| *point as usize)
    }
}
