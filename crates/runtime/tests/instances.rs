//! Instances of one cloth: they share its images, and move as each does alone.

use crate::support::rig::Rig;
use crate::support::{self, all_colliders, curtain, hung_tube, made_of, scene};
use gimage_runtime::*;

/// A cloth at another place.
fn at(cloth: &Cloth, x: f32) -> Cloth {
    let mut cloth = cloth.clone();
    cloth.place(cloth.positions().iter().map(|p| [p[0] + x, p[1], p[2]]).collect()).unwrap();
    cloth
}

/// Cloths of every kind of list: constant and image rest lengths, seams, tethers, material, limits.
fn kinds() -> Vec<Cloth> {
    let mut limited = curtain(14);
    limited.limits = Some((0..196).map(|k| 0.3 + 1e-3 * k as f32).collect());
    vec![curtain(16), hung_tube(1), made_of(curtain(12)), limited]
}

#[test]
fn instances_move_as_each_does_alone() {
    for (n, cloth) in kinds().into_iter().enumerate() {
        let mut all = scene(cloth.clone());
        all.cloths.extend([at(&cloth, 4.0), curtain(11), at(&cloth, 8.0)]);
        all.colliders = all_colliders();
        let options = Options { substeps: Some(8), polish: Some(2), tethers: 2, ..Options::default() };
        for mut rig in Rig::both(&all, &options) {
            rig.frames(8);
            for cloth in [0, 1, 3] {
                let mut own = scene(all.cloths[cloth].clone());
                own.colliders = all_colliders();
                let mut alone = rig.another(&own);
                alone.frames(8);
                let name = rig.name();
                assert_eq!(rig.positions(cloth), alone.positions(0), "{name}: kind {n}, cloth {cloth}");
                assert_eq!(rig.normals(cloth), alone.normals(0), "{name}: kind {n}, cloth {cloth}");
            }
        }
    }
}

#[test]
fn a_thousand_instances_have_one_copy_of_their_images() {
    for cloth in kinds() {
        let images = |count: u32, rig: &dyn Fn(Scene) -> Rig| {
            let mut of = scene(cloth.clone());
            of.cloths.extend((1..count).map(|k| at(&cloth, k as f32)));
            rig(of).stepper.memory()
        };
        let cpu = |scene| Rig::cpu(scene, &Options::default());
        let (one, many) = (images(1, &cpu), images(200, &cpu));
        assert_eq!(one.images, many.images, "{}", cloth.name());
        assert!(many.images_unshared >= 200 * one.images && many.states >= 190 * one.states, "{many:?} {one:?}");
        // Cloths that were made one by one are recognized by their contents.
        let mut of = scene(cloth.clone());
        of.cloths.extend(kinds().into_iter().filter(|c| c.len() == cloth.len()));
        assert_eq!(Rig::cpu(of, &Options::default()).stepper.memory().images, one.images);
        let Some(device) = support::device() else { continue };
        let gpu = |scene| Rig::gpu(scene, &Options::default(), &device);
        let (one, many) = (images(1, &gpu), images(200, &gpu));
        // Jobs and grids, three numbers of a material, seams and targets are each cloth's own.
        let rings = 4 * (cloth.rings().0.len() + cloth.rings().1.len()) as u64;
        let targets = cloth.limits.as_ref().map_or(0, |l| 16 * l.len().next_multiple_of(64) as u64);
        let own = 200 * (96 + 32 + 16 + rings + targets);
        assert!(many.device_images <= one.device_images + own, "{}: {one:?}, {many:?}", cloth.name());
        assert!(many.device_states > 190 * one.device_states, "{one:?} {many:?}");
    }
}

#[test]
fn a_cut_or_a_pin_of_one_instance_leaves_the_others() {
    let cloth = curtain(16);
    let mut all = scene(cloth.clone());
    all.cloths.extend([at(&cloth, 4.0), at(&cloth, 8.0)]);
    let options = Options { tethers: 1, ..Options::default() };
    for mut rig in Rig::both(&all, &options) {
        let mut other = rig.another(&all);
        rig.frames(4);
        other.frames(4);
        rig.stepper.cut([4.5, -0.4, 3.0], [3.0, -0.4, -3.0], [6.0, -0.4, -3.0]).unwrap();
        rig.stepper.unpin(2, &[15]).unwrap();
        rig.frames(8);
        other.frames(8);
        let name = rig.name();
        assert_eq!(rig.positions(0), other.positions(0), "{name}: neither cut nor freed");
        assert_ne!(rig.positions(1), other.positions(1), "{name}: cut");
        assert_ne!(rig.positions(2), other.positions(2), "{name}: freed");
        // A cloth that comes later shares what is left.
        rig.stepper.add_cloth(at(&cloth, 12.0)).unwrap();
        rig.frames(2);
        assert!(rig.positions(3).iter().flatten().all(|x| x.is_finite()), "{name}");
    }
}

#[test]
fn threads_share_cloths_and_give_the_same_bits() {
    let cloth = curtain(24);
    let mut all = scene(cloth.clone());
    all.cloths.extend((1..12).map(|k| at(&cloth, k as f32)));
    all.cloths.push(hung_tube(1));
    all.colliders = all_colliders();
    all.cloths.push(curtain(160));
    let run = |threads| {
        let mut rig = Rig::cpu(all.clone(), &Options { threads, substeps: Some(8), ..Options::default() });
        rig.frames(6);
        let findings = format!("{:?}", rig.stepper.findings());
        ((0..all.cloths.len()).map(|c| rig.positions(c)).collect::<Vec<_>>(), findings)
    };
    let one = run(1);
    for threads in [2, 3, 0] {
        assert_eq!(run(threads), one, "{threads} threads");
    }
}
