//! Stitches: pieces that share no vertex hang together.

use crate::support::rig::{Rig, largest};
use crate::support::{self, curtain, patched_charts, scene, wind};
use gimage_runtime::*;

fn options(substeps: u32) -> Options {
    Options { substeps: Some(substeps), threads: 1, ..Options::default() }
}

/// How far the two ends of each stitch are apart beyond its length \[m\], at most.
fn beyond(cloth: &Cloth, positions: &[[f32; 4]]) -> f64 {
    let mut most = 0.0f64;
    for stitch in cloth.stitches() {
        let grid = &cloth.grids()[stitch.piece as usize];
        let [x, y] = [stitch.at[0] * (grid.width - 1) as f32, stitch.at[1] * (grid.height - 1) as f32];
        let (i, j) = ((x as u32).min(grid.width - 2), (y as u32).min(grid.height - 2));
        let (s, t) = (x - i as f32, y - j as f32);
        let mut way = [0, 1, 2].map(|c: usize| f64::from(positions[stitch.particle as usize][c]));
        for (right, down, share) in
            [(0, 0, (1.0 - s) * (1.0 - t)), (1, 0, s * (1.0 - t)), (0, 1, (1.0 - s) * t), (1, 1, s * t)]
        {
            let p = positions[(grid.first + (j + down) * grid.width + i + right) as usize];
            (0..3).for_each(|c| way[c] -= f64::from(share) * f64::from(p[c]));
        }
        most = most.max(way.iter().map(|x| x * x).sum::<f64>().sqrt() - f64::from(stitch.distance));
    }
    most
}

/// The largest distance of duplicates \[m\].
fn gap(cloth: &Cloth, positions: &[[f32; 4]]) -> f32 {
    let (starts, members) = cloth.rings();
    let rings = starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]);
    let far = rings.flat_map(|ring| ring.windows(2).map(|m| (positions[m[0] as usize], positions[m[1] as usize])));
    far.map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max)).fold(0.0, f32::max)
}

#[test]
fn a_patch_stays_on_its_cloth_and_falls_off_without_stitches() {
    let loose = scene(patched_charts(17, false));
    for mut rig in Rig::both(&loose, &options(16)) {
        rig.frames(60);
        assert!(rig.positions(0)[2 * 17 * 17][1] < -4.0, "{}: the loose patch falls", rig.name());
    }
    for fused in [false, true] {
        let tied = Scene { wind: Some(wind(true)), ..scene(patched_charts(17, true)) };
        for mut rig in Rig::both(&tied, &Options { fused, ..options(16) }) {
            rig.frames(300);
            let (cloth, now) = (&tied.cloths[0], rig.positions(0));
            let far = beyond(cloth, &now);
            eprintln!("{}, fused {fused}: stitches are up to {:.2} mm too long", rig.name(), 1e3 * far);
            assert!(far < 2e-3, "{}, fused {fused}: {far}", rig.name());
            assert_eq!(gap(cloth, &now), 0.0, "{}", rig.name());
        }
    }
}

#[test]
fn stitches_survive_a_storm_and_steps_of_a_tenth_of_a_second() {
    let storm = Wind { velocity: [30.0, 5.0, 10.0], ..wind(true) };
    let tied = Scene { wind: Some(storm), ..scene(patched_charts(17, true)) };
    for mut rig in Rig::both(&tied, &Options { step: 0.1, max_catch_up: 1, ..Options::default() }) {
        (0..40).for_each(|_| rig.frame(0.1));
        let now = rig.positions(0);
        assert!(now.iter().flatten().all(|x| x.is_finite()), "{}", rig.name());
        let far = beyond(&tied.cloths[0], &now);
        assert!(far < 0.1, "{}: {far}", rig.name());
    }
}

#[test]
fn stitches_conserve_momentum() {
    // Apart at the start, without gravity. Without seams, whose means conserve it to the accuracy of springs only.
    let sewn = patched_charts(17, true);
    let pushed = |(k, p): (usize, &[f32; 3])| if k < 2 * 17 * 17 { *p } else { [p[0], p[1], p[2] + 0.05] };
    let parts = Parts {
        name: "apart".into(),
        grids: sewn.grids().to_vec(),
        positions: sewn.positions().iter().enumerate().map(pushed).collect(),
        particles: vec![Particle::Free { next: None }; sewn.len()],
        rest: sewn.rest().clone(),
        mass: Mass::Constant(1e-3),
    };
    let mut cloth = Cloth::new(parts).unwrap();
    cloth.set_stitches(sewn.stitches().to_vec()).unwrap();
    let mut free = scene(cloth);
    free.gravity = [0.0; 3];
    for mut rig in Rig::both(&free, &options(8)) {
        let center =
            |now: &[[f32; 4]]| now.iter().fold([0.0f64; 3], |sum, p| [0, 1, 2].map(|c| sum[c] + f64::from(p[c])));
        let (start, patch) = (center(&rig.positions(0)), rig.positions(0)[2 * 17 * 17][2]);
        rig.frames(30);
        let end = center(&rig.positions(0));
        let count = free.cloths[0].len() as f64;
        let moved = (0..3).map(|c| (end[c] - start[c]).abs() / count).fold(0.0, f64::max);
        assert!((rig.positions(0)[2 * 17 * 17][2] - patch).abs() > 0.01, "{}: the patch is drawn back", rig.name());
        assert!(moved < 2e-5, "{}: the centre has moved by {moved} m", rig.name());
    }
}

