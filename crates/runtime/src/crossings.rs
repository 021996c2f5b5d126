//! Finds triangles of cloth that cross, by exact predicates.
//!
//! [`find`] takes the drawn triangles of cloths and counts the pairs that cross:
//!
//! - **Two triangles cross if their interiors share a point.** The interior of a triangle is the triangle without its edges and corners. Triangles
//!   in one plane cross if they overlap in an area.
//! - **Triangles touch if they share a point, but no interior point.** A corner on a face, an edge on an edge or two edges on one line touch. Corners
//!   and edges that two triangles have in common do not count. Touching pairs are counted apart from crossing pairs.
//! - **Duplicates of a seam point are one corner**, at the position of the duplicate of the lowest index.
//! - Triangles that share a corner cross if they also meet inside, away from that corner. Triangles that share an edge cross only if they are
//!   folded flat onto one another.
//! - Triangles with all corners in common lie on one another wherever these are: a seam that goes round a corner of an image leaves a point with two
//!   quads, whose triangles may be such a pair. They count neither as crossing nor as touching, but apart.
//! - Triangles without area (all corners on one line, or two at one seam point) are left out and counted: their edges are those of neighbours.
//!   Triangles with a corner that is not finite are left out; the particles that are not finite are counted.
//!
//! A surface can also pass through another surface exactly along its own edges, so that no two interiors meet. Such pairs touch.
//! With no crossing and no touching pair, no surface passes through another.
//!
//! Every decision is a sign of orient2d or orient3d, computed exactly (J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast
//! Robust Geometric Predicates", 1997; the crate `robust`). The test of two triangles compares the ends of two intervals on the line where their
//! planes meet (P. Guigue and O. Devillers, "Fast and Robust Triangle-Triangle Overlap Test Using Orientation Predicates", 2003), here for open
//! triangles. Counts do not depend on the order of cloths, triangles or corners, or on the number of threads. A tree of boxes finds the pairs
//! whose boxes meet.
//!
//! ```
//! use gimage_runtime::crossings::{self, Drawn};
//! use gimage_runtime::Flat;
//!
//! let flat = Flat::square("flat", 5).cloth()?;
//! let mut upright = Flat::square("upright", 4);
//! upright.origin = [-0.4, 0.3, 0.1];
//! upright.down = [0.0, -1.0, 0.0];
//! let upright = upright.cloth()?;
//! let found = crossings::find(&[Drawn::new(&flat), Drawn::new(&upright)], 3)?;
//! assert!(found.within == 0 && found.between > 0, "{found:?}");
//! assert_eq!(found.worst.len(), 3);
//! # Ok::<(), gimage_runtime::Error>(())
//! ```

mod depth;
mod exact;
mod mesh;
mod tally;
#[cfg(test)]
mod tests;
mod tree;

use crate::cloth::Cloth;
use crate::cpu::neighbours::View;
use crate::error::Result;
use mesh::Mesh;
use tally::Tally;
use tree::Tree;

/// A cloth as it is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Drawn<'a> {
    /// The cloth, which has grids, particles and seams.
    pub cloth: &'a Cloth,
    /// Position \[m\] of every particle, as [`crate::Stepper::positions`] or read back; `None` for the positions at the start.
    pub positions: Option<&'a [[f32; 4]]>,
    /// Triangles that a cut has taken away, as [`crate::Stepper::holes`]; `None` for cloth that is whole.
    pub holes: Option<&'a [u32]>,
}

impl<'a> Drawn<'a> {
    /// A whole cloth at its start.
    pub fn new(cloth: &'a Cloth) -> Self {
        Drawn { cloth, positions: None, holes: None }
    }

    /// A whole cloth at these positions \[m\].
    pub fn at(cloth: &'a Cloth, positions: &'a [[f32; 4]]) -> Self {
        Drawn { cloth, positions: Some(positions), holes: None }
    }
}

/// Names a drawn triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// Index of the cloth in the list that [`find`] was given.
    pub cloth: usize,
    /// Index of the grid: the piece of the bundle.
    pub grid: usize,
    /// Column and row of the quad's upper left texel.
    pub texel: [u32; 2],
    /// Which triangle of the quad: the bit of [`crate::ClothBuffers::holes`].
    pub triangle: u32,
}

