//! The options of a build: one struct of structs, one per stage.
//!
//! The declaration of a field (`stage_options!`) is the only place that has its unit, default, range and effect. The
//! checks, the record in the manifest, the help of the command line and the table in docs/building.md are derived from it.

mod field;
mod setting;

use std::collections::BTreeMap;

use gimage_bundle::{MAX_PARTICLES, MAX_SIDE};
use serde_json::{Value, json};

use crate::error::Result;
use crate::stage::assemble::AssembleOptions;
use crate::stage::assemble::mass::MassOptions;
use crate::stage::blend::BlendOptions;
use crate::stage::caps::CapsOptions;
use crate::stage::component::ComponentOptions;
use crate::stage::gate::GateOptions;
use crate::stage::import::ImportOptions;
use crate::stage::render::RenderOptions;
use crate::stage::repair::RepairOptions;
use crate::stage::select::SelectOptions;
use crate::stage::shell::ShellOptions;
use crate::stage::stitch::StitchOptions;
use crate::stage::strands::StrandsOptions;

pub use field::Choice;
pub(crate) use field::{Field, stage_options};
pub(crate) use setting::check;
pub use setting::{Range, Setting};

/// The size of the images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ImageSize {
    /// Texels of the whole bundle.
    Texels(u32),
    /// Width and height in texels of the image of each piece.
    Exact(u32, u32),
    /// Mean distance between neighbouring texels \[m\].
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

/// The distance that rest lengths measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RestLength {
    /// The straight distance between the two texels.
    Chord,
    /// The length of the surface between them.
    Arc,
}

impl Choice for Sample {
    const ALL: &'static [(&'static str, Self)] = &[("point", Self::Point), ("fit", Self::Fit)];
}

impl Choice for Seams {
    const ALL: &'static [(&'static str, Self)] = &[("auto", Self::Auto), ("short", Self::Short), ("uv", Self::Uv)];
}

impl Choice for Effort {
    const ALL: &'static [(&'static str, Self)] =
        &[("fast", Self::Fast), ("default", Self::Default), ("best", Self::Best)];
}

impl Choice for RestLength {
    const ALL: &'static [(&'static str, Self)] = &[("chord", Self::Chord), ("arc", Self::Arc)];
}

impl Field for ImageSize {
    fn settings(&self, about: Setting) -> Vec<Setting> {
        let mut texels = Setting {
            unit: "texels",
            range: Range::Between(9.0, MAX_PARTICLES as f64),
            help: "Texels of the whole bundle, divided among the pieces by area; more are more faithful and slower."
                .into(),
            ..about.clone()
        };
        let mut size = Setting {
            name: "size",
            unit: "texels",
            range: Range::Sides(3, MAX_SIDE, MAX_PARTICLES),
            help: "Size of the image of each piece, for example 128x96.".into(),
            ..about.clone()
        };
        let mut spacing = Setting {
            name: "spacing",
            unit: "m",
            range: Range::Above(0.0),
            help: "Mean distance between neighbouring texels.".into(),
            ..about
        };
        match *self {
            ImageSize::Texels(n) => (texels.value, texels.numbers) = (Some(json!(n)), vec![n.into()]),
            ImageSize::Exact(w, h) => (size.value, size.numbers) = (Some(json!([w, h])), vec![w.into(), h.into()]),
            ImageSize::Spacing(d) => (spacing.value, spacing.numbers) = (Some(json!(d)), vec![d]),
        }
        vec![texels, size, spacing]
    }
}

stage_options! {
    /// Options of the image of each piece: cut, layout, map and texels.
    #[derive(Copy)]
    pub struct PieceOptions of "image" {
        /// The size of the images.
        pub size: ImageSize = ImageSize::Texels(16_384) => "texels" [""] Range::Any;
        /// Place texels exactly on the surface (point), or so that the surface between them is closest (fit).
        pub sample: Sample = Sample::Fit => "sample" [""] Range::Any;
        /// Where cuts run: along the shortest path, along UV seams, or the better of both (auto).
        pub seams: Seams = Seams::Auto => "seams" [""] Range::Any;
        /// How strongly texels concentrate where the surface bends: 0 is uniform, 1 has the least error. Even springs suit
        /// solvers, dense folds look better.
        pub detail: f64 = 0.6 => "detail" ["share"] Range::Between(0.0, 1.0);
        /// Effort of the search for the best cut and layout.
        pub effort: Effort = Effort::Default => "effort" [""] Range::Any;
    }
}

/// All options of [`crate::pipeline::build`], one struct per stage.
///
/// ```
/// use gimage::options::{BuildOptions, ImageSize, PieceOptions};
///
/// let image = PieceOptions { size: ImageSize::Texels(4096), detail: 2.0, ..PieceOptions::default() };
/// let options = BuildOptions { image, ..BuildOptions::default() };
/// let error = options.check().unwrap_err().to_string();
/// assert_eq!(error, "option detail: 2 is out of range; give a number from 0 to 1");
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BuildOptions {
    /// Options of the import.
    pub import: ImportOptions,
    /// Options that choose the parts that become cloth.
    pub select: SelectOptions,
    /// Options of the repair.
    pub repair: RepairOptions,
    /// Options of strands.
    pub strands: StrandsOptions,
    /// Options of caps across openings.
    pub caps: CapsOptions,
    /// Options of thin shells.
    pub shell: ShellOptions,
    /// Options that separate pieces from accessories.
    pub component: ComponentOptions,
    /// Options of the image of each piece.
    pub image: PieceOptions,
    /// Options of the masses.
    pub mass: MassOptions,
    /// Options of the other maps.
    pub assemble: AssembleOptions,
    /// Options of the stitches between pieces.
    pub stitch: StitchOptions,
    /// Options of the blend at borders with other parts.
    pub blend: BlendOptions,
    /// Options of the measurement of quality, and of what follows from it.
    pub gate: GateOptions,
    /// Options of the render mesh.
    pub render: RenderOptions,
}

