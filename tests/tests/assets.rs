//! The sample garments: what every build keeps, how good it is, and what each of them is there to show.

use std::path::{Path, PathBuf};

use gimage::pipeline::Built;
use gimage_bundle::{MapKind, Particle, validate};
use gimage_tests::{asset, build, check, psnr, reread, texels, texels_of};

fn made(name: &str, pins: &[&str]) -> Built {
    let built = build(&asset(name), &gimage_tests::pinned(4096, pins)).unwrap();
    check(name, &built);
    println!("{name}: PSNR {:.1} dB", psnr(&built.bundle));
    built
}

/// Euler number, loops and a floor for the PSNR, about 3 dB under what it was when this was written.
fn is(name: &str, built: &Built, euler: i32, loops: u32, floor: f64) {
    let m = &built.bundle.manifest;
    assert_eq!((m.pieces.len(), m.accessories.len()), (1, 0), "{name}");
    let s = m.pieces[0].surface.as_ref().unwrap();
    assert_eq!((s.euler, s.loops), (euler, loops), "{name}");
    assert!(psnr(&built.bundle) > floor, "{name}: PSNR {} dB is under {floor}", psnr(&built.bundle));
    assert!(!built.report.has_findings(), "{name}: {:?}", built.report.findings);
}

/// The positions of pinned texels and of free ones.
fn pinned(built: &Built) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let (mut held, mut free) = (Vec::new(), Vec::new());
    for [x, y, z, w] in texels_of(&built.bundle, 0) {
        let list = if Particle::from_code(w).unwrap().is_pinned() { &mut held } else { &mut free };
        list.push([x, y, z]);
    }
    assert_eq!(built.bundle.manifest.pieces[0].counts.pinned as usize, held.len());
    assert!(!held.is_empty() && !free.is_empty(), "{} pinned, {} free", held.len(), free.len());
    (held, free)
}

#[test]
fn the_tshirt_is_pinned_above_a_height() {
    let built = made("tshirt.glb", &["above:1.4"]);
    is("tshirt", &built, -2, 4, 70.8);
    let (held, free) = pinned(&built);
    assert!(held.iter().all(|p| p[1] > 1.4) && free.iter().all(|p| p[1] <= 1.4));
    assert!(built.bundle.image(0, &MapKind::Uv(0)).is_some());
}

