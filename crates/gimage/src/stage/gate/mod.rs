//! The gate: compares every piece with its surface before the bundle is written, with or without metrics.

mod figures;

pub use figures::*;

use gimage_bundle::manifest::{PieceEntry, RungEntry};
use rayon::prelude::*;

use crate::base::surface::Surface;
use crate::base::vec3::distance;
use crate::error::{Error, Result};
use crate::options::{Range, stage_options};
use crate::record::{Finding, Severity};
use crate::stage::assemble::{Measured, Piece, measure_piece};
use crate::stage::image::PieceImage;
use crate::stage::image::judge::bounds;
use crate::stage::measure::facing::facing;

/// Pieces that get a finding of their own, the worst first; the rest share one.
const NAMED: usize = 8;

/// Share of the samples of a full measurement that decides where metrics are off.
const SHARE: f64 = 0.05;

stage_options! {
    /// Options of the measurement of quality, and of what follows from it.
    #[derive(Copy)]
    pub struct GateOptions of "gate" {
        /// Do not measure the result against the source.
        pub metrics: bool = true => (not recorded) "no-metrics" [""] Range::Any;
        /// Write images that differ too much from their surface, with a warning, instead of failing.
        pub accept_poor: bool = false => (not recorded) "accept-poor" [""] Range::Any;
        /// Fail if the PSNR of a piece is below this value.
        pub min_psnr: Option<f64> = None => (not recorded) "min-psnr" ["dB"] Range::Finite;
    }
}

/// Writes down what is known of every piece without measuring: the texels outside the box, how all triangles face, the
/// rungs tried.
pub(crate) fn note(entry: &mut PieceEntry, Piece { image, .. }: &Piece<'_>) {
    let v = &image.verdict;
    let facing = facing(&image.disk, &image.samples, &image.grid);
    for (key, value) in [(OUTSIDE_KEY, v.outside), (FOLD_KEY, facing.fold_area), (NORMAL_KEY, facing.normal_degrees)] {
        // JSON has no infinity; what is not finite is as far out as can be written.
        entry.quality.more.insert(key.into(), value.min(f64::MAX).into());
    }
    if image.tried.len() > 1 {
        let finite = |x: f64| x.is_finite().then_some(x);
        entry.ladder = image
            .tried
            .iter()
            .map(|t| RungEntry { rung: t.rung.name().into(), psnr: t.psnr.and_then(finite), kept: t.kept })
            .collect();
    }
}

