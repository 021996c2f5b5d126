//! Pins and seams of a cloth.

use crate::support::tube;
use gimage_runtime::*;

#[test]
fn pins_go_round_the_ring() {
    let mut cloth = tube(9, 4, 4);
    assert_eq!(cloth.ring_count(), 4);
    cloth.set_pinned(2, true).unwrap();
    assert!((0..4).all(|k| cloth.inverse_mass(k) == 0.0) && cloth.inverse_mass(4) > 0.0);
    cloth.set_pinned(0, false).unwrap();
    assert!((0..4).all(|k| cloth.inverse_mass(k) > 0.0));
    assert!(cloth.set_pinned(999, true).is_err());
}

#[test]
fn bounds_hold_all_particles_and_no_texel_beside_them() {
    let (corner, side) = ([1.0, 2.0, 3.0], [0.0, 0.0, -0.5]);
    let square =
        Flat { origin: corner, right: [0.25, 0.0, 0.0], down: side, ..Flat::square("square", 3) }.cloth().unwrap();
    assert_eq!(square.bounds(), Some(([1.0, 2.0, 2.5], [1.25, 2.0, 3.0])));
    // Three texels without a particle.
    let mut particles = square.particles().to_vec();
    [2, 5, 8].into_iter().for_each(|k| particles[k] = Particle::None);
    let parts = Parts {
        name: "cut off".into(),
        grids: square.grids().to_vec(),
        positions: square.positions().to_vec(),
        particles,
        rest: square.rest().clone(),
        mass: Mass::Constant(1e-3),
    };
    assert_eq!(Cloth::new(parts).unwrap().bounds(), Some(([1.0, 2.0, 2.5], [1.125, 2.0, 3.0])));
}

#[test]
fn a_flat_cloth_without_area_is_refused() {
    let flat = |down| Flat { down, ..Flat::square("line", 5) }.cloth();
    for down in [[0.5, 0.0, 0.0], [-2.0, 1e-4, 0.0], [0.0; 3], [f32::NAN; 3]] {
        let error = flat(down).err().map(|e| e.to_string());
        assert!(error.is_some_and(|text| text.contains("of a flat cloth")), "{down:?}");
    }
    // Skew, and thin.
    assert!(flat([1.0, 0.1, 0.0]).is_ok() && flat([0.0, 0.0, 1e-4]).is_ok());
}

#[test]
fn threads_that_no_machine_has_are_refused() {
    let mut scene = Scene::new("one");
    scene.cloths.push(Flat::square("sheet", 5).cloth().unwrap());
    let error = Stepper::on_cpu(scene, Options { threads: 5000, ..Options::default() }).err().map(|e| e.to_string());
    assert!(error.is_some_and(|text| text.contains("number of threads is 5000")));
}