impl Place {
    /// The particles at the corners of the triangle of this place in a cloth that is whole, counter-clockwise seen from the front; `None` if the cloth
    /// does not have it.
    pub fn corners(&self, cloth: &Cloth) -> Option<[u32; 3]> {
        let grid =
            cloth.grids().get(self.grid).filter(|grid| self.texel[0] < grid.width && self.texel[1] < grid.height)?;
        let (width, first) = (grid.width as usize, grid.first as usize + (self.texel[1] * grid.width) as usize);
        // The quad's row of texels and the next one.
        let rows = first..(first + 2 * width).min(grid.range().end);
        let now: Vec<[f32; 4]> = rows.map(|k| [0.0, 0.0, 0.0, cloth.inverse_mass(k)]).collect();
        let (count, corners) = View { now: &now, width, holes: &[] }.quad(self.texel[0] as usize, 0);
        let corners = corners.get(self.triangle as usize).filter(|_| self.triangle < count)?;
        Some([0, 2, 1].map(|c| (first + corners[c]) as u32))
    }
}

/// Two triangles that cross.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The triangle of the lower place.
    pub first: Place,
    /// The other triangle.
    pub second: Place,
    /// Penetration depth \[m\]: the length of the shortest translation of one of the triangles after which their interiors share no point. At
    /// most about the size of a triangle, however far a cloth has passed through another; 0 for triangles in one plane. Computed in f64, with
    /// rounding.
    pub depth: f64,
}

/// The crossings of cloths at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Crossings {
    /// Triangles that were compared: drawn triangles with an area and finite corners.
    pub triangles: u64,
    /// Drawn triangles without area, left out.
    pub degenerate: u64,
    /// Particles with a position that is NaN or infinite. Their triangles are left out.
    pub not_finite: u64,
    /// Pairs of triangles of one cloth that cross.
    pub within: u64,
    /// Pairs of triangles of two cloths that cross.
    pub between: u64,
    /// Pairs of triangles that touch.
    pub touching: u64,
    /// Pairs of triangles with all corners in common.
    pub double: u64,
    /// The largest depth \[m\] of all crossing pairs; 0 without a crossing.
    pub deepest: f64,
    /// The deepest pairs, deepest first, then by places.
    pub worst: Vec<Crossing>,
}

impl Crossings {
    /// Pairs of triangles that cross.
    pub fn total(&self) -> u64 {
        self.within + self.between
    }
}

/// Finds the crossings of all triangles of `cloths`, and lists the `worst` deepest pairs.
///
/// Errors if a list of positions or holes does not have one entry per particle, if all cloths have 2^31 particles or more, and if the lists of
/// triangles and boxes, about 120 bytes per triangle, do not fit in memory. While the search runs, lists of pairs have at most `worst` entries per 256
/// leaves of the tree, which hold 2 to 4 triangles each, and at most the larger of 1,024 and twice `worst` per thread.
///
/// Takes O(n log n) time for n triangles, plus the pairs whose boxes meet: 33 ms for a wavy sheet of 128 x 128 particles (32,258 triangles), 30 ms for
/// a T-shirt of 16,384 texels (32,092 triangles), each on one core. Cloth in one plane takes longer, because signs are 0 there: 71 ms for the
/// same sheet in a plane of two axes, about 0.3 s in any other plane. With the feature `threads`, pairs are shared out among the threads of rayon.
pub fn find(cloths: &[Drawn], worst: usize) -> Result<Crossings> {
    let mesh = Mesh::new(cloths)?;
    let tree = Tree::new(&mesh)?;
    let tally = Tally::of(&mesh, &tree, worst);
    Ok(Crossings {
        triangles: mesh.len() as u64,
        degenerate: mesh.degenerate,
        not_finite: mesh.not_finite,
        within: tally.within,
        between: tally.between,
        touching: tally.touching,
        double: tally.double,
        deepest: tally.deepest,
        worst: tally.worst.iter().map(|pair| pair.crossing(&mesh, cloths)).collect(),
    })
}