impl BuildOptions {
    /// All settings in the order of the stages, with the values of these options.
    pub fn settings(&self) -> Vec<Setting> {
        [
            self.import.settings(),
            self.select.settings(),
            self.repair.settings(),
            self.strands.settings(),
            self.caps.settings(),
            self.shell.settings(),
            self.component.settings(),
            self.image.settings(),
            self.mass.settings(),
            self.assemble.settings(),
            self.stitch.settings(),
            self.blend.settings(),
            self.gate.settings(),
            self.render.settings(),
        ]
        .concat()
    }

    /// Checks every range; stages rely on it.
    pub fn check(&self) -> Result<()> {
        check(&self.settings())
    }

    /// The options as they stand in the manifest.
    pub(crate) fn record(&self) -> BTreeMap<String, Value> {
        let recorded = self.settings().into_iter().filter(|setting| setting.recorded);
        recorded.filter_map(|setting| Some((setting.name.replace('-', "_"), setting.value?))).collect()
    }
}

/// The text of an option of the command line, by name: its effect, default and range. Empty for an unknown name.
pub fn help(name: &str) -> String {
    let settings = BuildOptions::default().settings();
    settings.iter().find(|setting| setting.name == name).map(Setting::help).unwrap_or_default()
}

/// The range of an option of the command line, by name.
pub fn range(name: &str) -> Range {
    let settings = BuildOptions::default().settings();
    settings.iter().find(|setting| setting.name == name).map_or(Range::Any, |setting| setting.range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

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
            ("texels", ImageSize::Texels(MAX_PARTICLES + 1)),
            ("size", ImageSize::Exact(2, 9)),
            ("size", ImageSize::Exact(9, MAX_SIDE + 1)),
            ("size", ImageSize::Exact(MAX_SIDE, MAX_SIDE)),
            ("spacing", ImageSize::Spacing(0.0)),
            ("spacing", ImageSize::Spacing(f64::NAN)),
        ];
        let mut found: Vec<_> = sizes.into_iter().map(|(name, s)| (name, with(&|o| o.image.size = s))).collect();
        found.push(("accessory-area", with(&|o| o.component.accessory_area = 0.11)));
        for x in [-0.1, 1.1, f64::NAN] {
            found.push(("accessory-area", with(&|o| o.component.accessory_area = x)));
            found.push(("detail", with(&|o| o.image.detail = x)));
            found.push(("density", with(&|o| o.mass.density = x.min(0.0))));
            found.push(("unit", with(&|o| o.import.unit = x.min(0.0))));
            found.push(("weld", with(&|o| o.repair.weld = Some(x.min(0.0)))));
        }
        found.push(("min-psnr", with(&|o| o.gate.min_psnr = Some(f64::INFINITY))));
        for (name, result) in found {
            assert!(matches!(&result, Err(Error::Option { option, .. }) if option == name), "{name}: {result:?}");
        }
        for size in [ImageSize::Texels(9), ImageSize::Exact(3, MAX_SIDE), ImageSize::Spacing(1e-6)] {
            assert!(with(&|o| o.image.size = size).is_ok(), "{size:?}");
        }
    }

    #[test]
    fn the_record_has_every_option() {
        let rest = [
            "accessory_area",
            "caps",
            "center",
            "density",
            "detail",
            "effort",
            "piece",
            "pin",
            "render_mesh",
            "rest",
            "sample",
            "seams",
            "shell",
            "stitch",
            "strands",
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
            let mut options = BuildOptions::default();
            options.image.size = size;
            let record = options.record();
            assert!(record.contains_key(name) && rest.iter().all(|k| record.contains_key(*k)), "{record:?}");
            assert_eq!(record.len(), rest.len() + 1);
            options.assemble.limits = vec!["above:1=0.5".parse().unwrap()];
            assert_eq!(options.record()["limit"], json!(["above:1=0.5"]));
            options.select.cloth = vec!["Mage_*".parse().unwrap()];
            assert_eq!(options.record()["cloth"], json!(["Mage_*"]));
        }
    }

    #[test]
    fn names_are_unique_and_help_has_default_and_range() {
        let settings = BuildOptions::default().settings();
        let mut names: Vec<_> = settings.iter().map(|setting| setting.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), settings.len());
        assert_eq!(help("density"), "Mass per area of the cloth [default: 0.15; above 0]");
        assert!(help("detail").ends_with("[default: 0.6; 0 to 1]"), "{}", help("detail"));
        assert!(help("sample").ends_with("(fit) [default: fit]"), "{}", help("sample"));
        assert!(help("weld").ends_with("[above 0]"), "{}", help("weld"));
        assert!(help("texels").ends_with("[default: 16384; 9 to 16777214]"), "{}", help("texels"));
        assert_eq!(help("color"), "");
    }

    /// The table of docs/building.md.
    fn table() -> String {
        let mut out = String::from("| option | stage | effect | unit | default | range |\n|---|---|---|---|---|---|\n");
        for setting in BuildOptions::default().settings() {
            out += &setting.row();
            out.push('\n');
        }
        out
    }

    #[test]
    fn the_page_has_the_table_of_options() {
        let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/building.md");
        let text = std::fs::read_to_string(page).unwrap().replace("\r\n", "\n");
        assert!(text.contains(&table()), "docs/building.md must have this table of options:\n\n{}", table());
    }
}
