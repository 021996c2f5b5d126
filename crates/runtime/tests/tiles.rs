//! Tiles of large cloths against the passes that they are made of.

use crate::support::alike::rounding;
use crate::support::rig::FRAME;
use crate::support::run::{Device, Run};
use crate::support::{self, all_colliders, device_with, scene, two_charts, wind};
use gimage_runtime::*;

/// A device with no more than every one has, so that no cloth here fits a workgroup.
fn device() -> Option<Device> {
    support::device()
}

fn options(fused: bool) -> Options {
    Options { solver: Solver::Xpbd, backend: Backend::Gpu, substeps: Some(5), fused, ..Options::default() }
}

/// Runs a scene both ways: the same bits, at last, in fewer dispatches.
fn agree(name: &str, scene: &Scene, with: impl Fn(Options) -> Options, device: &Device) -> Vec<(Tile, u32)> {
    let [tiled, apart] = [true, false].map(|fused| Run::new(scene, &with(options(fused)), device));
    let (tiles, plan) = (tiled.tiles(), tiled.stepper.plan());
    assert!(!tiles.is_empty(), "{name}: {plan}");
    assert_eq!(apart.tiles(), [], "{name}");
    assert!(plan.dispatches() < apart.stepper.plan().dispatches(), "{name}");
    let [tiled, apart] = [tiled, apart].map(|run| run.frames(7));
    for cloth in 0..scene.cloths.len() {
        let (a, b) = (tiled.bits(cloth), apart.bits(cloth));
        assert_eq!(a.difference(&b), None, "{name}: cloth {cloth}\n{plan}");
        assert!(a[0].iter().flatten().all(|x| f32::from_bits(*x).is_finite()), "{name}");
        assert!(a[0] != a[1], "{name} does not move");
    }
    tiles
}

/// A rectangle of `width` x `height` particles, 1 m wide, hung by two corners, thrown askew.
fn sheet(width: u32, height: u32) -> Cloth {
    let down = (height - 1) as f32 / (width - 1) as f32;
    let flat = Flat { width, height, down: [0.0, 0.0, down.min(4.0)], ..Flat::square("sheet", width) };
    let mut cloth = flat.cloth().unwrap();
    cloth.set_pinned(0, true).unwrap();
    cloth.set_pinned(width as usize - 1, true).unwrap();
    (cloth.velocity, cloth.damping) = ([0.4, -1.5, 0.3], 0.3);
    cloth
}

const SIZES: [(u32, u32); 5] = [(70, 70), (129, 65), (200, 33), (2, 1100), (1030, 3)];

/// Whether any tile has such a pass.
fn has(tiles: &[(Tile, u32)], of: impl Fn(&Pass) -> bool) -> bool {
    tiles.iter().flat_map(|t| &t.0.passes).any(of)
}

#[test]
fn tiles_of_any_cloth_give_the_bits_of_separate_passes() {
    let Some(device) = device() else { return };
    for (width, height) in SIZES {
        let scene = scene(sheet(width, height));
        let name = format!("{width} x {height}");
        // The whole step is one dispatch, but for what ends the frame.
        let tiles = agree(&name, &scene, |o| o, &device);
        assert!(matches!(tiles[..], [(_, 5)]), "{tiles:?}");
        let tethers = tiles[0].0.passes.iter().filter(|p| matches!(p, Pass::Tethers { .. }));
        assert_eq!(tethers.count(), 2);
        agree(&name, &scene, |o| Options { tethers: 0, substeps: Some(4), ..o }, &device);
        agree(&name, &scene, |o| Options { iterations: 3, ..o }, &device);
        agree(&name, &scene, |o| Options { polish: Some(1), ..o }, &device);
        agree(&name, &scene, |o| Options { polish: Some(5), iterations: 2, ..o }, &device);
    }
}

