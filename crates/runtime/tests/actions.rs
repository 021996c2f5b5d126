//! Moving sets of particles, and dragging.

use crate::support::rig::{FRAME, Rig, largest};
use crate::support::{self, curtain, scene, tube, two_charts};
use gimage_runtime::*;

/// A turn about an oblique axis, and a shift.
fn turn() -> [[f32; 4]; 4] {
    let [x, y, z, w] = [0.1f32, 0.5, -0.3, 0.806_225_8];
    let column = |c: [f32; 3]| [c[0], c[1], c[2], 0.0];
    [
        column([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)]),
        column([2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)]),
        column([2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)]),
        [0.2, -0.1, 0.4, 1.0],
    ]
}

fn applied(m: [[f32; 4]; 4], p: [f32; 4]) -> [f64; 3] {
    [0, 1, 2].map(|r| (0..3).map(|c| f64::from(m[c][r]) * f64::from(p[c])).sum::<f64>() + f64::from(m[3][r]))
}

#[test]
fn a_set_is_moved_with_its_duplicates_and_its_velocity() {
    for cloth in [curtain(12), tube(17, 12, 4), two_charts(9)] {
        let chosen: Vec<usize> = (0..cloth.len()).step_by(3).collect();
        let all: Vec<bool> = (0..cloth.len())
            .map(|k| {
                let ring = cloth.ring_of(k as u32).map(|r| r.iter().any(|m| m % 3 == 0));
                ring.unwrap_or(k % 3 == 0)
            })
            .collect();
        assert!(cloth.ring_count() == 0 || all.iter().filter(|a| **a).count() > chosen.len());
        for mut rig in Rig::both(&scene(cloth.clone()), &Options::default()) {
            rig.frames(3);
            let (now, before) = (rig.positions(0), rig.previous(0));
            rig.stepper.transform(0, &chosen, turn()).unwrap();
            assert_eq!(rig.positions(0), now, "it waits for the frame");
            rig.frame(0.0);
            for (was, is) in [(now, rig.positions(0)), (before, rig.previous(0))] {
                for k in 0..cloth.len() {
                    let place = if all[k] { applied(turn(), was[k]) } else { [0, 1, 2].map(|c| was[k][c].into()) };
                    let error = (0..3).map(|c| (place[c] - f64::from(is[k][c])).abs()).fold(0.0, f64::max);
                    assert!(error < 3e-7 && was[k][3] == is[k][3], "{} {k}: {error:e}", rig.name());
                }
            }
        }
    }
}

#[test]
fn a_transform_is_that_of_the_twin() {
    let Some(device) = support::device() else { return };
    for (name, cloth) in [("flat", curtain(20)), ("seam", tube(17, 12, 3))] {
        let chosen: Vec<usize> = (0..60).collect();
        let mut rigs = [
            Rig::cpu(scene(cloth.clone()), &Options::default()),
            Rig::gpu(scene(cloth.clone()), &Options::default(), &device),
        ];
        for rig in &mut rigs {
            // In the order of the calls: a shift of what was turned.
            rig.stepper.transform(0, &chosen, turn()).unwrap();
            let mut shift = [[0.0; 4]; 4];
            (0..4).for_each(|c| shift[c][c] = 1.0);
            shift[3][0] = 0.5;
            rig.stepper.transform(0, &chosen[..20], shift).unwrap();
            rig.frame(0.0);
        }
        let difference = largest(&rigs[0].positions(0), &rigs[1].positions(0));
        eprintln!("{name}: {difference:e} m");
        assert!(difference <= 1e-6, "{name}: {difference:e} m");
        assert!(largest(&rigs[0].previous(0), &rigs[1].previous(0)) <= 1e-6);
        assert!(largest(&rigs[0].normals(0), &rigs[1].normals(0)) <= 2e-3);
    }
}

