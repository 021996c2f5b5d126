//! One surface, cut in every way worth it, and the image of the best cut.

use super::{ImageOptions, PieceImage, finish};
use crate::base::surface::Surface;
use crate::error::{Error, Result};
use crate::options::Seams;
use crate::stage::border::Border;
use crate::stage::cut::disk;
use crate::stage::cut::grow::{Grown, grow, hidden_costs};
use crate::stage::cut::{Cut, CutRecord, Cutter, Loops, OpenSurface, SEAM_DISCOUNT};
use crate::stage::layout::{Size, StandIn, choose, smallest};
use crate::stage::parameterize::bend;
use crate::stage::parameterize::{Source, Way, map};

/// A surface on its way to an image.
pub(crate) struct Maker<'a> {
    pub(super) name: &'a str,
    pub(super) surface: &'a Surface,
    pub(super) cutter: Cutter<'a>,
    loops: Loops,
    uv_seam: Option<&'a [bool]>,
    pub(super) options: &'a ImageOptions,
}

/// The cuts of a surface, and how the first was grown.
pub(crate) struct Cuts {
    pub(crate) candidates: Vec<OpenSurface>,
    pub(super) grown: Option<Grown>,
}

impl<'a> Maker<'a> {
    pub(crate) fn new(
        name: &'a str,
        surface: &'a Surface,
        uv_seam: Option<&'a [bool]>,
        options: &'a ImageOptions,
    ) -> Result<Self> {
        let mut cutter = Cutter::new(surface).ok_or_else(|| Error::Piece {
            piece: name.to_owned(),
            stage: "cut",
            problem: "the surface is not a manifold".into(),
            hint: "please report it with the input".into(),
        })?;
        let texels = match options.size {
            Size::Fixed(w, h) => f64::from(w) * f64::from(h),
            Size::Budget(n) => f64::from(n),
        };
        cutter.wanted = bend::wanted(surface, &cutter.graph, (surface.area() / texels.max(1.0)).sqrt(), options.detail);
        let loops = Loops::of(&cutter);
        Ok(Self { name, surface, cutter, loops, uv_seam, options })
    }

    pub(super) fn source(&self) -> Source<'_> {
        Source { name: self.name, surface: self.surface, rim: &self.loops.rim }
    }

    pub(super) fn fail(&self, stage: &'static str, problem: &str, hint: &str) -> Error {
        self.source().fail(stage, problem, hint)
    }

    /// The cuts worth laying out: along UV seams or not, as the options say, grown into limbs if `growing`.
    pub(crate) fn cuts(&self, growing: bool) -> Result<Cuts> {
        let cutter = &self.cutter;
        let grown = self.options.grow.as_ref().filter(|_| growing).and_then(|g| grow(cutter, g));
        let terminals: &[u32] = grown.as_ref().map_or(&[], |g| &g.terminals);
        let along_uv: &[bool] = match (self.options.seams, self.uv_seam) {
            (_, None) | (Seams::Short, _) => &[false],
            (Seams::Uv, _) => &[true],
            (Seams::Auto, _) => &[false, true],
        };
        let (mut candidates, mut cuts) = (Vec::new(), Vec::new());
        for &along_uv in along_uv {
            let cut = match (&grown, along_uv) {
                // Without limbs or handles the surface itself knows the shorter way than its stand-in.
                (Some(g), false) if !terminals.is_empty() || cutter.handles() > 0 => g.cut.clone(),
                _ => cutter.cut(&self.costs(grown.as_ref(), along_uv), terminals),
            };
            if cuts.contains(&cut) {
                continue;
            }
            candidates.push(self.candidate(&cut, terminals.len(), along_uv, grown.as_ref())?);
            cuts.push(cut);
        }
        Ok(Cuts { candidates, grown })
    }

    /// Cost of cutting each edge.
    pub(super) fn costs(&self, grown: Option<&Grown>, along_uv: bool) -> Vec<f64> {
        let mut cost = hidden_costs(&self.cutter, grown.and_then(|g| g.mirror.as_ref()));
        if let Some(seam) = self.uv_seam.filter(|_| along_uv) {
            for (c, h) in cost.iter_mut().zip(&self.cutter.graph.halves) {
                if seam[h[0] as usize] {
                    *c *= SEAM_DISCOUNT;
                }
            }
        }
        cost
    }

    /// The disk that a cut opens the surface to, and its border.
    pub(super) fn candidate(
        &self,
        cut: &Cut,
        points: usize,
        uv_seams: bool,
        grown: Option<&Grown>,
    ) -> Result<OpenSurface> {
        let mut disk = disk::open(&self.cutter, cut).map_err(|e| {
            let problem = format!("the cut left Euler number {} and {} loops", e.euler, e.loops);
            self.fail("cut", &problem, "please report it with the input")
        })?;
        let border = Border::new(&mut disk, |v| self.source().on_rim(v));
        let cut = CutRecord {
            length: cut.length(&self.cutter.graph),
            edges: cut.edges.iter().filter(|c| **c).count() as u32,
            grown: points,
            uv_seams,
            bought: grown.and_then(|g| g.bought),
        };
        Ok(OpenSurface { disk, border, cut, stand_in: StandIn::default() })
    }

    /// The image of one cut.
    pub(super) fn alone(&self, candidate: &OpenSurface, size: Size) -> Result<PieceImage> {
        self.make(std::slice::from_ref(candidate), size, None)
    }

    /// The error where the border of no candidate fits, with the image that would hold it.
    fn does_not_fit(&self, candidates: &[OpenSurface]) -> Error {
        let least = candidates.iter().map(|c| c.border.least_steps()).min().unwrap_or(8);
        let (w, h) = smallest(least);
        let problem =
            format!("its border, with {} loops, needs an image of {w} x {h} texels", self.loops.lengths.len());
        self.fail("layout", &problem, "close holes in the file, separate its parts, or give it as many texels")
    }

    /// Lays out every candidate on its stand-in, keeps the least distorted, and makes its image.
    pub(super) fn make(&self, candidates: &[OpenSurface], size: Size, way: Option<Way>) -> Result<PieceImage> {
        let (k, layout) = choose(candidates, size, self.options.search).ok_or_else(|| self.does_not_fit(candidates))?;
        let OpenSurface { disk, border, cut, .. } = &candidates[k];
        let map = map(&self.source(), disk, border, &layout, way, self.options)?;
        finish(&self.source(), &self.loops, cut, map, self.options)
    }
}