/// A cloth of flat grids of these sizes, one behind the other, each hung by two corners and thrown askew.
fn pieces(sizes: &[(u32, u32)]) -> Cloth {
    let (mut grids, mut positions, mut particles) = (Vec::new(), Vec::new(), Vec::new());
    let side = 0.0145f32;
    for (g, &(width, height)) in sizes.iter().enumerate() {
        grids.push(Grid { name: format!("piece {g}"), first: positions.len() as u32, width, height });
        for (j, i) in (0..height).flat_map(|j| (0..width).map(move |i| (j, i))) {
            positions.push([i as f32 * side, -(j as f32) * side, g as f32 * 0.1]);
            let corner = j == 0 && (i == 0 || i == width - 1);
            particles.push(if corner { Particle::Pinned { next: None } } else { Particle::Free { next: None } });
        }
    }
    let diagonal = side.hypot(side);
    let rest = Rest::Constant(vec![[side, side, diagonal, diagonal]; grids.len()]);
    let name = "pieces".into();
    let mut cloth = Cloth::new(Parts { name, grids, positions, particles, rest, mass: Mass::Constant(1e-4) }).unwrap();
    (cloth.velocity, cloth.damping) = ([0.4, -1.5, 0.3], 0.3);
    cloth
}

#[test]
fn tiles_past_the_end_of_a_small_grid_do_nothing() {
    let Some(device) = device() else { return };
    // Every grid has as many tiles as the largest, most of which begin where a smaller one has ended.
    let scene = scene(pieces(&[(70, 70), (6, 40), (40, 6), (3, 3), (30, 30)]));
    for (polish, tethers) in [(0, 0), (0, 2), (1, 0), (1, 2)] {
        let name = format!("polish {polish}, {tethers} tethers");
        agree(&name, &scene, |o| Options { polish: Some(polish), tethers, ..o }, &device);
    }
}

#[test]
fn a_step_is_as_few_dispatches_as_can_be() {
    let Some(device) = device() else { return };
    let of = |scene: &Scene, with: Options| {
        let plan = Run::new(scene, &Options { normals: false, ..with }, &device).stepper.plan();
        // Two passes end a frame.
        (plan.dispatches() - 2, plan.passes.iter().map(|p| p.shader).collect::<Vec<_>>())
    };
    let plain = scene(sheet(70, 70));
    let six = Scene { colliders: all_colliders(), ..plain.clone() };
    let base = || Options { substeps: Some(1), ..options(true) };
    let tile = ["tile", "guard", "restore"];
    assert_eq!(of(&plain, base()), (1, tile.to_vec()));
    assert_eq!(of(&plain, Options { substeps: Some(16), ..base() }), (16, tile.to_vec()));
    assert_eq!(of(&six, base()), (1, tile.to_vec()));
    assert_eq!(of(&six, Options { polish: Some(1), ..base() }), (1, tile.to_vec()));
    // The first one integrates.
    assert_eq!(of(&six, Options { iterations: 4, ..base() }).0, 4);
    // With 12 more rounds a tile would load far more around it than it owns.
    assert_eq!(of(&six, Options { polish: Some(12), ..base() }).0, 4);
    let windy = Scene { wind: Some(wind(true)), ..plain };
    assert_eq!(of(&windy, base()).1[..3], ["gust", "wind", "tile"]);
    let charts = Scene { colliders: all_colliders(), ..scene(two_charts(48)) };
    // The seams, the contact and the guard of the last step are one dispatch; those of the others are part of the next step's tile.
    assert_eq!(of(&charts, Options { substeps: Some(16), ..base() }), (16, vec!["tile", "seams", "restore"]));
}

#[test]
fn a_step_begins_in_the_tile_of_the_step_before() {
    let Some(device) = device() else { return };
    let plain = scene(sheet(60, 45));
    let mut tube = scene(support::tube(65, 40, 4));
    tube.cloths[0].set_pinned(0, true).unwrap();
    let met = Scene { colliders: all_colliders(), ..plain.clone() };
    let [pushed, blown] = [false, true].map(|triangles| Scene { wind: Some(wind(triangles)), ..plain.clone() });
    let spans = |name: &str, scene: &Scene, with: &dyn Fn(Options) -> Options| {
        agree(name, scene, with, &device).iter().map(|t| t.0.span).collect::<Vec<_>>()
    };
    // Frames of one step begin and end in a tile, those of two have none that does neither.
    for substeps in [1, 2, 3, 8] {
        let some = |o| Options { substeps: Some(substeps), ..o };
        assert_eq!(spans("plain", &plain, &some), [TileSpan::Ahead]);
        assert_eq!(spans("colliders", &met, &some), [TileSpan::Ahead]);
        assert_eq!(spans("seams", &tube, &some), [TileSpan::Step]);
    }
    assert_eq!(spans("pushed", &pushed, &|o| o), [TileSpan::Ahead]);
    // Forces of air read previous positions, and an exact step keeps more than these.
    assert_eq!(spans("blown", &blown, &|o| o), [TileSpan::Part]);
    assert_eq!(spans("exact", &plain, &|o| Options { substeps: Some(24), ..o }), [TileSpan::Step]);
    assert!(spans("relaxed twice", &plain, &|o| Options { iterations: 2, ..o }).iter().all(|s| *s == TileSpan::Part));
    // Cloths of different sizes share dispatches, and lie beside one another.
    let several = Scene { cloths: vec![sheet(60, 45), sheet(50, 50), sheet(64, 33)], ..met };
    assert!(spans("several", &several, &|o| o).iter().all(|s| *s == TileSpan::Ahead));
}