#[test]
fn a_pinned_row_is_carried_frame_by_frame() {
    for mut rig in Rig::both(&scene(curtain(16)), &Options::default()) {
        let row: Vec<usize> = (0..16).collect();
        let mut step = [[0.0; 4]; 4];
        (0..4).for_each(|c| step[c][c] = 1.0);
        step[3][0] = 0.01;
        for _ in 0..60 {
            rig.stepper.transform(0, &row, step).unwrap();
            rig.frame(FRAME);
        }
        let now = rig.positions(0);
        assert!((now[0][0] - 0.6).abs() < 1e-4 && now[0][1] == 0.0, "{}: {:?}", rig.name(), now[0]);
        assert!(now[16 * 15][0] > 0.2, "{}: the hem follows", rig.name());
    }
}

#[test]
fn what_is_dragged_is_held_and_then_let_go() {
    for mut rig in Rig::both(&scene(two_charts(9)), &Options::default()) {
        rig.frames(2);
        // Onto the seam, whose duplicates must follow, and far from what is pinned.
        let hit = rig.pick([0.51, -0.52, 2.0], [0.0, 0.0, -1.0]).unwrap();
        let (point, before) = (hit.point(), rig.positions(0));
        let drag = rig.stepper.grab(&hit).unwrap();
        rig.frame(FRAME);
        let held = rig.positions(0);
        for k in hit.particles {
            let k = k as usize;
            let moved = (0..3).map(|c| (held[k][c] - before[k][c]).abs()).fold(0.0, f32::max);
            assert!(held[k][3] == 0.0 && moved < 1e-6, "{}: {moved:e}", rig.name());
        }
        let to = [point[0] - 0.1, point[1] + 0.2, point[2] + 0.1];
        rig.stepper.drag(&drag, to).unwrap();
        rig.frames(5);
        let there = rig.positions(0);
        for k in hit.particles {
            for c in 0..3 {
                let by = to[c] - point[c];
                assert!((there[k as usize][c] - before[k as usize][c] - by).abs() < 1e-6, "{}", rig.name());
            }
        }
        for j in 0..9 {
            assert_eq!(there[9 * j + 8][..3], there[81 + 9 * j][..3], "{}: the seam", rig.name());
        }
        rig.stepper.release(drag).unwrap();
        rig.frames(10);
        let gone = rig.positions(0);
        let free = hit.particles.iter().filter(|k| gone[**k as usize][3] > 0.0).count();
        assert_eq!(free, 3, "{}", rig.name());
        assert!(gone[hit.particles[0] as usize][1] < there[hit.particles[0] as usize][1] - 0.01, "{}", rig.name());
        // Particles that were pinned before stay so.
        let pinned = rig.pick([0.01, -0.4, 2.0], [0.0, 0.0, -1.0]).unwrap();
        let drag = rig.stepper.grab(&pinned).unwrap();
        rig.stepper.release(drag).unwrap();
        rig.frame(FRAME);
        let now = rig.positions(0);
        let held = pinned.particles.map(|k| now[k as usize][3] == 0.0);
        let edge = pinned.particles.map(|k| k % 9 == 0);
        assert_eq!(held, edge, "{}", rig.name());
    }
}

#[test]
fn wrong_actions_are_errors() {
    let mut rig = Rig::cpu(scene(curtain(8)), &Options::default());
    let stepper = &mut rig.stepper;
    let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    assert!(stepper.transform(1, &[0], identity).unwrap_err().to_string().contains("no cloth 1"));
    assert!(stepper.transform(0, &[64], identity).unwrap_err().to_string().contains("no particle 64"));
    let mut projective = identity;
    projective[1][3] = 0.1;
    assert!(stepper.transform(0, &[0], projective).unwrap_err().to_string().contains("last row"));
    let mut broken = identity;
    broken[3][1] = f32::NAN;
    assert!(stepper.transform(0, &[0], broken).unwrap_err().to_string().contains("finite"));
    assert!(stepper.transform(0, &[], identity).is_ok());
    let hit = stepper.pick([0.5, -0.5, 1.0], [0.0, 0.0, -1.0]).unwrap().unwrap();
    assert!(stepper.grab(&Hit { cloth: 3, handle: None, ..hit }).is_err());
    assert!(stepper.grab(&Hit { particles: [900; 3], ..hit }).is_err());
    let drag = stepper.grab(&hit).unwrap();
    assert!(stepper.drag(&drag, [f32::INFINITY; 3]).is_err());
}
