//! A scene pays only for what it uses.

mod support;

use gimage_runtime::*;
use support::scene;

fn plan(scene: Scene) -> Plan {
    let options = Options { backend: Backend::Cpu, substeps: 1, threads: 1, ..Options::default() };
    Stepper::new(scene, options, None).unwrap().plan()
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
    let table = [
        ("springs", scene(cloth()), 10, BASE),
        ("pins cost nothing", scene(pinned()), 10, BASE),
        ("no springs", scene(flat(Rest::None)), 2, BASE),
        ("no shear", scene(flat(Rest::Constant(vec![[1.0, 1.0, 0.0, 0.0]]))), 6, BASE),
        ("an image of lengths", scene(flat(Rest::Image(vec![[1.0; 4]; 64]))), 10, BASE + 1024),
        ("a collider", Scene { colliders: vec![sphere], ..scene(cloth()) }, 11, BASE + 80),
        ("two kinds", Scene { colliders: vec![rough; 2], ..scene(cloth()) }, 11, BASE + 160),
        ("wind", Scene { wind: Some(support::wind(false)), ..scene(cloth()) }, 10, BASE),
        ("wind on triangles", Scene { wind: Some(support::wind(true)), ..scene(cloth()) }, 11, BASE + 1024),
        ("nothing", Scene::new("nothing"), 0, 0),
    ];
    for (name, scene, dispatches, bytes) in table {
        let plan = plan(scene);
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
    assert_eq!((names(0.0), names(0.1)), (vec!["now", "solids"], vec!["now", "solids", "step", "before"]));
}

#[test]
fn a_sleeping_cloth_costs_nothing_until_something_changes() {
    let mut two = scene(flat(Rest::None));
    two.cloths.push(flat(Rest::None));
    let options = Options { backend: Backend::Cpu, substeps: 3, threads: 1, ..Options::default() };
    let mut stepper = Stepper::new(two, options, None).unwrap();
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
    let new = |scene, options| Stepper::new(scene, options, None).map(|_| ()).unwrap_err().to_string();
    assert!(new(scene(cloth()), Options { substeps: 0, ..Options::default() }).contains("substeps"));
    assert!(new(scene(cloth()), Options { step: f64::NAN, ..Options::default() }).contains("step"));
    let gpu = Options { backend: Backend::Gpu, ..Options::default() };
    assert!(new(scene(cloth()), gpu).contains("mesa-vulkan-drivers"));
    let bad = Collider::new(Shape::Sphere { radius: -1.0 }, [0.0; 3]);
    assert!(new(Scene { colliders: vec![bad], ..scene(cloth()) }, Options::default()).contains("collider"));
    let mut windy = support::wind(true);
    windy.gust = 9.0;
    assert!(new(Scene { wind: Some(windy), ..scene(cloth()) }, Options::default()).contains("gusts"));
    let mut stepper = Stepper::new(scene(cloth()), Options::default(), None).unwrap();
    assert!(stepper.set_pinned(0, 64, true).is_err() && stepper.set_pinned(1, 0, true).is_err());
    assert!(stepper.set_position(0, 0, [f32::NAN; 3]).is_err() && stepper.set_gravity([f32::NAN; 3]).is_err());
    assert!(stepper.buffers(0).is_none() && stepper.set_asleep(7, true).is_err());
}