#[test]
fn the_tshirt_hangs_on_its_tethers() {
    let built = made("tshirt.glb", &["above:1.4"]);
    let bundle = reread(&built.bundle);
    assert!(bundle.manifest.pieces[0].maps.contains_key("tether"));
    assert_eq!(validate(&bundle), []);
    let stored = bundle.stored_tethers().unwrap();
    // The stored tethers are those that the rest lengths give, for every texel of a garment in one piece.
    assert_eq!(stored, bundle.compute_tethers(1).unwrap());
    let particles = bundle.particles().unwrap();
    let (w, rest) = (bundle.manifest.pieces[0].width as usize, bundle.image(0, &MapKind::Rest).unwrap());
    let mut longest = 0.0f32;
    for (k, particle) in particles.iter().enumerate() {
        let anchor = stored.of(k)[0];
        assert!(particles[anchor.particle as usize].is_pinned());
        assert_eq!(anchor.distance == 0.0, particle.is_pinned(), "texel {k}");
        let (p, q) = (bundle.position(k as u32).unwrap(), bundle.position(anchor.particle).unwrap());
        let chord = (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f32>().sqrt();
        assert!(anchor.distance >= 0.999 * chord, "texel {k}: {} m, {chord} m straight", anchor.distance);
        for (c, end) in [k + 1, k + w, k + w + 1, (k + 1).saturating_sub(w)].into_iter().enumerate() {
            let length = rest.at(k)[c];
            if length > 0.0 {
                let other = stored.of(end)[0].distance;
                assert!((anchor.distance - other).abs() <= 1.00001 * length, "texels {k} and {end}");
            }
        }
        longest = longest.max(anchor.distance);
    }
    // From the shoulders down to the hem.
    assert!(longest > 0.4 && longest < 1.2, "{longest} m");
    assert!(made("tshirt.glb", &[]).bundle.stored_tethers().is_none());
}

#[test]
fn the_tshirt_is_pinned_along_its_longest_loop() {
    let built = made("tshirt.glb", &["loop:0"]);
    let (held, _) = pinned(&built);
    // The hem, the longest of the four loops, is the lowest part of the shirt, and runs around the body.
    assert!(held.iter().all(|p| p[1] < 0.9), "{held:?}");
    let around = |c: usize, sign: f32| held.iter().any(|p| p[c] * sign > 0.08);
    assert!(around(0, 1.0) && around(0, -1.0) && around(2, 1.0) && around(2, -1.0), "{held:?}");
    let border = 2 * (built.bundle.manifest.pieces[0].width + built.bundle.manifest.pieces[0].height);
    assert!(held.len() > 8 && held.len() < border as usize, "{} texels", held.len());
}

#[test]
fn the_tshirt_is_pinned_in_a_box_or_below_a_height() {
    let built = made("tshirt.glb", &["box:-1,1.2,-1,0,2,1", "below:0.85"]);
    let inside = |p: &[f32; 3]| p[1] >= 1.2 && p[0] <= 0.0 || p[1] < 0.85;
    let (held, free) = pinned(&built);
    assert!(held.iter().all(inside) && !free.iter().any(inside));
}

#[test]
fn the_skirt_comes_out_in_metres() {
    let built = made("skirt.glb", &[]);
    is("skirt", &built, 0, 2, 64.3);
    // The file has centimetres and Z up under a node that turns and scales.
    for p in texels_of(&built.bundle, 0) {
        assert!(p[1] > 0.4 && p[1] < 1.1 && p[0].abs() < 0.4 && p[2].abs() < 0.4, "{p:?}");
    }
}

#[test]
fn the_trousers_keep_their_belt_loop() {
    let built = made("trousers.glb", &[]);
    // 2 - 2 * genus - loops.
    is("trousers", &built, 2 - 2 - 3, 3, 68.9);
}

#[test]
fn the_cape_is_pinned_by_its_attribute() {
    let built = made("cape.glb", &["attr:_PIN>0.5"]);
    is("cape", &built, 1, 1, 66.2);
    let counts = built.bundle.manifest.pieces[0].counts;
    assert_eq!((counts.seam_texels, counts.largest_ring), (0, 0), "a disk needs no cut");
    let (held, free) = pinned(&built);
    // The collar is at the top.
    let mean = |v: &[[f32; 3]]| v.iter().map(|p| p[1]).sum::<f32>() / v.len() as f32;
    assert!(mean(&held) > mean(&free) + 0.2);
    let pin = built.bundle.image(0, &MapKind::Custom("_PIN".into())).unwrap();
    for (k, p) in texels_of(&built.bundle, 0).iter().enumerate() {
        assert_eq!(p[3] < 0.0, pin.at(k)[0] > 0.5, "texel {k}: {}", pin.at(k)[0]);
    }
}

/// The cape with its attribute `_PIN` under the name `_LIMIT`.
fn cape_with_limits(folder: &Path) -> PathBuf {
    let bytes = std::fs::read(asset("cape.glb")).unwrap();
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let (text, rest) = bytes[20..].split_at(word(12));
    let mut text = std::str::from_utf8(text).unwrap().replace("_PIN", "_LIMIT");
    text.push_str(&" ".repeat(text.len().next_multiple_of(4) - text.len()));
    let header = [0x4654_6C67, 2, 20 + text.len() + rest.len(), text.len(), 0x4E4F_534A];
    let header = header.into_iter().flat_map(|word| (word as u32).to_le_bytes());
    let path = folder.join("cape.glb");
    std::fs::write(&path, header.chain(text.bytes()).chain(rest.iter().copied()).collect::<Vec<u8>>()).unwrap();
    path
}

#[test]
fn limits_come_from_the_attribute_and_the_options_and_the_smallest_counts() {
    let folder = tempfile::tempdir().unwrap();
    let path = cape_with_limits(folder.path());
    let build = |path: &Path, limits: &[&str]| {
        let mut options = texels(1024);
        options.assemble.limits = limits.iter().map(|l| l.parse().unwrap()).collect();
        options.gate.metrics = false;
        let built = build(path, &options).unwrap();
        check("cape", &built);
        built
    };
    let limit = |built: &Built| built.bundle.image(0, &MapKind::Limit).cloned();
    let plain = build(&asset("cape.glb"), &[]);
    let pin = plain.bundle.image(0, &MapKind::Custom("_PIN".into())).unwrap();
    let painted = build(&path, &[]);
    assert_eq!(limit(&painted).unwrap(), *pin);
    assert!(painted.bundle.images.keys().all(|(_, kind)| !matches!(kind, MapKind::Custom(_))));
    assert!(!painted.bundle.manifest.options.contains_key("limit"));
    // The attribute is everywhere: limits of options count where they are smaller.
    let both = build(&path, &["above:1.2=0.25", "above:1.3=0.125", "above:1.3=0.5"]);
    let positions = texels_of(&both.bundle, 0);
    let mut counted = [0; 3];
    for (k, p) in positions.iter().enumerate() {
        let option = if p[1] > 1.3 {
            0.125
        } else if p[1] > 1.2 {
            0.25
        } else {
            f32::INFINITY
        };
        assert_eq!(limit(&both).unwrap().at(k)[0], option.min(pin.at(k)[0]), "texel {k} at {p:?}");
        counted[if p[1] > 1.3 {
            0
        } else if p[1] > 1.2 {
            1
        } else {
            2
        }] += 1;
    }
    assert!(counted.iter().all(|n| *n > 10), "{counted:?}");
    // Options alone leave the rest free; where all texels have one limit, it is a constant.
    let part = limit(&build(&asset("cape.glb"), &["above:1.3=0"])).unwrap();
    assert!(part.data.iter().zip(&positions).all(|(&limit, p)| limit == if p[1] > 1.3 { 0.0 } else { -1.0 }));
    let whole = build(&asset("cape.glb"), &["above:-9=0.5"]);
    assert_eq!((limit(&whole), whole.bundle.manifest.pieces[0].constants.limit), (None, Some(0.5)));
    assert_eq!(whole.bundle.limits().unwrap(), vec![0.5; positions.len()]);
    assert_eq!(whole.bundle.manifest.options["limit"], serde_json::json!(["above:-9=0.5"]));
    let missed = build(&asset("cape.glb"), &["above:99=0.5"]);
    assert!(missed.report.findings.iter().any(|f| f.kind == "nothing-limited"));
    assert_eq!(missed.bundle.limits(), None);
}

#[test]
fn the_dress_has_a_skin_and_is_pinned_by_its_colour() {
    let built = made("dress.glb", &["color:r>0.8"]);
    is("dress", &built, -2, 4, 65.5);
    let skeleton = built.bundle.manifest.skeleton.as_ref().unwrap();
    assert_eq!(skeleton.joints.len(), 8);
    assert_eq!(skeleton.joints.iter().filter(|j| j.parent.is_none()).count(), 1);
    let joints = built.bundle.image(0, &MapKind::Joints(0)).unwrap();
    let weights = built.bundle.image(0, &MapKind::Weights(0)).unwrap();
    let mut used = [false; 8];
    for (j, w) in joints.data.chunks_exact(4).zip(weights.data.chunks_exact(4)) {
        assert!((w.iter().sum::<f32>() - 1.0).abs() < 1e-5 && w.iter().all(|&w| w >= 0.0), "{w:?}");
        for (&j, &w) in j.iter().zip(w) {
            used[j as usize] |= w > 0.0;
        }
    }
    assert!(used.iter().filter(|u| **u).count() > 3, "{used:?}");
    // All duplicates of a seam point are pinned if one is, whatever the colour on their side; the rest go by their own.
    pinned(&built);
    let color = built.bundle.image(0, &MapKind::Color(0)).unwrap();
    for (k, p) in texels_of(&built.bundle, 0).iter().enumerate().filter(|(_, p)| p[3].abs() == 1.0) {
        let red = color.at(k)[0];
        assert!((p[3] < 0.0) == (red > 0.8) || (red - 0.8).abs() < 1e-5, "texel {k}: red {red}");
    }
}

#[test]
fn a_pin_that_meets_nothing_is_told() {
    let built = made("tshirt.glb", &["above:99"]);
    assert!(built.report.findings.iter().any(|f| f.kind == "nothing-pinned"));
    assert_eq!(built.bundle.manifest.pieces[0].counts.pinned, 0);
}

#[test]
fn expressions_name_joints_and_heights_and_combine() {
    let waist = made("skirt.glb", &["loop:top"]);
    let (held, free) = pinned(&waist);
    let highest = free.iter().map(|p| p[1]).fold(f32::MIN, f32::max);
    assert!(held.iter().all(|p| p[1] > highest - 0.03), "the waist is above all else");
    let hem = made("skirt.glb", &["loop:bottom"]);
    assert!(pinned(&hem).0.iter().all(|p| p[1] < 0.75));
    // The upper half of the cuff, by a joint; the other half of the rim is left free.
    let cuff = made("sleeve.glb", &["joint:wrist<0.09 and not below:1.4"]);
    let near = |p: &[f32; 3]| (p[0] - 0.7).powi(2) + (p[1] - 1.4).powi(2) + p[2].powi(2) <= 0.0901f32.powi(2);
    let (held, free) = pinned(&cuff);
    assert!(held.iter().all(|p| near(p) && p[1] >= 1.4 - 1e-6), "{held:?}");
    assert!(free.iter().any(near) && held.len() > 4);
    // A joint that is not there is named with those that are.
    let absent = build(&asset("sleeve.glb"), &gimage_tests::pinned(1024, &["joint:hand<1"])).unwrap();
    let finding = absent.report.findings.iter().find(|f| f.kind == "nothing-pinned").unwrap();
    assert!(finding.message.contains("shoulder, elbow, wrist"), "{}", finding.message);
}
