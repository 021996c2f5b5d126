//! Contact of cloth with itself.

use crate::support::rig::{Rig, largest};
use crate::support::{self, folded, scene, tube, two_charts};
use gimage_runtime::crossings::{self, Drawn};
use gimage_runtime::*;

const PASSES: [&str; 5] = ["leaves", "tree", "partners", "touch", "separate"];

/// The scene with contact of all its cloths.
fn with_contact(mut scene: Scene) -> Scene {
    scene.cloths.iter_mut().for_each(|cloth| cloth.contact = Some(ClothContact::default()));
    scene
}

fn options() -> Options {
    Options { threads: 1, ..Options::default() }
}

/// Crossings of a scene's cloths where they are now.
fn crossings_of(scene: &Scene, rig: &Rig) -> u64 {
    let now: Vec<_> = (0..scene.cloths.len()).map(|c| rig.positions(c)).collect();
    let drawn: Vec<Drawn> = scene.cloths.iter().zip(&now).map(|(cloth, now)| Drawn::at(cloth, now)).collect();
    crossings::find(&drawn, 0).unwrap().total()
}

#[test]
fn three_layers_stay_apart_on_a_table() {
    let without = folded(33, 0.03);
    let mut rig = Rig::cpu(without.clone(), &options());
    rig.frames(60);
    assert!(crossings_of(&without, &rig) > 1000, "the layers lie in one plane");
    let with = with_contact(without);
    for mut rig in Rig::both(&with, &options()) {
        for tenth in 0..10 {
            rig.frames(12);
            assert_eq!(crossings_of(&with, &rig), 0, "{} after {tenth} tenths", rig.name());
        }
    }
}

#[test]
fn a_sheet_that_collapses_on_a_table_hardly_crosses_itself() {
    let upright = Flat { origin: [0.0, 1.05, 0.0], down: [0.1, -1.0, 0.05], ..Flat::square("sheet", 33) };
    let mut cloth = upright.cloth().unwrap();
    cloth.damping = 0.5;
    let table = Collider { friction: 0.5, ..Collider::new(Shape::HalfSpace, [0.0; 3]) };
    let without = Scene { colliders: vec![table], ..scene(cloth) };
    let count = |scene: Scene| {
        let mut rig = Rig::cpu(scene.clone(), &options());
        rig.frames(120);
        crossings_of(&scene, &rig)
    };
    let (free, held) = (count(without.clone()), count(with_contact(without)));
    assert!(free > 2000 && held < free / 50, "{held} crossings with contact, {free} without");
}

#[test]
fn flat_cloth_and_closed_seams_are_left_as_they_are() {
    let mut pinned = two_charts(17);
    pinned.set_pinned(16, true).unwrap();
    let mut dense = Flat::square("dense", 17).cloth().unwrap();
    dense.contact = Some(ClothContact { distance: Some(0.2), ..ClothContact::default() });
    for cloth in [tube(17, 12, 1), pinned, dense] {
        let mut still = scene(cloth);
        still.gravity = [0.0; 3];
        let mut bare = still.clone();
        bare.cloths[0].contact = None;
        let settings = Options { substeps: Some(4), polish: Some(0), ..options() };
        let given = still.cloths[0].contact.unwrap_or_default();
        still.cloths[0].contact = Some(given);
        for (mut a, mut b) in Rig::both(&still, &settings).into_iter().zip(Rig::both(&bare, &settings)) {
            a.frames(3);
            b.frames(3);
            assert!(largest(&a.positions(0), &b.positions(0)) < 1e-6, "{}, {}", a.name(), still.cloths[0].name());
        }
    }
}

#[test]
fn duplicates_of_a_crumpled_seam_stay_together() {
    let mut cloth = tube(25, 20, 2);
    cloth.damping = 0.5;
    let table = Collider { friction: 0.5, ..Collider::new(Shape::HalfSpace, [0.0, -1.1, 0.0]) };
    let with = with_contact(Scene { colliders: vec![table], ..scene(cloth) });
    for mut rig in Rig::both(&with, &options()) {
        rig.frames(60);
        let (now, (starts, members)) = (rig.positions(0), with.cloths[0].rings());
        for ring in starts.windows(2) {
            let ring = &members[ring[0] as usize..ring[1] as usize];
            let first = now[ring[0] as usize];
            assert!(ring.iter().all(|k| now[*k as usize][..3] == first[..3]), "{}", rig.name());
        }
    }
}

