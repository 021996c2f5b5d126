//! A disk and its layout -> a map of the disk onto the rectangle.

use super::{ParameterizeRecord, Way, parameterize, parameterize_by};
use crate::base::surface::Surface;
use crate::error::{Error, Result};
use crate::stage::border::{Border, BorderTexel};
use crate::stage::cut::disk::{Disk, NONE};
use crate::stage::image::ImageOptions;
use crate::stage::layout::Layout;

/// A surface on its way to an image.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// Its name, for messages.
    pub name: &'a str,
    /// The surface.
    pub surface: &'a Surface,
    /// For each vertex the boundary loop it lies on, longest first, or [`NONE`].
    pub rim: &'a [u32],
}

impl Source<'_> {
    /// The error of a stage that failed on this surface.
    pub(crate) fn fail(&self, stage: &'static str, problem: &str, hint: &str) -> Error {
        Error::Piece { piece: self.name.to_owned(), stage, problem: problem.into(), hint: hint.into() }
    }

    /// Whether a vertex lies on the surface's own boundary.
    pub(crate) fn on_rim(&self, v: u32) -> bool {
        self.rim[v as usize] != NONE
    }
}

/// A disk mapped onto a rectangle.
#[derive(Clone, Debug)]
pub struct Map {
    /// The disk, with a vertex on each corner of the rectangle.
    pub disk: Disk,
    /// The place of each vertex in cells: 0 to `w` and 0 to `h`. No triangle is flipped.
    pub uv: Vec<[f64; 2]>,
    /// The texels on the border, counter-clockwise from (0, 0).
    pub border: Vec<BorderTexel>,
    /// Cells across.
    pub w: u32,
    /// Cells down.
    pub h: u32,
    /// How the map was made.
    pub record: ParameterizeRecord,
}

/// A mesh of many more triangles than half the cells, and than this, is mapped coarse to fine.
const LEAST_TRIANGLES: usize = 3000;

/// Triangles for each vertex on the boundary, which a simpler disk keeps: one of n triangles and b vertices on the boundary has
/// (n - b) / 2 inside. With fewer of them than of the others, triangles reach from one side of the disk to another one, and the
/// map is crushed.
const FOR_BOUNDARY: usize = 3;
/// Where that would be more triangles than this, there are half as many for each vertex on the boundary, but at least these.
const MANY_TRIANGLES: usize = 40_000;

/// Triangles of which a map of `w` x `h` cells is as good as of all, of a disk with `boundary` vertices on its boundary.
fn enough(w: u32, h: u32, boundary: usize) -> usize {
    let around = (FOR_BOUNDARY * boundary).min(MANY_TRIANGLES.max(FOR_BOUNDARY * boundary / 2));
    LEAST_TRIANGLES.max((w * h) as usize / 2).max(around)
}

/// Lays a disk's border on the rectangle of a layout and maps its inside, by one way only if that is given.
///
/// Errors: [`Error::Piece`] where the boundary cannot be distributed over the texels, and where no map free of flips is found.
pub fn map(
    source: &Source<'_>,
    disk: &Disk,
    border: &Border,
    layout: &Layout,
    way: Option<Way>,
    options: &ImageOptions,
) -> Result<Map> {
    let Layout { w, h, .. } = *layout;
    let placed = border
        .place(disk, source.surface, &|v| source.on_rim(v), layout)
        .ok_or_else(|| source.fail("border", "the boundary cannot be shared out", "use a larger image"))?;
    let (disk, mut uv) = (placed.disk, placed.uv);
    let fixed = disk.boundary_mask();
    let (shape, enough) = (disk.shape(&fixed), enough(w, h, disk.boundary.len()));
    let record = match way {
        None => parameterize(shape, &mut uv, options.passes, &options.newton, enough),
        Some(way) => parameterize_by(way, shape, &mut uv, options.passes, &options.newton, enough),
    }
    .ok_or_else(|| {
        let hint = "remesh the slivers of this piece, or give it more texels";
        source.fail("parameterize", "no flip-free map was found", hint)
    })?;
    Ok(Map { disk, uv, border: placed.texels, w, h, record })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_boundary_has_as_many_triangles_inside() {
        // 9,500 vertices on the boundary of a skirt with 100 eyelets left no vertex inside of the simpler disk.
        assert_eq!(enough(238, 67, 9_500), 28_500);
        assert_eq!(enough(127, 127, 600), 127 * 127 / 2);
        assert_eq!(enough(20, 20, 100), LEAST_TRIANGLES);
        assert!((30_000..=60_000).contains(&enough(127, 127, 30_000)));
    }
}
