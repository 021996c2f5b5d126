//! The options of one image.

use super::ladder::Rung;
use crate::options::{BuildOptions, Effort, ImageSize, Sample, Seams};
use crate::stage::cut::grow::GrowOptions;
use crate::stage::layout::{SearchOptions, Size};
use crate::stage::parameterize::NewtonOptions;
use crate::stage::sample::Sampling;
use crate::stage::sample::fit::FitOptions;

/// Options of the stages from cut to sample, for one surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageOptions {
    /// How large the image is.
    pub size: Size,
    /// How far the cut is grown into limbs; `None` for the shortest cut.
    pub grow: Option<GrowOptions>,
    /// How hard layouts are searched for.
    pub search: SearchOptions,
    /// When the minimiser of the map stops.
    pub newton: NewtonOptions,
    /// Largest number of reweighting passes of the start of the map.
    pub passes: usize,
    /// As [`crate::options::PieceOptions::detail`].
    pub detail: f64,
    /// Where texels go.
    pub sampling: Sampling,
    /// Which edges the cut prefers.
    pub seams: Seams,
    /// The only rung tried after the first: the one that served an image of this surface of about this size. `None` tries all.
    pub rung: Option<Rung>,
}

impl ImageOptions {
    /// The settings of a build for a piece with a budget of texels, or of the exact size asked for.
    pub fn new(options: &BuildOptions, budget: Option<u32>) -> Self {
        let options = &options.image;
        let size = match (options.size, budget) {
            (ImageSize::Exact(w, h), _) => Size::Fixed(w, h),
            (ImageSize::Texels(n), None) => Size::Budget(n),
            (_, b) => Size::Budget(b.unwrap_or(LEAST_TEXELS)),
        };
        let (grow, search) = match options.effort {
            Effort::Fast => (None, SearchOptions::FAST),
            Effort::Default => (Some(GrowOptions::default()), SearchOptions::DEFAULT),
            Effort::Best => (Some(GrowOptions::BEST), SearchOptions::BEST),
        };
        Self {
            size,
            grow,
            search,
            newton: NewtonOptions::default(),
            passes: START_PASSES,
            detail: options.detail,
            sampling: match options.sample {
                Sample::Point => Sampling::Point,
                Sample::Fit => Sampling::Fit(FitOptions::default()),
            },
            seams: options.seams,
            rung: None,
        }
    }
}

/// Texels of a piece whose share is unknown.
const LEAST_TEXELS: u32 = 64;

/// Largest number of reweighting passes of the start of a map.
const START_PASSES: usize = 8;