#[test]
fn both_backends_agree_and_repeat_by_bits() {
    let with = with_contact(folded(21, 0.03));
    let settings = Options { substeps: Some(6), polish: Some(0), ..options() };
    let run = |rig: &mut Rig, frames| {
        rig.frames(frames);
        (rig.positions(0), rig.previous(0))
    };
    for (mut a, mut b) in Rig::both(&with, &settings).into_iter().zip(Rig::both(&with, &settings)) {
        assert_eq!(run(&mut a, 20), run(&mut b, 20), "{}", a.name());
    }
    let mut shared = Rig::cpu(with.clone(), &Options { threads: 3, ..settings.clone() });
    let mut rigs = Rig::both(&with, &settings);
    let alone = run(&mut rigs[0], 12);
    assert_eq!(run(&mut shared, 12), alone, "threads");
    if let Some(gpu) = rigs.get_mut(1) {
        let found = run(gpu, 12);
        assert!(largest(&found.0, &alone.0) < 2e-3, "{} m", largest(&found.0, &alone.0));
    }
}

#[test]
fn contact_is_planned_only_where_it_is_asked_for() {
    let names = |scene: Scene| {
        let stepper = Stepper::on_cpu(scene, Options { substeps: Some(12), ..options() }).unwrap();
        let plan = stepper.plan();
        PASSES.map(|name| plan.passes.iter().filter(|p| p.shader == name).map(|p| p.dispatches).sum::<u32>())
    };
    assert_eq!(names(folded(9, 0.03)), [0; 5]);
    assert_eq!(names(with_contact(folded(9, 0.03))), [2, 2, 2, 12, 12]);
}

#[test]
fn cloths_that_meet_have_few_passes_together() {
    let names = |scene: Scene| {
        let stepper = Stepper::on_cpu(scene, Options { substeps: Some(11), ..options() }).unwrap();
        let plan = stepper.plan();
        ["shadow", "extents", "others", "tree", "touch", "separate"]
            .map(|name| plan.passes.iter().filter(|p| p.shader == name).map(|p| p.dispatches).sum::<u32>())
    };
    let two = stacked([0.05, 0.1], 9);
    let mut alone = two.clone();
    alone.cloths[1].contact = None;
    assert_eq!(names(alone), [0, 0, 0, 2, 11, 11]);
    // Each shows itself every second step, and all search together every fourth one.
    assert_eq!(names(two), [12, 3, 3, 4 + 3, 22, 22]);
}

#[test]
fn the_tier_safe_has_passes_of_its_own_and_no_other_tier_has_them() {
    let names = |tiers: &[ContactTier]| {
        let mut scene = stacked([0.05, 0.1], 9);
        scene.cloths.truncate(tiers.len());
        for (cloth, tier) in scene.cloths.iter_mut().zip(tiers) {
            cloth.contact = Some(ClothContact { tier: *tier, ..ClothContact::default() });
        }
        let plan = Stepper::on_cpu(scene, Options { substeps: Some(11), ..options() }).unwrap().plan();
        let count = |name| plan.passes.iter().filter(|p| p.shader == name).map(|p| p.dispatches).sum::<u32>();
        ["gather", "hold_back", "paths", "truncate", "tree", "touch", "others"].map(count)
    };
    let (safe, particles) = (ContactTier::Safe, ContactTier::Particles);
    assert_eq!(names(&[particles]), [0, 0, 0, 0, 2, 11, 0]);
    assert_eq!(names(&[particles; 2]), [0, 0, 0, 0, 4 + 3, 22, 3]);
    // As a frame begins and in every step; four rounds per step, for all cloths together.
    assert_eq!(names(&[safe]), [12, 11, 44, 44, 2 + 44, 11, 0]);
    assert_eq!(names(&[safe, particles]), [12, 11, 44, 44, 4 + 3 + 44, 22, 3]);
    assert_eq!(names(&[safe; 2]), [24, 22, 44, 44, 4 + 3 + 44, 22, 3]);
}

#[test]
fn wrong_settings_are_refused() {
    for (distance, friction) in [(Some(0.0), 0.3), (Some(f32::NAN), 0.3), (Some(2.0), 0.3), (None, -1.0)] {
        let mut scene = folded(9, 0.03);
        scene.cloths[0].contact = Some(ClothContact { distance, friction, ..ClothContact::default() });
        let error = Stepper::on_cpu(scene, options()).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("contact"), "{error}");
    }
}

/// Two sheets above a table, one dropped on the other.
fn stacked(heights: [f32; 2], n: u32) -> Scene {
    let sheet = |height| {
        let at = [-0.25, height, -0.25];
        let flat = Flat { origin: at, right: [0.5, 0.0, 0.0], down: [0.0, 0.0, 0.5], ..Flat::square("sheet", n) };
        let mut cloth = flat.cloth().unwrap();
        cloth.damping = 4.0;
        cloth
    };
    let table = Collider { friction: 0.5, ..Collider::new(Shape::HalfSpace, [0.0; 3]) };
    let mut stack = scene(sheet(heights[0]));
    stack.cloths.push(sheet(heights[1]));
    with_contact(Scene { colliders: vec![table], ..stack })
}

