//! Limits that an image must meet before it is written.

use gimage_bundle::manifest::Quality;
use serde::Serialize;

/// PSNR \[dB\] below which a piece gets a warning, and below which it is an error.
pub const PSNR_DB: [f64; 2] = [45.0, 30.0];
/// Hausdorff distance / diagonal above which a piece gets a warning, and above which it is an error.
pub const HAUSDORFF: [f64; 2] = [0.05, 0.3];
/// Distance of a texel outside the bounding box of the source / diagonal, for a warning and for an error.
pub const OUTSIDE: [f64; 2] = [0.02, 0.3];
/// Largest stretch of the map above which a piece gets a warning.
pub const STRETCH: f64 = 100.0;
/// Folded share of the surface above which a piece gets a warning.
pub const FOLD: f64 = 0.01;
/// Mean angle \[degrees\] between the normals of source and image above which a piece gets a warning.
pub const NORMAL_DEGREES: f64 = 45.0;

/// The rating of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rating {
    /// No figure is beyond a limit.
    Good,
    /// A figure is beyond the limit of a warning; a person should check the piece.
    Look,
    /// A figure is beyond the limit of an error.
    Poor,
}

impl Rating {
    /// The rating as shown to users.
    pub fn words(self) -> &'static str {
        match self {
            Rating::Good => "good",
            Rating::Look => "look at it",
            Rating::Poor => "poor",
        }
    }
}

/// The figures by which a piece is rated. An unknown figure is `None` and does not count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// 20 log10(diagonal / RMS distance) \[dB\].
    pub psnr: Option<f64>,
    /// Largest distance either way / diagonal.
    pub hausdorff: Option<f64>,
    /// Farthest texel outside the source's bounding box / diagonal.
    pub outside: Option<f64>,
    /// Largest stretch of the map.
    pub stretch: Option<f64>,
    /// Share of the surface folded over; a one-sided surface as such is not folded.
    pub fold: Option<f64>,
    /// Mean angle between normals \[degrees\].
    pub normal_degrees: Option<f64>,
}

/// The name of [`Figures::outside`] among the further figures of a manifest's quality.
pub const OUTSIDE_KEY: &str = "outside_rel";
/// The name of [`Figures::fold`] among the further figures of a manifest's quality.
pub const FOLD_KEY: &str = "fold_local";
/// The name, among the further figures of a manifest's quality, of the mean angle \[degrees\] between an image's normals
/// and those of the places its texels were sampled at. Thin double shells and one-sided surfaces do not raise it.
pub const NORMAL_KEY: &str = "normal_degrees_local";

/// The name, among the further figures of a manifest's quality, of the diagonal of the component that a piece is a part of,
/// over that of the part. Parts are rated at the size of the whole: an error that is large for a small part is small for it.
pub const SCALE_KEY: &str = "component_scale";

impl Figures {
    /// The figures of a piece as its manifest has them, at the size of its component.
    pub fn of(quality: &Quality) -> Self {
        let more = |key: &str| quality.more.get(key).and_then(serde_json::Value::as_f64);
        let own = Self {
            psnr: quality.psnr,
            hausdorff: quality.hausdorff_rel,
            outside: more(OUTSIDE_KEY),
            stretch: quality.stretch_max,
            // Against the nearest point, a one-sided surface counts as folded, and so do two layers that touch; against its
            // own place, a texel that slid along the surface does. A fold shows in both.
            fold: [more(FOLD_KEY), quality.fold_area].into_iter().flatten().reduce(f64::min),
            normal_degrees: quality.normal_degrees,
        };
        own.within(more(SCALE_KEY).unwrap_or(1.0))
    }

    /// The same errors in a surface whose diagonal is `scale` times as long.
    pub fn within(self, scale: f64) -> Self {
        if !(scale.is_finite() && scale > 0.0) {
            return self;
        }
        Self {
            psnr: self.psnr.map(|x| x + 20.0 * scale.log10()),
            hausdorff: self.hausdorff.map(|x| x / scale),
            outside: self.outside.map(|x| x / scale),
            ..self
        }
    }

