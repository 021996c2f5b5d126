//! The rungs of the ladder: what is tried in turn until an image passes.

use super::PieceImage;
use super::judge::bounds;
use super::ladder::{Ladder, Rung};
use super::maker::{Cuts, Maker};
use crate::base::vec3::distance;
use crate::error::Result;
use crate::stage::cut::disk::NONE;
use crate::stage::cut::grow::Grown;
use crate::stage::layout::{Size, most_stretched};
use crate::stage::parameterize::Way;

/// Sizes tried where an image welds but comes out poor, as shares of that at which it welds: smaller, so that the budget
/// holds.
const OTHER_BUDGETS: [f64; 2] = [0.96, 0.91];

/// Triangles times rungs after which no further rung is tried: the ladder's share of the time stays bounded.
const MAX_WORK: usize = 4_000_000;

/// Cost of mapping a mesh whole, in rungs.
const WHOLE_MESH_RUNGS: usize = 20;

/// Cost of embedding a mesh, in rungs of maps that are made coarse to fine: one of 98,000 triangles takes seconds.
const EMBEDDED_RUNGS: usize = 16;

/// Points a cut is grown to where its image came out poor.
const TERMINALS: usize = 6;
/// Least distance of these points, as a share of the diagonal: nearer ones lie in one limb.
const TERMINALS_APART: f64 = 0.05;

impl Maker<'_> {
    /// Climbs the ladder: the first of `sizes` at which the image welds, then whatever else there is to try until an image
    /// passes. The error is that of the first rung, if none makes an image.
    pub(super) fn climb(&self, cuts: &Cuts, sizes: &[Size]) -> Result<PieceImage> {
        let mut ladder = Ladder::default();
        let mut failure = None;
        let mut size = sizes.first().copied().unwrap_or(self.options.size);
        for (k, &tried) in sizes.iter().enumerate() {
            if ladder.best().is_some_and(|b| b.closed) {
                break;
            }
            let made = self.make(&cuts.candidates, tried, None);
            if made.as_ref().is_ok_and(|m| m.closed) {
                size = tried;
            }
            let rung = if k == 0 { Rung::First } else { Rung::OtherSize };
            ladder.take(rung, made.map_err(|e| failure.get_or_insert(e)).ok());
        }
        let rungs = [Rung::WholeMesh, Rung::NextCut, Rung::ShortestCut, Rung::OtherSize, Rung::MoreTerminals];
        for rung in rungs {
            if ladder.done() || self.work(&ladder) > MAX_WORK {
                break;
            }
            if self.options.rung.is_none_or(|only| only == rung) {
                self.rung(rung, cuts, size, &mut ladder);
            }
        }
        ladder
            .finish()
            .ok_or_else(|| failure.unwrap_or_else(|| self.fail("layout", "no size was tried", "give more texels")))
    }

    /// The work of a ladder so far, in triangles times rungs.
    fn work(&self, ladder: &Ladder) -> usize {
        spent(ladder.best().map(|b| b.parameterize.way), ladder.len(), self.surface.triangles.len())
    }

    /// Tries a rung, if there is anything to it.
    fn rung(&self, rung: Rung, cuts: &Cuts, size: Size, ladder: &mut Ladder) {
        match rung {
            Rung::WholeMesh => {
                let affordable = WHOLE_MESH_RUNGS * self.surface.triangles.len() <= MAX_WORK;
                if affordable && ladder.best().is_some_and(|b| b.parameterize.way == Way::CoarseToFine) {
                    ladder.take(rung, self.make(&cuts.candidates, size, Some(Way::Whole)).ok());
                }
            }
            Rung::Embedded if ladder.best().is_some_and(|b| b.parameterize.way != Way::Embedded) => {
                ladder.take(rung, self.make(&cuts.candidates, size, Some(Way::Embedded)).ok());
            }
            Rung::NextCut => {
                for candidate in &cuts.candidates {
                    // The one that the first rung chose is known already.
                    let more = !ladder.done() && self.work(ladder) <= MAX_WORK;
                    if more && ladder.best().is_none_or(|b| b.cut != candidate.cut) {
                        ladder.take(rung, self.alone(candidate, size).ok());
                    }
                }
            }
            Rung::ShortestCut => {
                let cut = self.cutter.cut(&self.costs(cuts.grown.as_ref(), false), &[]);
                if let Ok(candidate) = self.candidate(&cut, 0, false, None)
                    && cuts.candidates.iter().all(|c| c.cut.edges != candidate.cut.edges)
                {
                    ladder.take(rung, self.alone(&candidate, size).ok());
                }
            }
            Rung::OtherSize => {
                let Size::Budget(texels) = size else { return };
                for share in OTHER_BUDGETS {
                    if !ladder.done() && self.work(ladder) <= MAX_WORK {
                        let size = Size::Budget((f64::from(texels) * share) as u32);
                        ladder.take(rung, self.make(&cuts.candidates, size, None).ok());
                    }
                }
            }
            Rung::MoreTerminals => {
                let Some(terminals) = ladder.best().map(|b| self.more_terminals(b, cuts.grown.as_ref())) else {
                    return;
                };
                let cut = self.cutter.cut(&self.costs(cuts.grown.as_ref(), false), &terminals);
                if let Ok(candidate) = self.candidate(&cut, terminals.len(), false, None) {
                    ladder.take(rung, self.alone(&candidate, size).ok());
                }
            }
            _ => {}
        }
    }

    /// The points the cut was grown to, and those that an image stretches most.
    fn more_terminals(&self, image: &PieceImage, grown: Option<&Grown>) -> Vec<u32> {
        let disk = &image.disk;
        let mut on_cut = vec![false; self.surface.positions.len()];
        let origin = |v: u32| disk.origin[v as usize];
        disk.boundary.iter().map(|&v| origin(v)).filter(|&o| o != NONE).for_each(|o| on_cut[o as usize] = true);
        let [lo, hi] = bounds(self.surface);
        let apart = TERMINALS_APART * distance(lo, hi);
        let allowed = |v: u32| origin(v) != NONE && !on_cut[origin(v) as usize];
        let worst = most_stretched(&disk.positions, &disk.triangles, &image.uv, TERMINALS, apart, allowed);
        let mut terminals = grown.map_or_else(Vec::new, |g| g.terminals.clone());
        for v in worst.into_iter().map(origin) {
            if !terminals.contains(&v) {
                terminals.push(v);
            }
        }
        terminals
    }
}

