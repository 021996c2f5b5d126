//! One surface -> one geometry image: cut, border, layout, map and texels, by the first way that comes close enough.

pub mod judge;
pub mod ladder;
mod maker;
mod options;
mod rungs;

use self::judge::{Verdict, judge, locator_if_distorted};
use self::ladder::{Rung, Tried};
use crate::base::grid::Grid;
use crate::base::surface::Surface;
use crate::error::{Error, Result};
use crate::stage::cut::disk::{Disk, NONE};
use crate::stage::cut::{CutRecord, Loops};
use crate::stage::layout::{self, Size};
use crate::stage::parameterize::distortion::{self, Distortion};
use crate::stage::parameterize::{Map, ParameterizeRecord, Source};
use crate::stage::sample::seal::{Expected, Sheet, seal};
use crate::stage::sample::{FitRecord, Sample, Sampled, Sampling, fit_where_closer, sample};

pub(crate) use maker::Maker;
pub use options::ImageOptions;

/// The image of one piece before attributes are sampled.
#[derive(Clone, Debug)]
pub struct PieceImage {
    /// The disk that was mapped.
    pub disk: Disk,
    /// The place of each of its vertices, in texels.
    pub uv: Vec<[f64; 2]>,
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// Where each texel lies on the disk, row by row.
    pub samples: Vec<Sample>,
    /// Texel positions \[m\], bit-identical for duplicates, and the rings of duplicates.
    pub grid: Grid,
    /// The image welds to a surface of the same topology.
    pub closed: bool,
    /// For each texel the boundary loop of the surface it lies on (longest first), or [`NONE`].
    pub loop_of: Vec<u32>,
    /// Lengths of the surface's boundary loops \[m\], longest first.
    pub loop_lengths: Vec<f64>,
    /// Texels sampled a little off their place so that it does.
    pub moved: usize,
    /// Distortion of the map.
    pub distortion: Distortion,
    /// How the map was made.
    pub parameterize: ParameterizeRecord,
    /// Size, kind and gain of the cut.
    pub cut: CutRecord,
    /// Outcome of the fit, if one was asked for.
    pub fit: Option<FitRecord>,
    /// How close the image comes.
    pub verdict: Verdict,
    /// The rungs of the ladder.
    pub tried: Vec<Tried>,
    /// Its share of the texels, if it has one.
    pub budget: Option<u32>,
}

/// Sizes tried in turn, as shares of the budget, where an image does not weld as it should or has no flip-free map.
const BUDGETS: [f64; 8] = [1.0, 0.97, 0.93, 0.88, 1.1, 1.3, 1.6, 2.0];

/// How many texels a side an exact size may be short for a larger one to be named.
const MAX_SHORT: u32 = 24;

/// Makes the image of a connected surface. `uv_seam` tells the half-edges on UV seams, if the surface has any.
///
/// Errors: [`Error::GridTooSmall`] where an exact size does not hold the border; [`Error::Piece`] where a stage fails.
pub fn image(name: &str, surface: &Surface, uv_seam: Option<&[bool]>, options: &ImageOptions) -> Result<PieceImage> {
    let maker = Maker::new(name, surface, uv_seam, options)?;
    let cuts = maker.cuts(true)?;
    match options.size {
        Size::Budget(texels) => {
            maker.climb(&cuts, &BUDGETS.map(|share| Size::Budget((f64::from(texels) * share) as u32)))
        }
        Size::Fixed(width, height) => fixed_size(&maker, cuts, width, height),
    }
}

