//! Welds and texel budgets, on a garment and on confetti.

use std::fmt::Write;

use gimage::component::{ALWAYS_PIECE, ComponentOptions};
use gimage::options::BuildOptions;
use gimage::pipeline::Built;
use gimage::repair::RepairOptions;
use gimage_tests::{build, garments_or_skip, texels};

fn total(built: &Built) -> u32 {
    built.bundle.manifest.pieces.iter().map(|p| p.width * p.height).sum()
}

#[test]
fn a_welded_dress_keeps_its_shape_its_budget_and_its_bodice() {
    let name = "a_welded_dress_keeps_its_shape_its_budget_and_its_bodice";
    let Some(folder) = garments_or_skip(name) else { return };
    for distance in [0.0005, 0.001] {
        let options = BuildOptions { repair: RepairOptions { weld: Some(distance) }, ..texels(16_384) };
        let built = build(&folder.join("dress_belted_202k.glb"), &options).unwrap();
        let manifest = &built.bundle.manifest;
        assert!(total(&built) <= 16_384, "{distance}: {}", total(&built));
        for piece in &manifest.pieces {
            assert!(
                piece.quality.psnr.is_some_and(|p| p > 50.0),
                "{distance} {}: {:?}",
                piece.name,
                piece.quality.psnr
            );
        }
        let areas = manifest.pieces.iter().filter_map(|p| p.surface.as_ref()).map(|s| s.area);
        let all: f64 = areas.chain(manifest.accessories.iter().map(|a| a.area)).sum();
        assert!(manifest.accessories.iter().all(|a| a.area < ALWAYS_PIECE * all));
        let weld = built.report.findings.iter().find(|f| f.kind == "tolerance-weld").unwrap();
        let moved: f64 =
            weld.message.split("largest move ").nth(1).and_then(|m| m.split(' ').next()).unwrap().parse().unwrap();
        assert!(weld.count > 1000 && moved <= distance, "{}", weld.message);
    }
}

/// Loose squares, `n` of them, with sides that fall from 1 m to 0.5 m.
fn confetti(n: u32) -> String {
    let mut text = String::new();
    for k in 0..n {
        let (x, side) = (2.0 * f64::from(k), 1.0 - 0.5 * f64::from(k) / f64::from(n));
        for [u, v] in [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]] {
            writeln!(text, "v {} {v} 0", x + u).unwrap();
        }
        writeln!(text, "f {} {} {} {}", 4 * k + 1, 4 * k + 2, 4 * k + 3, 4 * k + 4).unwrap();
    }
    text
}

#[test]
fn the_budget_holds_for_any_number_of_pieces() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("confetti.obj");
    for (n, budget) in [(9, 300), (300, 16_384), (2000, 4096)] {
        std::fs::write(&path, confetti(n)).unwrap();
        let component = ComponentOptions { accessory_area: 0.0 };
        let mut options = BuildOptions { component, ..texels(budget) };
        options.gate.metrics = false;
        let built = build(&path, &options).unwrap();
        let manifest = &built.bundle.manifest;
        assert!(total(&built) <= budget, "{n}: {}", total(&built));
        assert_eq!(manifest.pieces.len() + manifest.accessories.len(), n as usize);
        // As many pieces as have 64 texels each, less what rounding leaves.
        let most = (budget / 64).min(n) as usize;
        assert!(
            manifest.pieces.len() > most / 2 && manifest.pieces.len() <= most.max(9),
            "{n}: {}",
            manifest.pieces.len()
        );
        let said = built.report.findings.iter().any(|f| f.kind == "accessories");
        assert_eq!(said, !manifest.accessories.is_empty());
    }
}
