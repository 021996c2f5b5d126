//! Pins that a file brings, names of parts, and the error without a body.

use std::path::{Path, PathBuf};

use gimage::options::{BuildOptions, ImageSize};
use gimage::pins::PinRule;
use gimage::pipeline::{self, Built};
use gimage::progress::Quiet;
use gimage_bundle::MapKind;

fn asset(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets").join(name)
}

fn build(path: &Path, options: &BuildOptions) -> gimage::Result<Built> {
    let built = pipeline::build(path, options, &Quiet)?;
    assert_eq!(gimage_bundle::validate(&built.bundle), []);
    Ok(built)
}

fn with(rule: Option<PinRule>) -> BuildOptions {
    let mut options = BuildOptions::default();
    options.image.size = ImageSize::Texels(1024);
    options.gate.metrics = false;
    options.assemble.rule = rule;
    options
}

#[test]
fn an_attribute_pins_without_a_flag_and_is_reported() {
    let built = build(&asset("cape.glb"), &with(None)).unwrap();
    let (map, pin) = (MapKind::Position, MapKind::Custom("_PIN".into()));
    let (positions, pins) = (built.bundle.image(0, &map).unwrap(), built.bundle.image(0, &pin).unwrap());
    for k in 0..pins.data.len() {
        assert_eq!(positions.at(k)[3] < 0.0, pins.at(k)[0] > 0.5, "texel {k}");
    }
    assert!(built.report.findings.iter().any(|f| f.kind == "hint-painted" && f.message.contains("_PIN")));
    assert!(!built.report.has_findings(), "{:?}", built.report.findings);
    let plain = build(&asset("cape.glb"), &with(Some(PinRule::Flags))).unwrap();
    assert_eq!(plain.bundle.manifest.pieces[0].counts.pinned, 0);
    assert!(plain.report.findings.iter().all(|f| f.kind != "hint-painted"));
}

#[test]
fn parts_are_named_by_node_and_material() {
    let options = |pin: &str| {
        let mut options = with(None);
        options.assemble.pins = vec![pin.parse().unwrap()];
        options
    };
    let count = |pin: &str| {
        let built = build(&asset("tshirt.glb"), &options(pin)).unwrap();
        let counts = built.bundle.manifest.pieces[0].counts;
        let unmet = built.report.findings.iter().any(|f| f.kind == "nothing-pinned");
        assert_eq!(unmet, counts.pinned == 0, "{pin}");
        (counts.pinned, counts.particles)
    };
    let (all, particles) = count("node:*");
    assert_eq!(all, particles);
    assert_eq!(count("not node:*").0, 0);
    assert_eq!(count("material:no such *").0, 0);
    let (borders, particles) = count("loop:any");
    assert!(borders > 0 && borders < particles / 4, "{borders} of {particles}");
}

#[test]
fn without_a_body_automatic_pins_are_an_error_that_names_it() {
    let error = build(&asset("tshirt.glb"), &with(Some(PinRule::Auto))).unwrap_err().to_string();
    assert!(error.starts_with("option pins: ") && error.contains("body") && error.contains("--body"), "{error}");
}
