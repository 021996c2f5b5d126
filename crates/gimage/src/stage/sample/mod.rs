//! A map -> the texels of an image: sampled on the surface, fitted to it, and sealed.

pub mod fit;
pub(crate) mod resample;
pub(crate) mod seal;

use std::collections::BTreeMap;

use crate::base::grid::Grid;
use crate::stage::border::Key;
use crate::stage::cut::disk::{Disk, NONE};
use crate::stage::image::judge::Verdict;
use crate::stage::parameterize::Map;
use fit::FitOptions;

pub use resample::Sample;
pub(crate) use resample::{border_index, resample};

/// Where texels go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sampling {
    /// On the surface, exactly.
    Point,
    /// Where the surface between them comes closest.
    Fit(FitOptions),
}

/// Outcome of the least-squares fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FitRecord {
    /// It came closer than point sampling; this many texels went back to where they were sampled.
    Kept(usize),
    /// It did not come closer: the texels are where they were sampled.
    Dropped,
    /// Its equations could not be solved: the texels are where they were sampled.
    Failed,
}

/// The texels of an image where they were sampled.
#[derive(Clone, Debug)]
pub struct Sampled {
    /// Where each texel lies on the disk, row by row.
    pub samples: Vec<Sample>,
    /// Texel positions \[m\], bit-identical for duplicates, and the rings of duplicates.
    pub grid: Grid,
    /// For each texel the boundary loop it lies on, or [`NONE`].
    pub loop_of: Vec<u32>,
}

/// Samples a map at every texel. `rim` has, for each vertex of the surface, its boundary loop or [`NONE`]. `None` if a texel
/// fell outside the map, which a map without flips rules out. O(triangles + texels).
pub fn sample(map: &Map, rim: &[u32]) -> Option<Sampled> {
    let Map { disk, uv, border, w, h, .. } = map;
    let (w, h) = (*w, *h);
    let samples = resample(disk, uv, border, w, h)?;
    let mut points: Vec<[f64; 3]> = samples.iter().map(|s| s.position(disk)).collect();
    let mut rings: BTreeMap<Key, Vec<u32>> = BTreeMap::new();
    let mut loop_of = vec![NONE; points.len()];
    for (p, t) in border.iter().enumerate() {
        let at = border_index(p as u32, w, h);
        points[at] = t.position;
        loop_of[at] = t.rim.map_or(NONE, |v| rim[v as usize]);
        rings.entry(t.key).or_default().push(at as u32);
    }
    let mut links = vec![NONE; points.len()];
    for ring in rings.values_mut().filter(|r| r.len() > 1) {
        ring.sort_unstable();
        for (k, &at) in ring.iter().enumerate() {
            links[at as usize] = ring[(k + 1) % ring.len()];
        }
    }
    let grid = Grid { links, ..Grid::new(w as usize + 1, h as usize + 1, points) };
    Some(Sampled { samples, grid, loop_of })
}

/// Badness below which a fit is as good as sampling: what differs by less than f32 can hold is equal, and a flat piece
/// is exact either way.
const EXACT: f64 = 1e-7;

/// Fits the texels of a map where that comes closer than sampling, as `judged`; those of `rim` keep to the surface's
/// boundary. `verdict` is that of the sampled texels, and of the fitted ones if they are kept.
pub(crate) fn fit_where_closer(
    (disk, uv): (&Disk, &[[f64; 2]]),
    grid: &mut Grid,
    rim: &[bool],
    options: &FitOptions,
    verdict: &mut Verdict,
    judged: &dyn Fn(&Grid) -> Verdict,
) -> FitRecord {
    let rings: Vec<Vec<u32>> = grid.rings().collect();
    let image = fit::Image { columns: grid.width, rows: grid.height, rings: &rings, rim };
    let sampled = grid.positions.clone();
    if !fit::fit(disk, uv, &mut grid.positions, &image, options) {
        return FitRecord::Failed;
    }
    let back = fit::restrain(&mut grid.positions, &sampled, &image);
    let fitted = judged(grid);
    if fitted.badness() <= verdict.badness().max(EXACT) {
        *verdict = fitted;
        FitRecord::Kept(back)
    } else {
        grid.positions = sampled;
        FitRecord::Dropped
    }
}
