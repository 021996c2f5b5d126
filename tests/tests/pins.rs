//! Pins and limits that a file brings, names of parts, and garments that rest on a body.

use gimage::options::{BuildOptions, ImageSize};
use gimage::pins::PinRule;
use gimage_bundle::MapKind;
use gimage_tests::{asset, build, check, garments_or_skip, pinned};

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
    check("cape", &built);
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
    let count = |pin: &str| {
        let built = build(&asset("tshirt.glb"), &pinned(1024, &[pin])).unwrap();
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

#[test]
fn garments_of_characters_are_held_where_they_rest() {
    let Some(folder) = garments_or_skip("pins") else { return };
    // Piece, and the height [m] below which none of it is pinned.
    for (file, lowest) in [
        ("mage_skinned.glb", &[("Mage_Cape", 1.05)][..]),
        ("outfit_skinned.glb", &[("Wolf3D_Outfit_Top", 1.4), ("Wolf3D_Outfit_Bottom", 1.0)]),
    ] {
        let path = folder.join(file);
        for texels in [1024, 8192] {
            let mut options = with(Some(PinRule::Auto));
            options.image.size = ImageSize::Texels(texels);
            options.gate.accept_poor = true;
            let built = build(&path, &options).unwrap();
            check(file, &built);
            let limits = built.bundle.limits().unwrap();
            for (name, lowest) in lowest {
                let index = built.bundle.manifest.pieces.iter().position(|p| p.name == *name).unwrap();
                let (piece, image) =
                    (&built.bundle.manifest.pieces[index], built.bundle.image(index, &MapKind::Position).unwrap());
                let mut held = 0;
                for k in 0..piece.width as usize * piece.height as usize {
                    let (texel, limit) = (image.at(k), limits[piece.first_particle as usize + k]);
                    held += u32::from(texel[3] < 0.0);
                    assert!(texel[3] > 0.0 || f64::from(texel[1]) > *lowest, "{name}: {texel:?} is pinned");
                    assert_eq!(texel[3] < 0.0, limit == 0.0, "{name}: {texel:?} {limit}");
                }
                let share = f64::from(held) / f64::from(piece.width * piece.height);
                assert!((0.005..0.3).contains(&share), "{name}: {share} of the texels are pinned");
                assert!(built.report.findings.iter().any(|f| f.kind == "hint-pins" && f.message.contains(name)));
            }
        }
    }
}
