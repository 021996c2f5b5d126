//! Backstops of particles: how far each may be behind its position at rest, or behind the skin.

use crate::support::{scene, tube};
use gimage_runtime::*;

fn options() -> Options {
    Options { backend: Backend::Cpu, ..Options::default() }
}

/// All particles of a cloth have one backstop, but every fifth, or ring that begins with one, has none.
fn backed(mut cloth: Cloth, distance: f32, radius: f32) -> Cloth {
    let mut all: Vec<_> =
        (0..cloth.len()).map(|k| if k % 5 == 4 { Backstop::NONE } else { Backstop { distance, radius } }).collect();
    let (starts, members) = cloth.rings();
    for ring in starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]) {
        ring.iter().for_each(|k| all[*k as usize] = all[ring[0] as usize]);
    }
    cloth.backstops = Some(all.into());
    cloth
}

/// A sheet that lies in the plane of x and z; it faces up, or down.
fn sheet(n: u32, up: bool) -> Cloth {
    let [right, down] = if up { [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]] } else { [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]] };
    Flat { right, down, ..Flat::square("sheet", n) }.cloth().unwrap()
}

#[test]
fn no_particle_falls_behind_its_backstop_and_free_ones_fall() {
    // Found by the normals that are drawn: the sphere is on the other side.
    let facing = |up| Stepper::on_cpu(scene(sheet(9, up)), options()).unwrap().normals(0).unwrap()[40][1];
    let up = facing(true) > 0.0;
    assert!((facing(up) > 0.99) && facing(!up) < -0.99);
    for (faces_up, distance) in [(true, 0.02), (true, 0.0), (false, 0.02)] {
        let mut cloth = sheet(9, up == faces_up);
        cloth.backstops = Some(vec![Backstop { distance, radius: 2.0 }; 81].into());
        let mut stepper = Stepper::on_cpu(scene(cloth), options()).unwrap();
        (0..60).for_each(|_| _ = stepper.advance(1.0 / 60.0).unwrap());
        let heights: Vec<f32> = stepper.positions(0).unwrap().iter().map(|p| p[1]).collect();
        if faces_up {
            assert!(heights.iter().all(|y| (y + distance).abs() < 2e-3), "{distance}: {heights:?}");
        } else {
            assert!(heights.iter().all(|y| *y < -3.0), "what falls away from its sphere is free: {heights:?}");
        }
    }
}

#[test]
fn particles_without_one_pass_and_a_teleport_takes_spheres_along() {
    let mut stepper = Stepper::on_cpu(scene(backed(sheet(9, true), 0.01, 1.0)), options()).unwrap();
    let up = stepper.normals(0).unwrap()[40][1] > 0.0;
    let cloth = backed(sheet(9, up), 0.01, 1.0);
    let loose: Vec<usize> = (0..81).filter(|k| cloth.backstops.as_ref().unwrap()[*k] == Backstop::NONE).collect();
    assert!(loose.len() > 10);
    let mut free = cloth.clone();
    free.backstops = Some(vec![Backstop::NONE; 81].into());
    stepper = Stepper::on_cpu(scene(cloth), options()).unwrap();
    stepper.teleport(0, &scene::Pose { position: [5.0, 20.0, 0.0], ..Default::default() }).unwrap();
    (0..60).for_each(|_| _ = stepper.advance(1.0 / 60.0).unwrap());
    let lowest = |stepper: &Stepper| stepper.positions(0).unwrap().iter().map(|p| p[1]).fold(f32::MAX, f32::min);
    assert!((19.9..19.999).contains(&lowest(&stepper)), "{}", lowest(&stepper));
    let mut stepper = Stepper::on_cpu(scene(free), options()).unwrap();
    (0..60).for_each(|_| _ = stepper.advance(1.0 / 60.0).unwrap());
    assert!(lowest(&stepper) < -3.0);
}

#[test]
fn backstops_are_a_pass_of_their_own_and_cost_nothing_without() {
    let count = |cloth: Cloth| {
        let plan = Stepper::on_cpu(scene(cloth), options()).unwrap().plan();
        let bound = plan.passes.iter().flat_map(|p| &p.bindings).filter(|b| b.0.contains("back")).count();
        (plan.passes.iter().filter(|p| p.form.pass() == Some(Pass::Backstop { moves: false })).count(), bound)
    };
    assert_eq!((count(backed(tube(17, 12, 1), 0.01, 0.1)).0, count(tube(17, 12, 1))), (1, (0, 0)));
}