    /// The rating, and every figure beyond a limit, in words. A figure that is not finite is poor.
    pub fn rate(&self) -> (Rating, Vec<String>) {
        let (mut rating, mut words) = (Rating::Good, Vec::new());
        let mut check = |value: Option<f64>, [look, poor]: [f64; 2], sign: f64, say: &dyn Fn(f64) -> String| {
            let Some(x) = value else { return };
            let beyond = |limit: f64| x.is_nan() || sign * x > sign * limit;
            if beyond(look) {
                rating = rating.max(if beyond(poor) { Rating::Poor } else { Rating::Look });
                words.push(say(x));
            }
        };
        let never = f64::INFINITY;
        check(self.psnr, PSNR_DB, -1.0, &|x| format!("PSNR {x:.1} dB"));
        check(self.hausdorff, HAUSDORFF, 1.0, &|x| format!("a point is off by {} of the diagonal", percent(x)));
        check(self.outside, OUTSIDE, 1.0, &|x| {
            format!("a texel lies outside the source's bounding box by {} of the diagonal", percent(x))
        });
        check(self.stretch, [STRETCH, never], 1.0, &|x| format!("stretch up to {x:.0}"));
        check(self.fold, [FOLD, never], 1.0, &|x| format!("{} folded over", percent(x)));
        check(self.normal_degrees, [NORMAL_DEGREES, never], 1.0, &|x| {
            format!("normals differ by {x:.0} degrees in the mean")
        });
        (rating, words)
    }
}

fn percent(x: f64) -> String {
    let x = 100.0 * x;
    if x < 1e4 { format!("{x:.1} %") } else { format!("{x:.1e} %") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(change: impl FnOnce(&mut Figures)) -> (Rating, Vec<String>) {
        let mut f = Figures {
            psnr: Some(70.0),
            hausdorff: Some(0.003),
            outside: Some(0.0),
            stretch: Some(3.0),
            fold: Some(0.0),
            normal_degrees: Some(4.0),
        };
        change(&mut f);
        f.rate()
    }

    #[test]
    fn each_figure_is_rated_by_its_own_limits() {
        assert_eq!(with(|_| {}), (Rating::Good, vec![]));
        assert_eq!(Figures::default().rate().0, Rating::Good);
        assert_eq!(with(|f| f.psnr = Some(44.9)), (Rating::Look, vec!["PSNR 44.9 dB".into()]));
        assert_eq!(with(|f| f.psnr = Some(-134.0)).0, Rating::Poor);
        assert_eq!(with(|f| f.hausdorff = Some(0.06)).0, Rating::Look);
        assert_eq!(with(|f| f.hausdorff = Some(1e11)).0, Rating::Poor);
        assert_eq!(with(|f| f.outside = Some(0.021)).0, Rating::Look);
        assert_eq!(with(|f| f.outside = Some(0.31)).0, Rating::Poor);
        assert_eq!(with(|f| f.stretch = Some(1e9)), (Rating::Look, vec!["stretch up to 1000000000".into()]));
        assert_eq!(with(|f| f.fold = Some(0.011)).0, Rating::Look);
        assert_eq!(with(|f| f.normal_degrees = Some(83.0)).0, Rating::Look);
        assert_eq!(with(|f| f.psnr = Some(f64::NAN)).0, Rating::Poor);
        let (rating, words) = with(|f| (f.psnr, f.fold) = (Some(20.0), Some(0.5)));
        assert_eq!((rating, words.len()), (Rating::Poor, 2));
    }

    #[test]
    fn a_part_is_rated_at_the_size_of_its_component() {
        let mut quality = Quality { psnr: Some(41.0), hausdorff_rel: Some(0.08), ..Quality::default() };
        quality.more.insert(OUTSIDE_KEY.into(), 0.03.into());
        assert_eq!(Figures::of(&quality).rate().1.len(), 3);
        quality.more.insert(SCALE_KEY.into(), 10.0.into());
        let found = Figures::of(&quality);
        assert_eq!((found.psnr, found.hausdorff, found.outside), (Some(61.0), Some(0.008), Some(0.003)));
        assert_eq!(found.rate().0, Rating::Good);
    }

    #[test]
    fn a_fold_counts_where_both_measures_see_it() {
        let mut quality = Quality { fold_area: Some(0.5), ..Quality::default() };
        assert_eq!(Figures::of(&quality).fold, Some(0.5));
        quality.more.insert(FOLD_KEY.into(), 0.25.into());
        assert_eq!(Figures::of(&quality).fold, Some(0.25));
        quality.fold_area = Some(0.0);
        assert_eq!(Figures::of(&quality).fold, Some(0.0));
    }
}
