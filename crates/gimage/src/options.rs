//! The options of a build, with units, defaults, ranges and the effect of larger values.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::error::{Error, Result};
use crate::stage::assemble::limits::Limit;
use crate::stage::assemble::mass::MassOptions;
use crate::stage::assemble::pins::Pin;
use crate::stage::component::{ALWAYS_PIECE, ComponentOptions};
use crate::stage::import::ImportOptions;
use crate::stage::repair::RepairOptions;

/// The size of the images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ImageSize {
    /// Texels for the whole bundle, divided by area; each piece gets the shape that fits it best. 9..=2^24 - 2, default
    /// 16,384; more is more faithful and slower.
    Texels(u32),
    /// Width and height of every piece's image in texels, 3..=16,384 each.
    Exact(u32, u32),
    /// Mean distance between neighbouring texels \[m\], above 0; smaller is more faithful and slower.
    Spacing(f64),
}

/// Where texels are placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sample {
    /// On the surface, exactly.
    Point,
    /// Where the surface between them comes closest (least squares).
    Fit,
}

/// Which edges a cut prefers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seams {
    /// Tries both and keeps the better map.
    Auto,
    /// The shortest.
    Short,
    /// Those on UV seams.
    Uv,
}

/// Effort of the search for the cut and the layout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// The shortest cut and few layouts: three quarters of the time, for previews.
    Fast,
    /// A search of about as long as the map itself takes.
    #[default]
    Default,
    /// A wide search on a finer stand-in: several times as long, a little more faithful.
    Best,
}

/// What rest lengths measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RestLength {
    /// The straight distance between the two texels.
    Chord,
    /// The length of the surface between them.
    Arc,
}

/// All options of [`crate::pipeline::build`].
#[derive(Clone, Debug, PartialEq)]
pub struct BuildOptions {
    /// Options of the import.
    pub import: ImportOptions,
    /// Options of the repair.
    pub repair: RepairOptions,
    /// Options that separate pieces from accessories.
    pub component: ComponentOptions,
    /// The size of the images.
    pub size: ImageSize,
    /// Where texels are placed.
    pub sample: Sample,
    /// Which edges the cut prefers.
    pub seams: Seams,
    /// Controls how strongly texels concentrate where the surface bends: 0 (uniform) to 1 (least square error); default 0.6,
    /// which is nearly as faithful as 1 and nearly as even as 0. Even springs suit solvers, dense folds look better.
    pub detail: f64,
    /// Effort of the search for the cut and the layout.
    pub effort: Effort,
    /// What rest lengths measure.
    pub rest: RestLength,
    /// Options of the masses.
    pub mass: MassOptions,
    /// Pin conditions; a particle is pinned if any of them holds.
    pub pins: Vec<Pin>,
    /// Limits of particles; of several that hold for a particle, and of the attribute `_LIMIT`, the smallest counts.
    pub limits: Vec<Limit>,
    /// Measure the result against the source. Default true; false saves about a second.
    pub metrics: bool,
    /// Keep images that differ too much from their surface ([`crate::gate`]), with a warning. Default false: an error.
    pub accept_poor: bool,
    /// PSNR \[dB\] that every piece must reach; otherwise the build fails. Default none; larger is stricter.
    pub min_psnr: Option<f64>,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self {
            import: ImportOptions::default(),
            repair: RepairOptions::default(),
            component: ComponentOptions::default(),
            size: ImageSize::Texels(16_384),
            sample: Sample::Fit,
            seams: Seams::Auto,
            detail: 0.6,
            effort: Effort::default(),
            rest: RestLength::Chord,
            mass: MassOptions::default(),
            pins: Vec::new(),
            limits: Vec::new(),
            metrics: true,
            accept_poor: false,
            min_psnr: None,
        }
    }
}

fn texts(list: &[impl ToString]) -> Value {
    json!(list.iter().map(ToString::to_string).collect::<Vec<_>>())
}

fn bad(option: &str, problem: String, hint: &str) -> Error {
    Error::Option { option: option.into(), problem, hint: hint.into() }
}