/// The work of a number of rungs, if their maps are made in this way.
fn spent(way: Option<Way>, rungs: usize, triangles: usize) -> usize {
    let each = if way == Some(Way::Embedded) { EMBEDDED_RUNGS } else { 1 };
    each * rungs * triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::shapes;
    use crate::options::BuildOptions;
    use crate::stage::image::{ImageOptions, image};

    #[test]
    fn rungs_of_large_embedded_meshes_are_few() {
        // A panel of a pleated skirt: seven rungs of 7 s each, and as many again for each smaller size.
        assert!(spent(Some(Way::Embedded), 3, 98_000) > MAX_WORK);
        assert!(spent(Some(Way::CoarseToFine), 7, 98_000) <= MAX_WORK);
        assert!(spent(Some(Way::Embedded), 7, 20_000) <= MAX_WORK && spent(None, 7, 20_000) <= MAX_WORK);
    }

    #[test]
    fn an_image_that_is_made_again_takes_no_other_rung() {
        let all = ImageOptions::new(&BuildOptions::default(), Some(150));
        let mut poor = 0;
        for (name, s) in shapes::all().into_iter().chain([("holed", shapes::holed(5)), ("plate", shapes::plate(4))]) {
            let Ok(first) = image(name, &s, None, &all) else { continue };
            poor += usize::from(first.tried.iter().any(|t| t.rung == Rung::NextCut || t.rung == Rung::ShortestCut));
            for only in [Rung::First, first.rung()] {
                let again = image(name, &s, None, &ImageOptions { rung: Some(only), ..all }).unwrap();
                // Sizes are tried until the image welds, by any rung.
                let others = again.tried.iter().filter(|t| ![Rung::First, Rung::OtherSize, only].contains(&t.rung));
                assert_eq!(others.count(), 0, "{name}: {:?}", again.tried);
                assert!(again.tried.len() <= first.tried.len(), "{name}");
            }
        }
        assert!(poor > 0, "no surface has needed another rung");
    }
}