#[test]
fn backstops_that_cannot_hold_are_errors() {
    let fails = |change: fn(&mut Vec<Backstop>)| {
        let mut cloth = backed(tube(17, 12, 1), 0.01, 0.1);
        let mut backstops = cloth.backstops.as_deref().unwrap().to_vec();
        change(&mut backstops);
        cloth.backstops = Some(backstops.into());
        Stepper::on_cpu(scene(cloth), options()).map(|_| ()).unwrap_err().to_string()
    };
    assert!(fails(|all| _ = all.pop()).contains("number of backstops"));
    assert!(fails(|all| all[3].distance = f32::NAN).contains("distance of a backstop"));
    assert!(fails(|all| all[3].radius = 0.0).contains("radius of a backstop"));
    assert!(fails(|all| all[17].distance = 0.5).contains("seam duplicates"));
}

#[test]
fn a_bundle_brings_its_backstops() {
    use gimage_bundle::{Image, MapKind};
    let flat = Flat::square("flat", 4).cloth().unwrap();
    let mut bundle = gimage_bundle::Bundle::new("test");
    bundle.add_piece("flat", 4, 4).unwrap();
    let free = Particle::Free { next: None }.code().unwrap();
    let data = flat.positions().iter().flat_map(|p| [p[0], p[1], p[2], free]).collect();
    bundle.insert(0, MapKind::Position, Image { width: 4, height: 4, channels: 4, data }).unwrap();
    assert_eq!(Cloth::from_bundle("flat", &bundle).unwrap().backstops, None);
    let data = (0..16).flat_map(|k| if k == 3 { [-1.0, 0.0, 0.0] } else { [0.02, 0.3, 0.0] }).collect();
    bundle.insert(0, MapKind::Backstop, Image { width: 4, height: 4, channels: 3, data }).unwrap();
    bundle.count().unwrap();
    assert_eq!(gimage_bundle::validate(&bundle), []);
    let backstops = Cloth::from_bundle("flat", &bundle).unwrap().backstops.unwrap();
    let one = Backstop { distance: 0.02, radius: 0.3 };
    assert!(backstops.iter().enumerate().all(|(k, b)| if k == 3 { !b.exists() } else { *b == one }));
    bundle.images.get_mut(&(0, MapKind::Backstop)).unwrap().data[1] = 0.0;
    let faults = gimage_bundle::validate(&bundle);
    assert!(faults.len() == 1 && faults[0].kind == gimage_bundle::FaultKind::Backstop, "{faults:?}");
}

#[cfg(feature = "gpu")]
mod backends {
    use super::*;
    use crate::support::rig::{FRAME, Rig, largest};
    use gimage_runtime::scene::{Pose, about};

