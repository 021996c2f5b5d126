//! Sizes of workgroups and of tiles that a host measures.

use crate::support::run::Run;
use crate::support::{curtain, device_with, scene};
use gimage_runtime::*;

fn options(tuning: Option<Tuning>) -> Options {
    Options { backend: Backend::Gpu, substeps: Some(5), tuning, ..Options::default() }
}

/// A cloth that runs whole frames and one that runs by tiles.
fn two() -> Scene {
    let mut two = scene(curtain(24));
    two.cloths.push(curtain(90));
    two.colliders.push(Collider::new(Shape::Sphere { radius: 0.2 }, [0.5, -0.5, 0.1]));
    two
}

fn of(size: u32) -> Option<Tuning> {
    let [whole_threads, tile_threads, tile_particles] = [size, size, size.saturating_mul(4)].map(Some);
    Some(Tuning { whole_threads, tile_threads, tile_particles, ..Tuning::default() })
}

#[test]
fn sizes_change_what_runs_and_leave_results_as_they_are() {
    let Some(device) = device_with(device_limits) else { return };
    let limits = device.0.limits();
    let usual = Run::new(&two(), &options(None), &device);
    let shapes: Vec<Tile> = usual.tiles().into_iter().map(|t| t.0).collect();
    let usual = usual.frames(4);
    for size in [0, 64, 100, 256, u32::MAX / 8] {
        let tuned = Run::new(&two(), &options(of(size)), &device);
        let tiles: Vec<Tile> = tuned.tiles().into_iter().map(|t| t.0).collect();
        for tile in &tiles {
            let [x, y] = tile.shape.room;
            assert!(x * y <= (4 * size).max(256) && 16 * x * y <= limits.max_compute_workgroup_storage_size, "{size}");
            assert!((64..=limits.max_compute_invocations_per_workgroup).contains(&tile.threads), "{size}");
        }
        assert!(!tiles.is_empty() && (size > 100 || tiles != shapes), "{size}");
        let tuned = tuned.frames(4);
        assert!((0..2).all(|cloth| tuned.bits(cloth) == usual.bits(cloth)), "{size}");
    }
    let mut stepper = usual.stepper;
    let other = Options { tuning: of(64), ..stepper.options().clone() };
    assert!(matches!(stepper.set_options(other), Err(Error::FixedOption { option: "tuning" })));
}

#[test]
fn few_large_cloths_run_by_tiles_and_many_run_whole_frames_with_the_same_bits() {
    let Some(device) = device_with(device_limits) else { return };
    let tuning = |most| Some(Tuning { whole_particles: Some(most), ..Tuning::default() });
    let run = |cloth: &Cloth, cloths: usize, most| {
        let mut all = scene(cloth.clone());
        all.cloths.resize(cloths, cloth.clone());
        all.colliders.push(Collider::new(Shape::Sphere { radius: 0.2 }, [0.5, -0.5, 0.1]));
        Run::new(&all, &options(tuning(most)), &device)
    };
    let cloth = curtain(24);
    for (cloths, most, tiled) in [(1, 575, true), (1, 576, false), (4, 575, true), (5, 575, false)] {
        let run = run(&cloth, cloths, most);
        assert_eq!(!run.tiles().is_empty(), tiled, "{cloths} cloths, {most}\n{}", run.stepper.plan());
    }
    // Cloths that come later change nothing of it.
    let mut later = run(&cloth, 1, 0);
    (0..5).for_each(|_| _ = later.stepper.add_cloth(cloth.clone()).unwrap());
    assert!(!later.tiles().is_empty(), "{}", later.stepper.plan());
    let [tiled, whole] = [0, 576].map(|most| run(&cloth, 2, most).frames(4));
    assert!((0..2).all(|cloth| tiled.bits(cloth) == whole.bits(cloth)));
    // Passes that no tile has get dispatches of their own.
    let mut soft = curtain(24);
    soft.set_material(&Material::named("cotton").unwrap()).unwrap();
    let [apart, whole] = [0, 576].map(|most| run(&soft, 1, most).frames(4));
    let dispatches = [&apart, &whole].map(|run| run.stepper.plan().dispatches());
    assert!(dispatches[0] > 20 && dispatches[1] == 1, "{dispatches:?}");
    assert!(apart.bits(0) == whole.bits(0));
}

#[test]
fn a_device_is_measured_in_some_seconds() {
    let Some(device) = device_with(device_limits) else { return };
    let start = std::time::Instant::now();
    let tuning = Stepper::tune(&device.0, &device.1).unwrap();
    eprintln!("{tuning:?} in {:.1} s", start.elapsed().as_secs_f64());
    let limits = device.0.limits();
    for threads in [tuning.whole_threads, tuning.tile_threads].into_iter().flatten() {
        assert!((64..=limits.max_compute_invocations_per_workgroup).contains(&threads));
    }
    assert!(tuning.tile_particles.is_none_or(|n| 16 * n <= limits.max_compute_workgroup_storage_size));
    let run = Run::new(&two(), &options(Some(tuning)), &device);
    assert!(!run.tiles().is_empty());
}