impl BuildOptions {
    /// Checks every range; stages rely on it.
    pub fn check(&self) -> Result<()> {
        let cap = gimage_bundle::MAX_PARTICLES;
        match self.size {
            ImageSize::Texels(n) if !(9..=cap).contains(&n) => {
                return Err(bad("texels", format!("{n} texels"), &format!("give 9 to {cap}")));
            }
            ImageSize::Exact(w, h)
                if w.min(h) < 3
                    || u64::from(w) * u64::from(h) > u64::from(cap)
                    || w.max(h) > gimage_bundle::MAX_SIDE =>
            {
                let hint = format!("give sides of 3 to {} and at most {cap} texels", gimage_bundle::MAX_SIDE);
                return Err(bad("size", format!("{w} x {h}"), &hint));
            }
            ImageSize::Spacing(d) if !(d.is_finite() && d > 0.0) => {
                return Err(bad("spacing", format!("{d} is not a length above 0"), "give metres above 0"));
            }
            _ => {}
        }
        let a = self.component.accessory_area;
        if !(0.0..=ALWAYS_PIECE).contains(&a) {
            let hint = format!("give a share of the area from 0 to {ALWAYS_PIECE}; larger parts are always pieces");
            return Err(bad("accessory-area", format!("{a}"), &hint));
        }
        if !(0.0..=1.0).contains(&self.detail) {
            return Err(bad("detail", format!("{}", self.detail), "give a number from 0 to 1"));
        }
        if let Some(db) = self.min_psnr.filter(|db| !db.is_finite()) {
            return Err(bad("min-psnr", format!("{db}"), "give decibels, such as 50"));
        }
        if !(self.mass.density.is_finite() && self.mass.density > 0.0) {
            return Err(bad("density", format!("{}", self.mass.density), "give kg/m2 above 0"));
        }
        Ok(())
    }

    /// The options as they stand in the manifest.
    pub(crate) fn record(&self) -> BTreeMap<String, Value> {
        let size = match self.size {
            ImageSize::Texels(n) => ("texels", json!(n)),
            ImageSize::Exact(w, h) => ("size", json!([w, h])),
            ImageSize::Spacing(d) => ("spacing", json!(d)),
        };
        [
            size,
            ("piece", json!(self.import.pieces)),
            ("unit", json!(self.import.unit)),
            ("up", json!(self.import.up.to_string())),
            ("center", json!(self.import.center)),
            ("weld", json!(self.repair.weld)),
            ("accessory_area", json!(self.component.accessory_area)),
            ("sample", json!(if self.sample == Sample::Fit { "fit" } else { "point" })),
            (
                "seams",
                json!(match self.seams {
                    Seams::Auto => "auto",
                    Seams::Short => "short",
                    Seams::Uv => "uv",
                }),
            ),
            ("detail", json!(self.detail)),
            (
                "effort",
                json!(match self.effort {
                    Effort::Fast => "fast",
                    Effort::Default => "default",
                    Effort::Best => "best",
                }),
            ),
            ("rest", json!(if self.rest == RestLength::Arc { "arc" } else { "chord" })),
            ("density", json!(self.mass.density)),
            ("pin", texts(&self.pins)),
        ]
        .into_iter()
        .chain((!self.limits.is_empty()).then(|| ("limit", texts(&self.limits))))
        .map(|(k, v)| (k.to_owned(), v))
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_pass_and_every_range_error_names_its_option() {
        let with = |change: &dyn Fn(&mut BuildOptions)| {
            let mut options = BuildOptions::default();
            change(&mut options);
            options.check()
        };
        assert!(with(&|_| {}).is_ok());
        let sizes = [
            ("texels", ImageSize::Texels(8)),
            ("texels", ImageSize::Texels(gimage_bundle::MAX_PARTICLES + 1)),
            ("size", ImageSize::Exact(2, 9)),
            ("size", ImageSize::Exact(9, gimage_bundle::MAX_SIDE + 1)),
            ("spacing", ImageSize::Spacing(0.0)),
            ("spacing", ImageSize::Spacing(f64::NAN)),
        ];
        let mut found: Vec<_> = sizes.into_iter().map(|(name, s)| (name, with(&|o| o.size = s))).collect();
        found.push(("accessory-area", with(&|o| o.component.accessory_area = 0.11)));
        for x in [-0.1, 1.1, f64::NAN] {
            found.push(("accessory-area", with(&|o| o.component.accessory_area = x)));
            found.push(("detail", with(&|o| o.detail = x)));
            found.push(("density", with(&|o| o.mass.density = x.min(0.0))));
        }
        for (name, result) in found {
            assert!(matches!(&result, Err(Error::Option { option, .. }) if option == name), "{name}: {result:?}");
        }
    }

    #[test]
    fn the_record_has_every_option() {
        let rest = [
            "accessory_area",
            "center",
            "density",
            "detail",
            "effort",
            "piece",
            "pin",
            "rest",
            "sample",
            "seams",
            "unit",
            "up",
            "weld",
        ];
        let sizes = [
            ("texels", ImageSize::Texels(99)),
            ("size", ImageSize::Exact(9, 11)),
            ("spacing", ImageSize::Spacing(0.1)),
        ];
        for (name, size) in sizes {
            let record = BuildOptions { size, ..BuildOptions::default() }.record();
            assert!(record.contains_key(name) && rest.iter().all(|k| record.contains_key(*k)), "{record:?}");
            assert_eq!(record.len(), rest.len() + 1);
        }
    }
}