#[test]
fn what_springs_are_like_is_the_same_by_tiles() {
    let Some(device) = device() else { return };
    let cloth = || sheet(70, 41);
    let with = |rest, compliance| {
        let like = cloth();
        let mut made = Cloth::new(Parts {
            name: "made".into(),
            grids: like.grids().to_vec(),
            positions: like.positions().to_vec(),
            particles: like.particles().to_vec(),
            rest,
            mass: Mass::Constant(like.mass(1)),
        })
        .unwrap();
        (made.velocity, made.compliance) = (like.velocity, compliance);
        scene(made)
    };
    let lengths = |k: usize| [0.014, 0.0145, if k % 7 < 6 { 0.02 } else { 0.0 }, 0.021];
    let image = || Rest::Image((0..70 * 41).map(lengths).collect());
    let softs = Compliance::Image((0..70 * 41).map(|k| [0, 1, 2, 3].map(|d| 1e-4 * ((k + d) % 3) as f32)).collect());
    let constant = |lengths: [f32; 4]| Rest::Constant(vec![lengths]);
    let all = [
        ("an image of lengths", with(image(), Compliance::None)),
        ("soft", with(constant(lengths(0)), Compliance::Constant(1e-4))),
        ("an image of compliance", with(constant(lengths(0)), softs.clone())),
        ("both images", with(image(), softs)),
        ("no shear", with(constant([0.014, 0.014, 0.0, 0.0]), Compliance::None)),
        ("one direction", with(constant([0.0, 0.0, 0.02, 0.0]), Compliance::None)),
    ];
    for (name, scene) in &all {
        agree(name, scene, |o| o, &device);
        if *name != "one direction" {
            agree(name, scene, |o| Options { polish: Some(1), ..o }, &device);
            agree(name, scene, |o| Options { iterations: 3, ..o }, &device);
        }
    }
    // Multipliers are summed in one tile, and from one to the next; with more to bind where a device can.
    let tiles = agree("soft", &all[1].1, |o| Options { polish: Some(2), iterations: 2, ..o }, &device);
    let forgets = |t: &(Tile, u32)| t.0.passes.contains(&Pass::Forget);
    assert!(tiles.iter().any(forgets) && tiles.iter().any(|t| !forgets(t)), "{tiles:?}");
    if let Some(roomy) = device_with(device_limits) {
        agree(
            "both images",
            &all[3].1,
            |o| Options { polish: Some(1), iterations: 2, substeps: Some(23), ..o },
            &roomy,
        );
    }
    let tiles = agree("no shear", &all[4].1, |o| o, &device);
    assert_eq!(tiles[0].0.shape.around, [1, 1], "what is not there reaches nowhere");
}

#[test]
fn colliders_end_a_tile() {
    let Some(device) = device() else { return };
    let mut falls = scene(Flat { origin: [0.0, 0.05, 0.0], ..Flat::square("flat", 50) }.cloth().unwrap());
    (falls.cloths[0].velocity, falls.cloths[0].damping) = ([0.0, -2.0, 0.2], 0.5);
    let one = vec![Collider { velocity: [0.1, 0.4, 0.0], friction: 0.4, ..all_colliders()[1] }];
    for (name, colliders) in [("one", one), ("six", all_colliders())] {
        let scene = Scene { colliders, ..falls.clone() };
        let tiles = agree(name, &scene, |o| o, &device);
        assert!(has(&tiles, |p| matches!(p, Pass::Contact(_))), "{tiles:?}");
        agree(name, &scene, |o| Options { iterations: 2, thickness: 0.01, ..o }, &device);
        agree(name, &scene, |o| Options { polish: Some(1), ..o }, &device);
    }
}

