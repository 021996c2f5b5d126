//! A scene pays only for what it uses.

use crate::support::{self, scene};
use gimage_runtime::*;

fn plan(scene: Scene) -> Plan {
    let options =
        Options { backend: Backend::Cpu, substeps: Some(1), threads: 1, solver: Solver::Classic, ..Options::default() };
    Stepper::on_cpu(scene, options).unwrap().plan()
}

fn flat(rest: Rest) -> Cloth {
    let grid = Grid { name: "g".into(), first: 0, width: 8, height: 8 };
    let positions = Flat::square("flat", 8).cloth().unwrap().positions().to_vec();
    let particles = vec![Particle::Free { next: None }; 64];
    Cloth::new(Parts { name: "c".into(), grids: vec![grid], positions, particles, rest, mass: Mass::Constant(1.0) })
        .unwrap()
}

#[test]
fn dispatches_and_bytes_of_scenes() {
    // step 80, grids 32, three lists of 64 * 16 = 1024 bytes.
    const BASE: u64 = 80 + 32 + 3 * 1024;
    let cloth = || flat(Rest::Constant(vec![[1.0; 4]]));
    let sphere = Collider::new(Shape::Sphere { radius: 1.0 }, [0.0; 3]);
    let rough = Collider { friction: 0.5, ..sphere };
    let pinned = || {
        let mut cloth = cloth();
        cloth.set_pinned(3, true).unwrap();
        cloth
    };
    let even = || Wind { gust: 0.0, ..support::wind(true) };
    let table = [
        ("springs", scene(cloth()), 10, BASE),
        ("pins cost nothing", scene(pinned()), 10, BASE),
        ("no springs", scene(flat(Rest::None)), 2, BASE),
        ("no shear", scene(flat(Rest::Constant(vec![[1.0, 1.0, 0.0, 0.0]]))), 6, BASE),
        ("an image of lengths", scene(flat(Rest::Image(vec![[1.0; 4]; 64]))), 10, BASE + 1024),
        ("a collider", Scene { colliders: vec![sphere], ..scene(cloth()) }, 11, BASE + 80),
        ("two kinds", Scene { colliders: vec![rough; 2], ..scene(cloth()) }, 11, BASE + 160),
        ("wind", Scene { wind: Some(support::wind(false)), ..scene(cloth()) }, 10, BASE),
        ("even wind on triangles", Scene { wind: Some(even()), ..scene(cloth()) }, 11, BASE + 1024),
        ("gusts on triangles", Scene { wind: Some(support::wind(true)), ..scene(cloth()) }, 12, BASE + 2048),
        ("nothing", Scene::new("nothing"), 0, 0),
    ];
    for (name, scene, dispatches, bytes) in table {
        let plan = plan(scene);
        assert_eq!((plan.dispatches(), plan.bytes()), (dispatches, bytes), "{name}:\n{plan}");
    }
}

#[test]
fn each_kind_of_collider_is_one_dispatch_and_only_its_own_code() {
    let springs = plan(scene(flat(Rest::Constant(vec![[1.0; 4]]))));
    for (n, collider) in support::all_colliders().into_iter().enumerate() {
        for friction in [0.0, 0.4] {
            let colliders = vec![Collider { friction, ..collider }];
            let plan = plan(Scene { colliders, ..scene(flat(Rest::Constant(vec![[1.0; 4]]))) });
            // Step and previous positions, which friction reads, are bound in any case.
            let sums = (plan.dispatches(), plan.bytes());
            assert_eq!(sums, (springs.dispatches() + 1, springs.bytes() + 80), "{collider:?}");
            let kinds = plan
                .passes
                .iter()
                .find_map(|p| if let Some(Pass::Colliders(k)) = p.form.pass() { Some(k) } else { None });
            let mut only = Kinds { friction: friction > 0.0, ..Kinds::default() };
            only.shapes[n] = true;
            assert_eq!(kinds, Some(only));
        }
    }
    let colliders = support::all_colliders();
    let bytes = 80 * colliders.len() as u64;
    let all = plan(Scene { colliders, ..scene(flat(Rest::Constant(vec![[1.0; 4]]))) });
    assert_eq!((all.dispatches(), all.bytes()), (springs.dispatches() + 1, springs.bytes() + bytes));
}

