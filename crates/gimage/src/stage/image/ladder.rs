//! The ladder: attempts, in order, until an image passes.
//!
//! Rungs are judged by the image that was made, not by the stand-in that chose its layout. The first rung that passes is
//! kept, else the best of all. A garment whose first image passes pays for nothing else.

use crate::stage::gate;
use crate::stage::image::PieceImage;
use crate::stage::image::judge::Verdict;

/// How an attempt differs from the first one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rung {
    /// The best layout of the best cut.
    First,
    /// The whole mesh is mapped at once instead of coarse to fine.
    WholeMesh,
    /// The map is grown from one inner vertex instead of relaxed from a convex one.
    Embedded,
    /// The next best cut.
    NextCut,
    /// The shortest cut, without growth.
    ShortestCut,
    /// A slightly smaller image, and so another layout.
    OtherSize,
    /// The cut grown to the points that came out most stretched.
    MoreTerminals,
    /// The piece is split along its necks.
    Split,
}

impl Rung {
    /// Its name in records.
    pub fn name(self) -> &'static str {
        match self {
            Rung::First => "first",
            Rung::WholeMesh => "whole-mesh",
            Rung::Embedded => "embedded",
            Rung::NextCut => "next-cut",
            Rung::ShortestCut => "shortest-cut",
            Rung::OtherSize => "other-size",
            Rung::MoreTerminals => "more-terminals",
            Rung::Split => "split",
        }
    }
}

/// The result of an attempt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tried {
    /// The rung.
    pub rung: Rung,
    /// A lower bound of its PSNR \[dB\]; `None` where no image came out.
    pub psnr: Option<f64>,
    /// Its image is the one kept.
    pub kept: bool,
}

/// How much better an image must be to displace an earlier one that is no less sound.
pub(crate) const WORTH: f64 = 0.8;

/// Weight of a stretch over the gate's limit, as a factor of the distance: a few crushed triangles are worse than
/// none, but not than a surface half as close.
const STRETCHED: f64 = 2.0;

/// How far above the gate's limit \[dB\] the PSNR of an image is that needs no further rung: 5 dB are a little more than half
/// the distance.
const MARGIN_DB: f64 = 5.0;

/// PSNR \[dB\], itself a lower bound, at which an image needs no further rung.
const ENOUGH_DB: f64 = gate::PSNR_DB[0] + MARGIN_DB;

/// Whether an image needs no further rung. Folds and normals are not asked for: where two layers are nearer to one another
/// than texels are, no rung helps.
pub(crate) fn passes(verdict: &Verdict, stretch: f64) -> bool {
    verdict.psnr() >= ENOUGH_DB && is_sound(verdict) && stretch <= gate::STRETCH
}

/// Whether no distance of an image speaks against it.
pub(crate) fn is_sound(verdict: &Verdict) -> bool {
    verdict.psnr() >= gate::PSNR_DB[0] && verdict.largest <= gate::HAUSDORFF[0] && verdict.outside <= gate::OUTSIDE[0]
}

/// One number to choose between images by; less is better.
pub(crate) fn badness(verdict: &Verdict, stretch: f64) -> f64 {
    verdict.badness() * if stretch > gate::STRETCH { STRETCHED } else { 1.0 }
}

/// The best image so far and the record of all.
#[derive(Default)]
pub(crate) struct Ladder {
    best: Option<PieceImage>,
    tried: Vec<Tried>,
}

impl Ladder {
    /// Whether a rung has passed.
    pub(crate) fn done(&self) -> bool {
        self.best.as_ref().is_some_and(|b| b.closed && passes(&b.verdict, b.distortion.linf))
    }

    /// The best image so far.
    pub(crate) fn best(&self) -> Option<&PieceImage> {
        self.best.as_ref()
    }

    /// How many rungs were tried.
    pub(crate) fn len(&self) -> usize {
        self.tried.len()
    }

    /// Takes what a rung has made, or that it made nothing.
    pub(crate) fn take(&mut self, rung: Rung, made: Option<PieceImage>) {
        let psnr = made.as_ref().map(|m| m.verdict.psnr());
        let kept = made.as_ref().is_some_and(|m| {
            self.best.as_ref().is_none_or(|b| {
                let key = |x: &PieceImage| (!x.closed, !is_sound(&x.verdict));
                let bad = |x: &PieceImage| badness(&x.verdict, x.distortion.linf);
                key(m) < key(b) || (key(m) == key(b) && bad(m) < WORTH * bad(b))
            })
        });
        if kept {
            self.tried.iter_mut().for_each(|t| t.kept = false);
            self.best = made;
        }
        self.tried.push(Tried { rung, psnr, kept });
    }

    /// The best image, with the record of all rungs.
    pub(crate) fn finish(self) -> Option<PieceImage> {
        self.best.map(|b| PieceImage { tried: self.tried, ..b })
    }
}