/// The image of exactly this size; the error names a larger size that holds the surface.
fn fixed_size(maker: &Maker<'_>, mut cuts: maker::Cuts, width: u32, height: u32) -> Result<PieceImage> {
    let least = |c: &maker::Cuts| c.candidates.iter().map(|c| c.border.least_steps()).min().unwrap_or(8);
    let holds = |w: u32, h: u32, least: u32| 2 * (w + h - 2) >= least;
    if !holds(width, height, least(&cuts)) {
        // A cut that was grown for quality asks for more texels than one that only has to open the surface.
        cuts = maker.cuts(false)?;
    }
    for more in 0..=MAX_SHORT {
        let (w, h) = (width + more, height + more);
        if !holds(w, h, least(&cuts)) {
            continue;
        }
        let made = match more {
            0 => maker.climb(&cuts, &[Size::Fixed(w, h)]),
            _ => maker.make(&cuts.candidates, Size::Fixed(w, h), None),
        };
        match made {
            Ok(image) if image.closed && more == 0 => return Ok(image),
            Ok(image) if image.closed => {
                let (min_width, min_height) = (w, h);
                return Err(Error::GridTooSmall { piece: maker.name.to_owned(), width, height, min_width, min_height });
            }
            // A large image that does not weld will not weld at a larger size either.
            Ok(image) if more == 0 && width.min(height) > 2 * MAX_SHORT => return Ok(image),
            Err(e) if more == MAX_SHORT => return Err(e),
            _ => {}
        }
    }
    let (w, h) = layout::smallest(least(&cuts));
    let (min_width, min_height) = (w.max(width + 1), h.max(height + 1));
    Err(Error::GridTooSmall { piece: maker.name.to_owned(), width, height, min_width, min_height })
}

impl PieceImage {
    /// The rung that made it.
    pub(crate) fn rung(&self) -> Rung {
        self.tried.iter().find(|t| t.kept).map_or(Rung::First, |t| t.rung)
    }

    /// Samples a map: an image that is neither fitted nor judged nor sealed. `cut` is the record of the cut that made the disk.
    ///
    /// Errors: [`Error::Piece`] where a texel falls outside the map.
    pub(crate) fn sampled(source: &Source<'_>, map: Map, cut: CutRecord) -> Result<Self> {
        let Sampled { samples, grid, loop_of } = sample(&map, source.rim).ok_or_else(|| {
            source.fail("resample", "a texel fell outside the map", "please report it with the input")
        })?;
        let Map { disk, uv, w, h, record, .. } = map;
        Ok(Self {
            distortion: distortion::measure(&disk.positions, &disk.triangles, &uv),
            disk,
            uv,
            width: w + 1,
            height: h + 1,
            samples,
            grid,
            closed: false,
            loop_of,
            loop_lengths: Vec::new(),
            moved: 0,
            parameterize: record,
            cut,
            fit: None,
            verdict: Verdict::WORST,
            tried: Vec::new(),
            budget: None,
        })
    }
}

/// Samples a map and fits, judges and seals its image. `cut` is the record of the cut that made the disk.
///
/// Errors: [`Error::Piece`] where a texel falls outside the map.
pub fn finish(
    source: &Source<'_>,
    loops: &Loops,
    cut: &CutRecord,
    map: Map,
    options: &ImageOptions,
) -> Result<PieceImage> {
    let mut image = PieceImage::sampled(source, map, cut.clone())?;
    let PieceImage { disk, uv, samples, grid, loop_of, distortion, verdict, fit, .. } = &mut image;
    let (disk, uv) = (&*disk, &uv[..]);
    let locator = locator_if_distorted(disk, uv, distortion, grid.width - 1, grid.height - 1);
    let judged: &dyn Fn(&Grid) -> Verdict = &|grid| judge(source.surface, disk, uv, grid, locator.as_ref());
    *verdict = judged(grid);
    if let Sampling::Fit(options) = &options.sampling {
        let rim: Vec<bool> = loop_of.iter().map(|&l| l != NONE).collect();
        *fit = Some(fit_where_closer((disk, uv), grid, &rim, options, verdict, judged));
    }
    let expected = Expected { euler: loops.euler, loops: loops.lengths.len() };
    let (moved, closed) = seal(&mut [Sheet { grid, samples, disk, uv }], &[], expected);
    drop(locator);
    (image.moved, image.closed) = (moved[0], closed);
    image.loop_lengths.clone_from(&loops.lengths);
    image.budget = if let Size::Budget(n) = options.size { Some(n) } else { None };
    Ok(image)
}