#[test]
fn seams_begin_tiles() {
    let Some(device) = device() else { return };
    let mut charts = scene(two_charts(48));
    charts.cloths[0].velocity = [0.3, 0.1, 0.8];
    charts.colliders = all_colliders();
    for (iterations, polish) in [(1, 0), (2, 0), (1, 2)] {
        let tiles = agree("charts", &charts, |o| Options { iterations, polish: Some(polish), ..o }, &device);
        assert!(tiles.iter().all(|t| t.0.passes[0] == Pass::Seams), "{tiles:?}");
        assert!(has(&tiles, |p| matches!(p, Pass::Contact(_))), "{tiles:?}");
    }
    let mut tube = scene(support::tube(65, 40, 4));
    tube.cloths[0].set_pinned(0, true).unwrap();
    tube.cloths[0].velocity = [0.2, -0.5, 0.1];
    agree("ring of 4", &tube, |o| o, &device);
    agree("ring of 4", &tube, |o| Options { polish: Some(1), ..o }, &device);
}

#[test]
fn what_tiles_do_not_make_runs_between_them() {
    let Some(device) = device() else { return };
    let mut flies = scene(sheet(60, 45));
    for triangles in [false, true] {
        flies.wind = Some(wind(triangles));
        agree("wind", &flies, |o| o, &device);
    }
    agree("pyramid", &flies, |o| Options { pyramid: 2, ..o }, &device);
    // Steps so short that rounding is kept.
    for (substeps, pyramid, triangles) in [(24, 0, true), (23, 0, false), (25, 2, false)] {
        flies.wind = Some(wind(triangles));
        let tiles = agree("short steps", &flies, |o| Options { substeps: Some(substeps), pyramid, ..o }, &device);
        assert!(has(&tiles, |p| matches!(p, Pass::IntegrateExact(_))), "{tiles:?}");
    }
    agree(
        "measured",
        &flies,
        |o| Options { sleep: Some(Sleep::default()), quality: Quality::Error(0.01), ..o },
        &device,
    );
    let mut soft = flies.clone();
    soft.cloths[0].compliance = Compliance::Constant(1e-4);
    agree("soft", &soft, |o| o, &device);
    flies.cloths = vec![support::made_of(sheet(60, 45)), sheet(50, 50), sheet(9, 9)];
    flies.colliders = all_colliders();
    let tiled = Run::new(&flies, &options(true), &device);
    let of = |cloth| tiled.stepper.plan().passes.iter().filter(|p| p.cloth == cloth).cloned().collect::<Vec<_>>();
    let of_contact = |p: &PlannedPass| {
        let Form::Tile(tile) = &p.form else { return false };
        let springs = tile.passes.iter().any(|p| matches!(p, Pass::Stretch { .. }));
        !springs && tile.passes.iter().any(|p| matches!(p, Pass::Contact(_)))
    };
    assert!(of(0).iter().any(of_contact));
    agree("several", &flies, |o| o, &device);
}

#[test]
fn what_users_do_between_frames_is_the_same_by_tiles() {
    let Some(device) = device() else { return };
    let scene = scene(sheet(60, 45));
    // Odd numbers of steps leave positions elsewhere until the frame ends.
    for substeps in [3, 4, 23] {
        let run = |fused| {
            let mut run = Run::new(&scene, &Options { substeps: Some(substeps), ..options(fused) }, &device).frames(3);
            // Where it is, with a speed.
            run.stepper.set_pinned(0, 1234, true).unwrap();
            let mut run = run.frames(2);
            run.stepper.set_position(0, 59, [0.8, 0.1, 0.2]).unwrap();
            run.stepper.set_pinned(0, 1234, false).unwrap();
            let turn = [[0.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.1, 0.0, 0.0, 1.0]];
            run.stepper.transform(0, &[3, 4, 5], turn).unwrap();
            let mut run = run.frames(2);
            run.stepper.set_colliders(all_colliders()).unwrap();
            let mut run = run.frames(1);
            run.stepper.cut([0.5, 0.5, 3.0], [-4.0, -0.1, -2.0], [5.0, -0.1, -2.0]).unwrap();
            let run = run.frames(3);
            let tiles = run.tiles().len();
            (run.bits(0), tiles)
        };
        let ((tiled, tiles), (apart, none)) = (run(true), run(false));
        assert!(tiles > 0 && none == 0);
        assert!(tiled == apart, "{substeps}");
    }
}