#[test]
fn no_stitches_cost_nothing() {
    let plan = |cloth: Cloth| Stepper::on_cpu(scene(cloth), options(1)).unwrap().plan();
    let (without, with) = (plan(patched_charts(9, false)), plan(patched_charts(9, true)));
    assert_eq!(with.dispatches(), without.dispatches() + 2);
    assert!(with.bytes() > without.bytes());
    let sewn = |plan: &Plan| plan.passes.iter().any(|p| format!("{p:?}").contains("Stitch"));
    assert!(!sewn(&without) && sewn(&with));
    let mut cloth = patched_charts(9, true);
    cloth.set_stitches(Vec::new()).unwrap();
    assert_eq!(plan(cloth).bytes(), without.bytes());
}

#[test]
fn a_stitch_ends_where_its_quad_is_cut_away() {
    for mut rig in Rig::both(&scene(patched_charts(17, true)), &options(16)) {
        // All quads of the charts that the patch hangs on.
        for k in 0..40 {
            let x = 0.35 + 0.0085 * k as f32;
            rig.stepper.cut([x, -0.6, 3.0], [x, 9.0, -2.0], [x, -9.0, -2.0]).unwrap();
        }
        rig.frames(60);
        let low = rig.positions(0)[2 * 17 * 17 + 31][1];
        assert!(low < -3.0, "{}: the patch falls, to {low}", rig.name());
    }
}

#[test]
fn a_coarser_image_hangs_together_too() {
    let fine = patched_charts(17, true);
    let coarse = fine.coarser().unwrap().cloth().clone();
    assert!(coarse.stitches().len() > 8, "{}", coarse.stitches().len());
    let tied = scene(coarse);
    for mut rig in Rig::both(&tied, &options(16)) {
        rig.frames(120);
        let far = beyond(&tied.cloths[0], &rig.positions(0));
        assert!(far < 2e-3, "{}: {far}", rig.name());
    }
}

#[test]
fn both_backends_and_all_forms_agree() {
    let Some(device) = support::device() else { return };
    let tied = scene(patched_charts(17, true));
    let step = |fused: bool| {
        let options = Options { fused, ..options(2) };
        let (mut cpu, mut gpu) = (Rig::cpu(tied.clone(), &options), Rig::gpu(tied.clone(), &options, &device));
        [&mut cpu, &mut gpu].into_iter().for_each(|rig| rig.frames(2));
        assert!(largest(&cpu.positions(0), &gpu.positions(0)) < 1e-4);
        gpu.positions(0)
    };
    assert!(largest(&step(false), &step(true)) < 1e-4);
    let again = || {
        let mut rig = Rig::gpu(tied.clone(), &options(8), &device);
        rig.frames(20);
        rig.positions(0)
    };
    assert_eq!(again(), again(), "the same bits twice");
}

#[test]
fn stitches_that_lead_nowhere_are_refused_and_loose_grids_are_named() {
    let mut cloth = patched_charts(9, true);
    let good = cloth.stitches()[0];
    let bad = [
        Stitch { particle: 9999, ..good },
        Stitch { piece: 7, ..good },
        Stitch { at: [1.5, 0.0], ..good },
        Stitch { at: [f32::NAN, 0.0], ..good },
        Stitch { distance: -1.0, ..good },
        Stitch { distance: f32::INFINITY, ..good },
    ];
    for stitch in bad {
        assert!(cloth.set_stitches(vec![stitch]).is_err(), "{stitch:?}");
    }
    assert!(cloth.set_stitches(vec![good, good]).is_err());
    let crowd = (0..63).map(|k| Stitch { particle: 2 * 81 + k, piece: 0, at: [0.01, 0.01], distance: 0.0 });
    assert!(cloth.set_stitches(crowd.collect()).is_err());
    assert!(cloth.loose_grids().is_empty());
    cloth.set_stitches(Vec::new()).unwrap();
    assert_eq!(cloth.loose_grids(), [2]);
    let mut stepper = Stepper::on_cpu(scene(cloth), options(1)).unwrap();
    let words: Vec<String> = stepper.warnings().iter().map(ToString::to_string).collect();
    assert!(words.iter().any(|w| w.contains("nothing holds patch")), "{words:?}");
    (0..150).for_each(|_| _ = stepper.advance(1.0 / 60.0).unwrap());
    let found: Vec<String> = stepper.findings().iter().map(ToString::to_string).collect();
    assert_eq!(found.iter().filter(|words| words.contains("piece 'patch' falls")).count(), 1, "{found:?}");
    assert!(curtain(5).loose_grids().is_empty());
}