#[test]
fn what_is_done_to_a_scene_changes_its_plan() {
    // A tube of 9 x 5 with a seam of five rings of two: 6 offsets, 10 members; its rest lengths are an image.
    const TUBE: u64 = 80 + 32 + 45 * 16 * 4 + 6 * 4 + 10 * 4;
    const FLAT: u64 = 80 + 32 + 64 * 16 * 3;
    type Change = fn(&mut Stepper);
    let nothing: Change = |_| {};
    let cut: Change = |s| s.cut([0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]).unwrap();
    let sleep: Change = |s| s.set_asleep(0, true).unwrap();
    let air: Change = |s| s.set_wind(Some(support::wind(true))).unwrap();
    let calm: Change = |s| s.set_wind(None).unwrap();
    let bare: Change = |s| s.set_colliders(Vec::new()).unwrap();
    let tube = || support::tube(9, 5, 1);
    let square = || flat(Rest::Constant(vec![[1.0; 4]]));
    let among = || Scene { colliders: support::all_colliders(), ..scene(square()) };
    let windy = || Scene { wind: Some(support::wind(true)), ..scene(square()) };
    let two = || Scene { cloths: vec![square(), tube()], ..Scene::new("two") };
    let table: [(&str, Scene, &[Change], u32, u64); 14] = [
        ("seams", scene(tube()), &[nothing], 12, TUBE),
        ("seams, cut: an image already", scene(tube()), &[cut], 12, TUBE + 45 * 4),
        ("cut: an image from here on", scene(square()), &[cut], 10, FLAT + 1024 + 256),
        ("cut twice costs no more", scene(square()), &[cut, cut], 10, FLAT + 1024 + 256),
        ("cut in wind", windy(), &[cut], 12, FLAT + 1024 + 2048 + 256),
        ("no springs, cut: no image", scene(flat(Rest::None)), &[cut], 2, FLAT + 256),
        ("asleep", scene(tube()), &[sleep], 0, 0),
        ("cut in its sleep", scene(square()), &[sleep, cut], 10, FLAT + 1024 + 256),
        ("asleep after a cut", scene(square()), &[cut, sleep], 0, 0),
        ("wind rises", scene(square()), &[air], 12, FLAT + 2048),
        ("wind ends", windy(), &[calm], 10, FLAT),
        ("colliders leave", among(), &[bare], 10, FLAT),
        ("two cloths", two(), &[nothing], 22, FLAT + TUBE),
        ("one of two asleep", two(), &[sleep], 12, TUBE),
    ];
    for (name, scene, changes, dispatches, bytes) in table {
        let options = Options {
            backend: Backend::Cpu,
            substeps: Some(1),
            threads: 1,
            solver: Solver::Classic,
            ..Options::default()
        };
        let mut stepper = Stepper::on_cpu(scene, options).unwrap();
        changes.iter().for_each(|change| change(&mut stepper));
        let plan = stepper.plan();
        assert_eq!((plan.dispatches(), plan.bytes()), (dispatches, bytes), "{name}:\n{plan}");
    }
}

#[test]
fn seams_cost_two_passes_and_their_lists() {
    let cloth = support::tube(9, 5, 2);
    let (starts, members) = cloth.rings();
    let bytes = ((starts.len() + members.len()) * 4) as u64;
    let plan = plan(scene(cloth));
    let seams = plan.passes.iter().filter(|p| p.shader.contains("seam")).count();
    let bound = |name: &str| plan.passes.iter().flat_map(|p| &p.bindings).find(|b| b.0 == name).map_or(0, |b| b.1);
    assert_eq!((seams, bound("starts") + bound("members")), (2, bytes));
}

#[test]
fn smooth_colliders_do_not_bind_previous_positions() {
    let names = |friction| {
        let ball = Collider { friction, ..Collider::new(Shape::Sphere { radius: 1.0 }, [0.0; 3]) };
        let cloth = flat(Rest::None);
        let plan = plan(Scene { colliders: vec![ball], ..scene(cloth) });
        let pass = plan.passes.into_iter().find(|p| p.shader == "colliders").unwrap();
        pass.bindings.into_iter().map(|b| b.0).collect::<Vec<_>>()
    };
    assert_eq!((names(0.0), names(0.1)), (vec!["solids", "now"], vec!["solids", "step", "before", "now"]));
}

#[test]
fn a_sleeping_cloth_costs_nothing_until_something_changes() {
    let mut two = scene(flat(Rest::None));
    two.cloths.push(flat(Rest::None));
    let options =
        Options { backend: Backend::Cpu, substeps: Some(3), threads: 1, solver: Solver::Classic, ..Options::default() };
    let mut stepper = Stepper::on_cpu(two, options).unwrap();
    assert_eq!(stepper.plan().dispatches(), 8);
    stepper.set_asleep(0, true).unwrap();
    assert_eq!(stepper.plan().dispatches(), 4);
    let at = stepper.positions(0).unwrap().to_vec();
    stepper.advance(0.1).unwrap();
    assert_eq!(stepper.positions(0).unwrap(), at);
    stepper.set_pinned(0, 3, true).unwrap();
    assert_eq!(stepper.plan().dispatches(), 8);
    stepper.set_asleep(1, true).unwrap();
    stepper.set_colliders(vec![Collider::new(Shape::HalfSpace, [0.0; 3])]).unwrap();
    assert_eq!(stepper.plan().dispatches(), 14);
}

#[test]
fn wrong_settings_are_errors() {
    let cloth = || flat(Rest::None);
    let new = |scene, options| Stepper::on_cpu(scene, options).map(|_| ()).unwrap_err().to_string();
    assert!(new(scene(cloth()), Options { substeps: Some(0), ..Options::default() }).contains("substeps"));
    assert!(new(scene(cloth()), Options { step: f64::NAN, ..Options::default() }).contains("step"));
    let gpu = Options { backend: Backend::Gpu, ..Options::default() };
    assert!(new(scene(cloth()), gpu).contains("mesa-vulkan-drivers"));
    let bad = Collider::new(Shape::Sphere { radius: -1.0 }, [0.0; 3]);
    assert!(new(Scene { colliders: vec![bad], ..scene(cloth()) }, Options::default()).contains("collider"));
    let mut windy = support::wind(true);
    windy.gust = 9.0;
    assert!(new(Scene { wind: Some(windy), ..scene(cloth()) }, Options::default()).contains("gusts"));
    let mut stepper = Stepper::on_cpu(scene(cloth()), Options::default()).unwrap();
    assert!(stepper.set_pinned(0, 64, true).is_err() && stepper.set_pinned(1, 0, true).is_err());
    assert!(stepper.set_position(0, 0, [f32::NAN; 3]).is_err() && stepper.set_gravity([f32::NAN; 3]).is_err());
    assert!(stepper.set_asleep(7, true).is_err());
    #[cfg(feature = "gpu")]
    assert!(stepper.buffers(0).is_none() && stepper.compiled().is_none());
}