#[test]
fn sleeping_cloth_wakes_where_fast_cloth_touches_it() {
    let options = Options { sleep: Some(Sleep { speed: 0.1, after: 0.1 }), ..options() };
    for mut rig in Rig::both(&stacked([0.01, 0.6], 17), &options) {
        (0..12).for_each(|_| rig.frame_to_its_end(support::FRAME));
        assert!(rig.stepper.is_asleep(0), "it lies on the table, {}", rig.name());
        let woke = (0..60).find(|_| {
            rig.frame_to_its_end(support::FRAME);
            !rig.stepper.is_asleep(0)
        });
        let woke = woke.expect("the other sheet lands on it");
        assert!(woke > 4, "only contact wakes it, not the cloth above it: {woke}, {}", rig.name());
    }
}

#[test]
fn both_backends_agree_on_cloths_that_touch() {
    // A third sheet with a distance and friction of its own, and one that touches nothing.
    let mut several = stacked([0.03, 0.05], 13);
    let mut third = several.cloths[1].clone();
    let lifted = third.positions().iter().map(|p| [p[0] + 0.11, p[1] + 0.05, p[2] - 0.07]).collect();
    third.place(lifted).unwrap();
    third.contact = Some(ClothContact { distance: Some(0.03), friction: 0.8, ..ClothContact::default() });
    let mut away = third.clone();
    away.place(third.positions().iter().map(|p| [p[0] + 3.0, p[1], p[2]]).collect()).unwrap();
    several.cloths.extend([third, away]);
    let settings = Options { substeps: Some(7), polish: Some(0), ..options() };
    let cloths = 0..several.cloths.len();
    let run = |rig: &mut Rig, frames| {
        rig.frames(frames);
        cloths.clone().map(|c| (rig.positions(c), rig.previous(c))).collect::<Vec<_>>()
    };
    let mut rigs = Rig::both(&several, &settings);
    let mut again = Rig::both(&several, &settings);
    let [cpu, gpu] = &mut rigs[..] else { return };
    for frame in 0..12 {
        let (cpu, gpu) = (run(cpu, 1), run(gpu, 1));
        for (c, (a, b)) in cpu.iter().zip(&gpu).enumerate() {
            assert!(largest(&a.0, &b.0) < 2e-5, "cloth {c}, frame {frame}: {} m", largest(&a.0, &b.0));
        }
    }
    let lowest = rigs[1].positions(1).iter().map(|p| p[1]).fold(f32::INFINITY, f32::min);
    assert!(lowest > 0.01, "the second sheet lies on the first one: {lowest} m");
    assert_eq!(
        run(&mut again[1], 12),
        cloths.clone().map(|c| (rigs[1].positions(c), rigs[1].previous(c))).collect::<Vec<_>>()
    );
    // A cloth that leaves takes nothing along, and the others go on as they would without it from there.
    for rig in &mut rigs {
        rig.stepper.remove_cloth(3).unwrap();
        rig.frames(6);
    }
    for c in 0..3 {
        let off = largest(&rigs[0].positions(c), &rigs[1].positions(c));
        assert!(off < 1e-3, "cloth {c}: {off} m");
    }
}

#[test]
fn sheets_that_are_dropped_on_one_another_do_not_cross() {
    let pile = stacked([0.03, 0.08], 17);
    for mut rig in Rig::both(&pile, &options()) {
        for tenth in 0..6 {
            rig.frames(10);
            assert_eq!(crossings_of(&pile, &rig), 0, "{} after {tenth} tenths", rig.name());
        }
        let heights: Vec<f32> = (0..2).map(|c| rig.positions(c).iter().map(|p| p[1]).sum::<f32>() / 289.0).collect();
        assert!(heights[1] - heights[0] > 0.02, "{heights:?}, {}", rig.name());
        assert!(heights[1] - heights[0] < 0.06, "{heights:?}, {}", rig.name());
    }
}

#[test]
fn a_state_saved_in_contact_continues_with_the_same_bits() {
    for scene in [with_contact(folded(21, 0.03)), stacked([0.05, 0.1], 17)] {
        for mut rig in Rig::both(&scene, &options()) {
            let bits =
                |rig: &Rig| (0..scene.cloths.len()).map(|c| (rig.positions(c), rig.previous(c))).collect::<Vec<_>>();
            rig.frames(25);
            let saved = rig.stepper.snapshot().unwrap();
            rig.frames(31);
            let there = bits(&rig);
            rig.stepper.restore(&Snapshot::from_bytes(&saved.to_bytes()).unwrap()).unwrap();
            rig.frames(31);
            assert!(bits(&rig) == there, "{}", rig.name());
            let mut other = rig.another(&scene);
            other.stepper.restore(&saved).unwrap();
            other.frames(31);
            assert!(bits(&other) == there, "{}, in another stepper", rig.name());
        }
    }
}