/// Writes down how much larger the component of every part is than the part.
pub(crate) fn scale_parts(entries: &mut [PieceEntry], pieces: &[Piece<'_>]) {
    let boxes: Vec<[[f64; 3]; 2]> = pieces.iter().map(|p| bounds(&p.surface)).collect();
    let wholes: Vec<Option<u32>> = entries.iter().map(|e| e.part_of).collect();
    for (k, entry) in entries.iter_mut().enumerate().filter(|(_, e)| e.part_of.is_some()) {
        let [lo, hi] =
            boxes.iter().zip(&wholes).filter(|x| *x.1 == wholes[k]).fold(boxes[k], |[lo, hi], ([a, b], _)| {
                [[0, 1, 2].map(|c| lo[c].min(a[c])), [0, 1, 2].map(|c| hi[c].max(b[c]))]
            });
        let scale = distance(lo, hi) / distance(boxes[k][0], boxes[k][1]);
        if scale.is_finite() {
            entry.quality.more.insert(SCALE_KEY.into(), scale.into());
        }
    }
}

/// Rates all pieces. A piece worth a look becomes a warning; [`Error::Poor`] where one does not stand for its surface and
/// `options` do not accept that, or where one is below the PSNR asked for. Pieces that look suspicious are measured here
/// if they were not before.
pub(crate) fn check(entries: &[PieceEntry], pieces: &[Piece<'_>], options: &GateOptions) -> Result<Vec<Finding>> {
    let rated: Vec<Rated> = entries
        .par_iter()
        .zip(pieces)
        .map(|(entry, piece)| {
            let causes = Causes { far: is_far(piece), fringed: is_fringed(&piece.surface, &piece.image) };
            Rated::new(&entry.name, figures(entry, piece, options), causes, options)
        })
        .collect();
    let mut order: Vec<&Rated> = rated.iter().filter(|r| r.rating > Rating::Good || r.below).collect();
    // Stable: equals stay in the order of the pieces.
    order.sort_by(|a, b| (b.below, b.rating).cmp(&(a.below, a.rating)).then(a.psnr().total_cmp(&b.psnr())));
    let refused = |r: &&&Rated| r.below || (r.rating == Rating::Poor && !options.accept_poor);
    if let Some(first) = order.iter().find(refused) {
        return Err(first.error(order.iter().filter(refused).count() - 1, options));
    }
    let mut out: Vec<Finding> = order.iter().take(NAMED).map(|r| r.finding()).collect();
    if let Some(rest) = order.get(NAMED..).filter(|r| !r.is_empty()) {
        out.push(Finding {
            severity: Severity::Warning,
            stage: "gate",
            kind: "low-quality-others",
            count: rest.len() as u64,
            examples: rest.iter().take(crate::record::MAX_EXAMPLES).map(|r| r.words()).collect(),
            message: "More pieces have suspicious figures; `gimage inspect` rates each of them.".into(),
        });
    }
    Ok(out)
}

/// The figures of a piece: those of its manifest entry, with a bound or a quick measurement where metrics are off.
fn figures(entry: &PieceEntry, piece: &Piece<'_>, options: &GateOptions) -> Figures {
    let known = Figures::of(&entry.quality);
    if options.metrics {
        return known;
    }
    let v = &piece.image.verdict;
    let bound =
        Figures { psnr: Some(v.psnr()), hausdorff: Some(v.largest), normal_degrees: Some(v.normal_degrees), ..known };
    let suspicious = bound.rate().0 > Rating::Good || options.min_psnr.is_some_and(|min| v.psnr() < min);
    if !suspicious {
        return bound;
    }
    let measured: Measured = measure_piece(&piece.surface, &piece.image, SHARE);
    Figures::of(&measured.merged(entry.quality.clone()))
}

/// A piece and its rating.
struct Rated<'a> {
    name: &'a str,
    figures: Figures,
    rating: Rating,
    words: Vec<String>,
    /// It is below the PSNR asked for.
    below: bool,
    causes: Causes,
}

/// Causes of a poor image that more texels do not mend.
#[derive(Clone, Copy)]
struct Causes {
    /// It lies so far from the origin that 32-bit positions coarsen it.
    far: bool,
    /// Its border is many times as long as that of its image.
    fringed: bool,
}

/// Length of a border over that of a sheet of the same area as even as the image, from which thin strips are crushed.
const FRINGED: f64 = 8.0;

/// Whether the border of a piece is far longer than its image can hold. More texels do not help: their border grows as the
/// distance between them falls.
fn is_fringed(surface: &Surface, image: &PieceImage) -> bool {
    let (disk, [w, h]) = (&image.disk, [image.width, image.height].map(f64::from));
    let at = |v: u32| disk.positions[v as usize];
    let next = disk.boundary.iter().cycle().skip(1);
    let length: f64 = disk.boundary.iter().zip(next).map(|(&a, &b)| distance(at(a), at(b))).sum();
    length > FRINGED * 2.0 * (w + h) * (surface.area() / (w * h)).sqrt()
}

/// Whether steps of 32-bit positions are coarser than a thousandth of the piece.
fn is_far(Piece { surface, .. }: &Piece<'_>) -> bool {
    let [lo, hi] = bounds(surface);
    let far = lo.iter().chain(&hi).fold(0.0f64, |m, x| m.max(x.abs()));
    far * f64::from(f32::EPSILON) > 1e-3 * distance(lo, hi)
}

impl<'a> Rated<'a> {
    fn new(name: &'a str, figures: Figures, causes: Causes, options: &GateOptions) -> Self {
        let (rating, words) = figures.rate();
        let below = options.min_psnr.zip(figures.psnr).is_some_and(|(min, psnr)| psnr.is_nan() || psnr < min);
        Self { name, figures, rating, words, below, causes }
    }

    fn psnr(&self) -> f64 {
        self.figures.psnr.unwrap_or(f64::INFINITY)
    }

    fn words(&self) -> String {
        format!("piece {}: {}", self.name, self.words.join(", "))
    }

    /// The remedy, by the figure that speaks loudest.
    fn hint(&self) -> &'static str {
        let f = &self.figures;
        let over = |x: Option<f64>, limit: f64| x.is_some_and(|x| x > limit);
        let close = f.psnr.is_some_and(|x| x >= PSNR_DB[0]);
        if self.causes.far {
            "it is too far from the origin for 32-bit positions: move it there with --center"
        } else if self.causes.fringed && over(f.fold, FOLD) {
            "its border is too long for one image, as that of a fringe: separate its strips, or draw them as one band with an \
             alpha texture"
        } else if close && over(f.normal_degrees, NORMAL_DEGREES) {
            "if it is a thin closed shell, delete its inner layer, or use texels smaller than the thickness of the shell"
        } else if over(f.stretch, STRETCH) || over(f.outside, OUTSIDE[0]) {
            "remesh its slivers, separate its parts, or use more texels with --texels"
        } else {
            "use more texels with --texels, or separate its parts"
        }
    }

    fn finding(&self) -> Finding {
        Finding {
            severity: Severity::Warning,
            stage: "gate",
            kind: "low-quality",
            count: 1,
            examples: vec![self.words()],
            message: format!(
                "The image may differ visibly from its surface: check it with `gimage render`; {}.",
                self.hint()
            ),
        }
    }

    fn error(&self, more: usize, options: &GateOptions) -> Error {
        let others = match more {
            0 => String::new(),
            1 => ", and 1 more piece".into(),
            n => format!(", and {n} more pieces"),
        };
        let (problem, hint) = match options.min_psnr.filter(|_| self.below) {
            Some(min) => {
                let psnr = self.psnr();
                (
                    format!("PSNR {psnr:.1} dB, below the required {min} dB{others}"),
                    format!("{}, or lower --min-psnr", self.hint()),
                )
            }
            None => (
                format!("the image differs too much from its surface: {}{others}", self.words.join(", ")),
                format!("{}, or write it anyway with --accept-poor", self.hint()),
            ),
        };
        Error::Poor { piece: self.name.to_owned(), problem, hint }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::shapes::{self, Join};
    use crate::options::BuildOptions;
    use crate::stage::image::{ImageOptions, image};

    #[test]
    fn the_border_of_a_fringe_is_too_long_and_that_of_a_band_is_not() {
        let band = shapes::sheet(81, 20, Join::Open, Join::Open, |u, v| [u, -0.3 * v, 0.0]);
        // Every other column ends two rows below the top.
        let mut fringe = band.clone();
        fringe.triangles.retain(|t| {
            let [x, y] = [0, 1].map(|c| t.iter().map(|&v| band.positions[v as usize][c]).sum::<f64>() / 3.0);
            ((81.0 * x) as u32).is_multiple_of(2) || y > -0.03
        });
        let mut used: Vec<u32> = fringe.triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let number = |v: u32| used.binary_search(&v).unwrap() as u32;
        let fringe = shapes::surface(
            used.iter().map(|&v| band.positions[v as usize]).collect(),
            fringe.triangles.iter().map(|t| t.map(number)).collect(),
        );
        let options = ImageOptions::new(&BuildOptions::default(), Some(2000));
        for (surface, is_long) in [(band, false), (fringe, true)] {
            let image = image("piece", &surface, None, &options).unwrap();
            assert_eq!(is_fringed(&surface, &image), is_long);
        }
    }
}