    /// Has a cloth follow one joint.
    fn led(mut cloth: Cloth) -> Cloth {
        let influence = Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] };
        cloth.set_skin(vec![SkinJoint::default()], &vec![influence; cloth.len()]).unwrap();
        cloth.follow_joints(&[joint(0)]).unwrap();
        cloth
    }

    /// The matrix of the joint at the end of a frame: it turns about an axis across the cloth.
    fn joint(frame: u32) -> [f32; 16] {
        let pose = Pose { rotation: about([0.3, 0.2, 1.0], 0.05 * f64::from(frame)), ..Pose::default() };
        pose.columns().concat().try_into().unwrap()
    }

    fn frame(rig: &mut Rig, n: u32) {
        if rig.stepper.scene().cloths[0].follows_joints() {
            rig.stepper.set_joints(0, &[joint(n)]).unwrap();
        }
        rig.frame(FRAME);
    }

    /// A tube that hangs by its first row, and a sheet too large for a workgroup, at rest and on a joint; whether it runs whole frames.
    fn cloths() -> Vec<(Cloth, bool)> {
        let hung = |mut cloth: Cloth, n: u32| {
            cloth.pin(&(0..n).collect::<Vec<_>>()).unwrap();
            cloth
        };
        let tube = backed(hung(tube(17, 12, 1), 17), 0.003, 0.1);
        let mut sheet = backed(hung(sheet(70, true), 70), 0.003, 0.1);
        sheet.limits = Some((0..sheet.len()).map(|k| if k % 70 < 9 { 0.05 } else { -1.0 }).collect());
        vec![(tube.clone(), true), (sheet.clone(), false), (led(tube), true), (led(sheet), false)]
    }

    /// In separate passes, by tiles and in whole frames: the same bits, and those of the twin to rounding; twice the same bits.
    #[test]
    fn every_form_has_the_same_backstops() {
        let Some(device) = crate::support::device_with(device_limits) else { return };
        for (cloth, whole) in cloths() {
            let scene = scene(cloth);
            let run = |fused| {
                let mut rig = Rig::gpu(scene.clone(), &Options { fused, ..Options::default() }, &device);
                let plan = rig.stepper.plan();
                let holds = plan.passes.iter().filter(|p| matches!(p.form, Form::Whole(_))).count();
                let tiles = plan.passes.iter().filter(|p| matches!(p.form, Form::Tile(_))).count();
                frame(&mut rig, 1);
                let first = rig.positions(0);
                (2..4).for_each(|n| frame(&mut rig, n));
                (holds, tiles, rig.positions(0), first)
            };
            let (fused, apart, again) = (run(true), run(false), run(true));
            assert_eq!((fused.0 > 0, fused.1 > 0, apart.0 + apart.1), (whole, !whole, 0));
            assert!(fused.2 == again.2);
            let mut cpu = Rig::cpu(scene.clone(), &Options::default());
            frame(&mut cpu, 1);
            let far = largest(&cpu.positions(0), &fused.3);
            assert!(far < 1e-5, "{far}");
            let far = largest(&apart.2, &fused.2);
            assert!(far == 0.0 || crate::support::alike::tolerates(&device) && far < 1e-4, "{far}");
        }
    }

    /// Behind the skin that moves: no particle deeper in its sphere than rounding, where without backstops many are.
    #[test]
    fn spheres_follow_the_joints() {
        let cloth = led(backed(tube(17, 12, 1), 0.003, 0.1));
        let mut free = cloth.clone();
        free.backstops = None;
        // Normals at the rims are not radial: the quads there have diagonals to one side.
        let inner = |k: usize| (1..11).contains(&(k / 17));
        let (side, shape) = (if facing_out() { -1.0 } else { 1.0 }, tube(17, 12, 1).positions().to_vec());
        for (cloth, keeps) in [(cloth, true), (free, false)] {
            let backstops = backed(tube(17, 12, 1), 0.003, 0.1).backstops.unwrap();
            for mut rig in Rig::both(&scene(cloth.clone()), &Options::default()) {
                let mut deepest = 0.0f32;
                for n in 1..20 {
                    frame(&mut rig, n);
                    // Where the joint has the particle, back at rest: the axis of the tube is y, and its normals point along or against
                    // the radius.
                    let m = joint(n);
                    let positions = rig.positions(0);
                    let backed = positions.iter().enumerate().filter(|(k, _)| inner(*k) && backstops[*k].exists());
                    for (k, p) in backed {
                        let back: [f32; 3] = std::array::from_fn(|c| (0..3).map(|r| m[4 * c + r] * p[r]).sum());
                        let rest = shape[k];
                        let share = 1.0 + side * 0.103 / rest[0].hypot(rest[2]);
                        let center = [rest[0] * share, rest[1], rest[2] * share];
                        let far = (0..3).map(|c| (back[c] - center[c]).powi(2)).sum::<f32>().sqrt();
                        deepest = deepest.max(0.1 - far);
                    }
                }
                assert_eq!(deepest < 1e-5, keeps, "{}: {deepest}", rig.name());
            }
        }
    }

    fn facing_out() -> bool {
        let stepper = Stepper::on_cpu(scene(tube(17, 12, 1)), options()).unwrap();
        let (normal, at) = (stepper.normals(0).unwrap()[100], stepper.positions(0).unwrap()[100]);
        normal[0] * at[0] + normal[2] * at[2] > 0.0
    }
}