#[test]
fn a_fault_is_taken_back_by_tiles_too() {
    let Some(device) = device() else { return };
    let scene = scene(sheet(70, 40));
    let run = |fused| {
        let mut run = Run::new(&scene, &Options { tethers: 0, ..options(fused) }, &device).frames(4);
        let good = run.bits(0)[0].clone();
        let mut matrix = [[0.0; 4]; 4];
        (matrix[0][0], matrix[1][1], matrix[2][2], matrix[3][3]) = (3e38, 3e38, 3e38, 1.0);
        run.stepper.transform(0, &[1500], matrix).unwrap();
        let run = run.frames(1);
        assert!(run.bits(0)[0] == good);
        let span = run.stepper.buffers(0).unwrap().faults.clone().unwrap();
        let faults = read_back_u32(&device.0, &device.1, &span).unwrap();
        assert!(faults[0] > 0 && faults[1] == 1, "{faults:?}");
        run.frames(3).bits(0)
    };
    assert!(run(true) == run(false));
}

#[test]
fn the_size_of_tiles_changes_nothing() {
    // Room for 1,024 particles, for 1,014 beside what a workgroup notes, and for what the adapter has.
    let (Some(usual), Some(large)) = (device(), device_with(device_limits)) else { return };
    let mut scene = scene(sheet(130, 110));
    scene.colliders = all_colliders();
    let of = |device: &Device, options: &Options| {
        let run = Run::new(&scene, options, device).frames(5);
        let rooms: Vec<_> = run.tiles().iter().map(|t| t.0.shape.room).collect();
        (rooms, run.bits(0))
    };
    let [(small, a), (wide, b)] = [&usual, &large].map(|d| of(d, &options(true)));
    if usual.0.limits().max_compute_workgroup_storage_size < large.0.limits().max_compute_workgroup_storage_size {
        assert_ne!(small, wide);
    }
    assert!(a == b);
    assert!(a == of(&usual, &options(true)).1, "it repeats");
}

#[test]
fn tiles_agree_with_the_twin() {
    let Some(device) = device() else { return };
    let mut soft = sheet(50, 60);
    soft.compliance = Compliance::Constant(1e-4);
    let mut falls = scene(Flat { origin: [0.0, 0.05, 0.0], ..Flat::square("flat", 50) }.cloth().unwrap());
    falls.cloths[0].velocity = [0.0, -2.0, 0.2];
    falls.colliders = all_colliders();
    let all = [
        ("sheet", scene(sheet(70, 40))),
        ("soft sheet", scene(soft)),
        ("a material", scene(support::made_of(sheet(40, 60)))),
        ("charts", scene(two_charts(40))),
        ("on colliders", falls),
    ];
    for (name, scene) in all {
        let once = Options { substeps: Some(1), step: FRAME / 4.0, max_catch_up: 1, ..options(true) };
        let there = Run::new(&scene, &once, &device);
        assert!(!there.tiles().is_empty(), "{name}");
        let there = there.frames(1).bits(0)[0].clone();
        let mut here = Stepper::new(scene.clone(), Options { backend: Backend::Cpu, ..once }, None).unwrap();
        here.advance(FRAME).unwrap();
        let apart = there.iter().zip(here.positions(0).unwrap());
        let apart = apart.flat_map(|(a, b)| (0..3).map(|c| (f32::from_bits(a[c]) - b[c]).abs())).fold(0.0, f32::max);
        assert!(apart <= rounding(&device, 1e-6), "{name}: {apart:e} m");
    }
}

#[test]
fn cloths_of_the_classic_solver_have_no_tiles() {
    let Some(device) = device() else { return };
    let run = Run::new(&scene(sheet(70, 40)), &Options { solver: Solver::Classic, ..options(true) }, &device);
    assert_eq!(run.tiles(), []);
}
