//! Tethers after a cut: cloth that still hangs is as true as it was, and what is cut off falls.

use crate::support::rig::{FRAME, Rig, center, largest};
use crate::support::{self, curtain, scene, two_charts};
use gimage_runtime::*;

fn options(substeps: u32) -> Options {
    Options { solver: Solver::Xpbd, substeps: Some(substeps), ..Options::default() }
}

/// A cut from behind the eye through what lies between two points of the plane of a sheet that hangs at z = 0.
fn cut(rig: &mut Rig, [p, q]: [[f32; 2]; 2]) {
    let middle = [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
    let end = |x: [f32; 2]| [2.0 * x[0] - middle[0], 2.0 * x[1] - middle[1], -5.0];
    rig.stepper.cut([middle[0], middle[1], 5.0], end(p), end(q)).unwrap();
}

/// The largest stretch of springs to the right and down among the particles chosen.
fn stretch(rig: &Rig, n: usize, chosen: impl Fn(usize) -> bool) -> f64 {
    let now = rig.positions(0);
    let length = |a: usize, b: usize| (0..3).map(|c| f64::from(now[a][c] - now[b][c]).powi(2)).sum::<f64>().sqrt();
    let right = (0..n * n).filter(|k| k % n + 1 < n).map(|k| (k, k + 1));
    let springs = right.chain((0..n * (n - 1)).map(|k| (k, k + n))).filter(|(a, b)| chosen(*a) && chosen(*b));
    springs.map(|(a, b)| length(a, b) * (n - 1) as f64 - 1.0).fold(0.0, f64::max)
}

#[test]
fn a_sheet_that_lost_a_corner_is_as_true_as_before() {
    const N: usize = 64;
    // Particles are left where column and row add up to less than those of the stroke.
    let left = |k: usize| k % N + k / N < 96;
    let run = |tethers, cuts: bool| {
        let mut rig = Rig::cpu(scene::builtin("s1", N as u32).unwrap(), &Options { tethers, ..options(8) });
        rig.frames(240);
        if cuts {
            cut(&mut rig, [[0.5, -1.1], [1.1, -0.5]]);
        }
        rig.frames(240);
        let lowest = rig.positions(0).iter().map(|p| p[1]).fold(0.0, f32::min);
        (stretch(&rig, N, left), lowest)
    };
    let ((whole, _), (cut, fell), (without, _)) = (run(2, false), run(2, true), run(0, true));
    eprintln!("largest stretch: {whole:.4} uncut, {cut:.4} cut, {without:.4} cut without tethers");
    assert!(fell < -5.0 && cut < whole + 0.002 && without > 20.0 * cut, "{whole} {cut} {without}, {fell}");
}

#[test]
fn cloth_under_a_slit_hangs_from_beside_it() {
    const N: usize = 41;
    for mut rig in Rig::both(&scene(curtain(N as u32)), &options(4)) {
        rig.frames(10);
        cut(&mut rig, [[0.3, -0.33], [0.7, -0.33]]);
        rig.frames(120);
        let now = rig.positions(0);
        // It sags below the slit by no more than the way round it allows, and what is beside it does not.
        let (under, beside) = (now[30 * N + 20][1], now[30 * N + 2][1]);
        assert!((-0.95..-0.755).contains(&under) && (beside + 0.75).abs() < 0.02, "{}: {under} {beside}", rig.name());
        let stretch = stretch(&rig, N, |k| k / N > 20);
        assert!(stretch < 0.1, "{}: {stretch}", rig.name());
    }
}

#[test]
fn a_second_cut_frees_what_the_first_has_left_hanging() {
    let below = |k: usize| k % 289 / 17 > 8;
    let mut charts = two_charts(17);
    (1..17).for_each(|j| charts.set_pinned(17 * j, false).unwrap());
    for second in [false, true] {
        for mut rig in Rig::both(&scene(charts.clone()), &options(4)) {
            // Held at its upper left corner, sewn along x = 0.5: the first cut goes across the seam.
            cut(&mut rig, [[-0.1, -0.47], [0.6, -0.47]]);
            rig.frame(FRAME);
            if second {
                cut(&mut rig, [[0.5, -0.47], [1.1, -0.47]]);
            }
            rig.frames(60);
            let [upper, lower] = [false, true].map(|low| center(&rig.positions(0), |k| below(k) == low));
            assert_eq!(lower[1] < -3.0, second, "{}: {lower:?}", rig.name());
            assert!(upper[1] > -1.5 && (second || lower[1] > -1.8), "{}: {upper:?} {lower:?}", rig.name());
        }
    }
}

#[test]
fn the_backends_go_on_alike_with_and_without_normals() {
    let Some(device) = support::device() else { return };
    for normals in [true, false] {
        let options = Options { normals, ..options(4) };
        let scene = scene::builtin("s1", 24).unwrap();
        let mut rigs = [Rig::cpu(scene.clone(), &options), Rig::gpu(scene.clone(), &options, &device)];
        let mut again = Rig::gpu(scene, &options, &device);
        for rig in rigs.iter_mut().chain([&mut again]) {
            rig.frames(2);
            rig.stepper.cut([0.5, 3.0, 0.5], [0.2, -3.0, 0.4], [0.9, -3.0, 0.5]).unwrap();
            rig.frames(6);
        }
        let [here, there] = rigs;
        let apart = largest(&here.positions(0), &there.positions(0));
        assert!(apart < 1e-3, "{apart}");
        assert!(there.positions(0) == again.positions(0));
        let hit = here.holes(0).unwrap().iter().filter(|b| **b > 0).count();
        assert!(hit > 5, "{hit}");
    }
}

#[test]
fn pins_that_change_after_a_cut_bring_no_tether_back() {
    for mut rig in Rig::both(&scene(curtain(21)), &options(4)) {
        cut(&mut rig, [[-0.1, -0.52], [1.1, -0.52]]);
        rig.frame(FRAME);
        // Freed and pinned again; and one that was none.
        for pinned in [false, true] {
            (0..21).for_each(|k| rig.stepper.set_pinned(0, k, pinned).unwrap());
        }
        rig.stepper.set_pinned(0, 5 * 21 + 10, true).unwrap();
        rig.frames(60);
        let now = rig.positions(0);
        let (upper, lower) = (center(&now, |k| k / 21 < 10), center(&now, |k| k / 21 > 11));
        assert!(upper[1] > -0.5 && lower[1] < -3.0, "{}: {upper:?} {lower:?}", rig.name());
    }
}

#[test]
fn only_cloth_that_was_cut_and_has_tethers_pays() {
    let plan = |tethers, cut: bool| {
        let options = Options { tethers, backend: Backend::Cpu, ..options(2) };
        let mut stepper = Stepper::new(scene(curtain(9)), options, None).unwrap();
        if cut {
            stepper.cut([0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]).unwrap();
        }
        let bound = |name| stepper.plan().passes.iter().flat_map(|p| p.bindings.clone()).any(|(slot, _)| slot == name);
        (bound("tethers"), ["supports", "holding", "changes", "mates"].iter().any(|n| bound(n)))
    };
    assert_eq!((plan(1, false), plan(1, true)), ((true, false), (true, false)));
    assert_eq!((plan(0, false), plan(0, true)), ((false, false), (false, false)));
}
