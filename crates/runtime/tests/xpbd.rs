//! XPBD with tethers and swept contact, on the CPU.

use crate::support::{self, FRAME, compared, is_exact, measured, run, scene};
use gimage_runtime::*;

fn options(substeps: u32) -> Options {
    Options { backend: Backend::Cpu, solver: Solver::Xpbd, substeps: Some(substeps), threads: 1, ..Options::default() }
}

#[test]
fn a_sheet_on_two_pins_is_flat_within_a_percent() {
    // The classic solver: 32 % / 1.5 % in eight substeps.
    let mut end = run(scene::builtin("s1", 32).unwrap(), options(4), 599);
    let was = end.positions(0).unwrap().to_vec();
    end.advance(FRAME).unwrap();
    let m = measured(&end);
    let moved = |(a, b): (&[f32; 4], &[f32; 4])| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>();
    let rms = (was.iter().zip(end.positions(0).unwrap()).map(moved).sum::<f32>() / 1024.0).sqrt() * 60.0;
    assert!(rms < 1e-3, "{rms} m/s");
    assert!(m.stretch_max < 0.01 && m.stretch_mean < 3e-4, "{m:?}");
    // Without tethers it is the classic solver's error, in another order of passes.
    let without = measured(&run(scene::builtin("s1", 32).unwrap(), Options { tethers: 0, ..options(8) }, 600));
    assert!((0.1..0.4).contains(&without.stretch_max), "{without:?}");
}

#[test]
fn soft_springs_stretch_as_far_as_their_compliance_says() {
    // Springs of 1000 N/m: max stretch 0.016987, whatever the number of substeps, once there are enough relaxations.
    for (substeps, iterations) in [(8, 100), (16, 40), (32, 15)] {
        let scene = scene::builtin("s1k", 32).unwrap();
        let end = run(scene, Options { iterations, tethers: 0, ..options(substeps) }, 600);
        let m = measured(&end);
        assert!((m.stretch_max / 0.016987 - 1.0).abs() < 0.05, "{substeps}: {m:?}");
        let hem = end.positions(0).unwrap().iter().map(|p| p[1]).fold(0.0, f32::min);
        assert!((f64::from(hem) / -1.002_200_3 - 1.0).abs() < 1e-3, "{substeps}: {hem}");
    }
}

#[test]
fn tethers_do_not_hide_the_compliance_of_springs() {
    // The truth of springs of 1000 N/m: 1.6987 %, the lowest particle at -1.0022003 m.
    let end = run(scene::builtin("s1k", 32).unwrap(), Options { substeps: None, ..options(1) }, 600);
    let m = measured(&end);
    assert!((m.stretch_max / 0.016987 - 1.0).abs() < 0.05, "{m:?}");
    let hem = end.positions(0).unwrap().iter().map(|p| p[1]).fold(0.0, f32::min);
    assert!((f64::from(hem) / -1.002_200_3 - 1.0).abs() < 1e-3, "{hem}");
}

/// A sheet of 1 m that lies, with texels pinned, of a fabric or of springs.
fn canopy(n: u32, pins: &[(u32, u32)], fabric: Option<&str>) -> Scene {
    let mut cloth = Flat::square("canopy", n).cloth().unwrap();
    pins.iter().for_each(|(i, j)| cloth.set_pinned((j * n + i) as usize, true).unwrap());
    fabric.iter().for_each(|name| cloth.set_material(&Material::named(name).unwrap()).unwrap());
    cloth.damping = 2.0;
    support::scene(cloth)
}

#[test]
fn a_canopy_is_held_by_all_its_pins() {
    // With two tethers per particle and 4 substeps the mean is 0.8 to 1.4 %, and the largest 25 to 39 %.
    let defaults = || Options { substeps: None, ..options(1) };
    let corners = [(0, 0), (47, 0), (0, 47), (47, 47)];
    let eight = [&corners[..], &[(24, 0), (0, 24), (47, 24), (24, 47)]].concat();
    let inside = [(3, 5), (44, 9), (20, 28), (12, 38), (38, 36), (32, 12)];
    for pins in [&corners[..], &corners[..3], &eight, &inside] {
        let m = measured(&run(canopy(48, pins, None), defaults(), 300));
        assert!(m.stretch_max < 0.06 && m.stretch_mean < 0.002, "{pins:?}: {m:?}");
    }
}

#[test]
fn a_canopy_of_a_fabric_sags_as_the_fabric_says() {
    // The truth by 256 substeps without tethers: 116.5 and 139.7 mm. With exact tethers both sag by 14 mm, with none in as many substeps
    // by 187 and 195 mm.
    let corners = [(0, 0), (31, 0), (0, 31), (31, 31)];
    for (fabric, sag) in [("cotton", 0.1165), ("rubber", 0.1397)] {
        let end = run(canopy(32, &corners, Some(fabric)), Options { substeps: None, ..options(1) }, 360);
        let [_, y, ..] = end.positions(0).unwrap()[16 * 32 + 16];
        assert!((-f64::from(y) / sag - 1.0).abs() < 0.08, "{fabric}: {y} m");
    }
}

#[test]
fn a_flag_of_cotton_in_wind_keeps_its_length() {
    // With 8 substeps the mean stretch is 4 %.
    let mut cloth = Flat { down: [0.0, -1.0, 0.0], ..Flat::square("flag", 40) }.cloth().unwrap();
    (0..40).for_each(|j| cloth.set_pinned(40 * j, true).unwrap());
    cloth.set_material(&Material::named("cotton").unwrap()).unwrap();
    let wind = Wind { velocity: [7.8, 0.0, 1.9], ..support::wind(true) };
    let flag = Scene { wind: Some(wind), ..support::scene(cloth) };
    let end = run(flag, Options { substeps: None, ..options(1) }, 240);
    let m = measured(&end);
    assert!(m.stretch_mean < 0.012, "{m:?}");
    assert_eq!(end.findings(), [], "stretched like rubber");
}

#[test]
fn polishing_takes_stretch_out_of_fine_cloth() {
    let of =
        |polish| measured(&run(scene::builtin("s1", 64).unwrap(), Options { polish: Some(polish), ..options(2) }, 600));
    let (plain, polished) = (of(0), of(1));
    assert!(polished.stretch_max < 0.3 * plain.stretch_max, "{plain:?} {polished:?}");
    assert!(polished.stretch_mean < 0.5 * plain.stretch_mean, "{plain:?} {polished:?}");
}

#[test]
fn a_round_of_polishing_has_structural_springs_and_tethers_where_they_are_due() {
    let passes = |polish, collides: bool| {
        let once = Options { polish: Some(polish), backend: Backend::Cpu, ..options(1) };
        let mut scene = scene::builtin("s1", 8).unwrap();
        let ball = Collider::new(Shape::Sphere { radius: 0.1 }, [0.0, -3.0, 0.0]);
        scene.colliders.extend(collides.then_some(ball));
        let stepper = Stepper::on_cpu(scene, once).unwrap();
        stepper.plan().passes.iter().filter_map(|p| p.form.pass()).collect::<Vec<_>>()
    };
    for collides in [false, true] {
        let plain = passes(0, collides);
        let last = plain.iter().rposition(|p| matches!(p, Pass::Tethers { .. })).unwrap();
        let (tethers, springs) = (plain[last], &plain[last - 4..last]);
        assert!(springs.iter().all(|p| matches!(p, Pass::Stretch { direction: 0 | 1, .. })));
        let over: Vec<_> = springs
            .iter()
            .map(|p| match p {
                Pass::Stretch { direction, parity, image, .. } => {
                    Pass::Polish { direction: *direction, parity: *parity, image: *image }
                }
                other => *other,
            })
            .collect();
        // Alone, cloth has tethers before the first round and behind the last; among colliders, before each round.
        let rounds: [Vec<_>; 2] = if collides {
            [springs.to_vec(), [&over[..], &[tethers], springs].concat()]
        } else {
            [[springs, &[tethers]].concat(), [&over[..], springs, &[tethers]].concat()]
        };
        for (count, rounds) in [1, 2].into_iter().zip(rounds) {
            let expected = [&plain[..=last], &rounds, &plain[last + 1..]].concat();
            assert_eq!(passes(count, collides), expected, "{count} rounds, collides: {collides}");
        }
    }
    let classic = |polish| {
        let once = Options { polish: Some(polish), solver: Solver::Classic, backend: Backend::Cpu, ..options(1) };
        Stepper::on_cpu(scene::builtin("s1", 8).unwrap(), once).unwrap().plan()
    };
    assert_eq!(classic(0), classic(3));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mut large = support::on_colliders(290);
    large.wind = Some(support::wind(true));
    large.cloths[0].set_pinned(7, true).unwrap();
    let bits = |threads| {
        let stepper = run(large.clone(), Options { threads, pyramid: 2, polish: Some(1), ..options(2) }, 10);
        let bits = |list: &[[f32; 4]]| list.iter().map(|v| v.map(f32::to_bits)).collect::<Vec<_>>();
        (bits(stepper.positions(0).unwrap()), bits(stepper.previous(0).unwrap()))
    };
    let one = bits(1);
    assert!(one == bits(2) && one == bits(5) && one == bits(0));
}

#[test]
fn the_error_of_f32_is_small() {
    for (name, scene) in [compared(), support::soft()].concat() {
        // One step, as long as it may be without tethers.
        is_exact(name, scene, Options { iterations: 2, pyramid: 1, polish: Some(1), step: FRAME / 2.0, ..options(1) });
    }
}

#[test]
fn nothing_goes_through_a_sphere_at_30_metres_a_second() {
    let inside = |p: &[f32; 4]| 0.3 - (0..3).map(|c| f64::from(p[c]).powi(2)).sum::<f64>().sqrt();
    for substeps in [1, 2, 4, 16] {
        // Half a metre in the first frame, of which 0.05 m are air above the sphere. Without springs first: nothing
        // pulls particles round it.
        let mut loose = scene::builtin("s2f", 64).unwrap();
        let cloth = &loose.cloths[0];
        let (positions, particles) = (cloth.positions().to_vec(), cloth.particles().to_vec());
        let (grids, mass) = (cloth.grids().to_vec(), Mass::Constant(1e-4));
        let parts = Parts { name: "sand".into(), grids, positions, particles, rest: Rest::None, mass };
        loose.cloths = vec![Cloth::new(parts).unwrap()];
        loose.cloths[0].velocity = [0.0, -30.0, 0.0];
        let stepper = run(loose, options(substeps), 1);
        let start = stepper.scene().cloths[0].positions().to_vec();
        let above = |p: &[f32; 3]| p[0].hypot(p[2]) < 0.15;
        let through = |(p, q): (&[f32; 3], &[f32; 4])| above(p) && q[1] < 0.0;
        assert_eq!(start.iter().zip(stepper.positions(0).unwrap()).filter(|x| through(*x)).count(), 0, "{substeps}");
        let mut stepper = run(scene::builtin("s2f", 64).unwrap(), options(substeps), 0);
        for _ in 0..12 {
            stepper.advance(FRAME).unwrap();
            let deepest = stepper.positions(0).unwrap().iter().map(inside).fold(0.0, f64::max);
            assert!(deepest < 5e-5, "{substeps}: {deepest} m");
        }
    }
}

#[test]
fn a_ball_at_30_metres_a_second_does_not_go_through_cloth() {
    // It flies along z into a sheet hung from its upper row.
    let mut cloth = Flat { down: [0.0, -1.0, 0.0], ..Flat::square("sheet", 33) }.cloth().unwrap();
    (0..33).for_each(|i| cloth.set_pinned(i, true).unwrap());
    let mut stepper = Stepper::on_cpu(scene(cloth), options(4)).unwrap();
    let ball = |z| {
        let shape = Shape::Sphere { radius: 0.1 };
        vec![Collider { velocity: [0.0, 0.0, 30.0], ..Collider::new(shape, [0.5, -0.5, z]) }]
    };
    for frame in 0..4 {
        stepper.set_colliders(ball(-0.75 + 0.5 * frame as f32)).unwrap();
        stepper.advance(FRAME).unwrap();
    }
    // Its middle is at 0.75 m; what was in its way is before it, not behind.
    for p in stepper.positions(0).unwrap() {
        let d = (0..3).map(|c| (p[c] - [0.5, -0.5, 0.75][c]).powi(2)).sum::<f32>().sqrt();
        assert!(d > 0.1 - 5e-5, "{p:?}");
    }
    let centre = stepper.positions(0).unwrap()[33 * 16 + 16];
    assert!(centre[2] > 0.0, "{centre:?}");
}

#[test]
fn a_pyramid_keeps_cloth_together_that_no_tether_holds() {
    // Hung cloth is drawn together, and ends at rest.
    let m = measured(&run(scene::builtin("s1", 64).unwrap(), Options { tethers: 0, pyramid: 4, ..options(8) }, 600));
    let plain = measured(&run(scene::builtin("s1", 64).unwrap(), Options { tethers: 0, ..options(8) }, 600));
    assert!(m.stretch_max < 0.2 * plain.stretch_max, "{m:?} {plain:?}");
}

#[test]
fn colliders_out_of_reach_change_nothing() {
    let far = |n: u32| {
        let mut scene = scene::builtin("s2", 32).unwrap();
        for k in 0..n {
            let at = [20.0 + k as f32, -5.0, 3.0];
            scene.colliders.push(Collider::new(Shape::Box { half: [0.3; 3] }, at));
        }
        run(scene, options(4), 40).positions(0).unwrap().to_vec()
    };
    assert!(far(0) == far(100));
}

#[test]
fn what_one_collider_pushes_into_another_leaves_both() {
    // The upper ball is out of the flat cloth's reach, until the lower one has pushed its middle up.
    let ball = |radius, y| Collider::new(Shape::Sphere { radius }, [0.5, y, 0.5]);
    let balls = vec![ball(0.3, -0.05), ball(0.1, 0.34)];
    let cloth = Flat::square("sheet", 33).cloth().unwrap();
    let (positions, particles) = (cloth.positions().to_vec(), cloth.particles().to_vec());
    let (grids, mass) = (cloth.grids().to_vec(), Mass::Constant(1e-4));
    let parts = Parts { name: "sand".into(), grids, positions, particles, rest: Rest::None, mass };
    let mut scene = scene(Cloth::new(parts).unwrap());
    scene.gravity = [0.0; 3];
    scene.colliders = balls;
    let stepper = run(scene, options(1), 1);
    let middle = stepper.positions(0).unwrap()[33 * 16 + 16];
    assert!((middle[1] - 0.24).abs() < 1e-3, "pushed up, then down: {middle:?}");
    for p in stepper.positions(0).unwrap() {
        let d = (0..3).map(|c| (p[c] - [0.5, 0.34, 0.5][c]).powi(2)).sum::<f32>().sqrt();
        assert!(d > 0.1 - 1e-5, "{p:?}");
    }
}

#[test]
fn free_cloth_keeps_its_momentum_and_gains_no_energy() {
    let mut cloth = Flat::square("flat", 33).cloth().unwrap();
    cloth.velocity = [1.0, 2.0, -0.5];
    let mut positions = cloth.positions().to_vec();
    // Crumpled, so that springs have something to do.
    for (k, p) in positions.iter_mut().enumerate() {
        p[1] += 0.02 * ((k * 7919) % 13) as f32 / 13.0;
    }
    cloth.place(positions).unwrap();
    let still = Scene { gravity: [0.0; 3], ..scene(cloth) };
    for pyramid in [0, 4] {
        keeps_momentum(still.clone(), Options { pyramid, ..options(8) });
    }
}

fn keeps_momentum(still: Scene, options: Options) {
    let mut stepper = Stepper::on_cpu(still, options).unwrap();
    let mut energy = f64::INFINITY;
    for frame in 0..120 {
        stepper.advance(FRAME).unwrap();
        let (now, before) = (stepper.positions(0).unwrap(), stepper.previous(0).unwrap());
        let dt = FRAME / 8.0;
        let mut sum = [0.0f64; 3];
        for (a, b) in now.iter().zip(before) {
            (0..3).for_each(|c| sum[c] += f64::from(a[c] - b[c]) / dt / now.len() as f64);
        }
        let wrong = (0..3).map(|c| (sum[c] - [1.0, 2.0, -0.5][c]).abs()).fold(0.0, f64::max);
        assert!(wrong < 1e-4 * 2.3, "frame {frame}: {sum:?}");
        let m = measured(&stepper);
        if frame > 0 {
            assert!(m.kinetic <= energy * 1.001, "frame {frame}: {} after {energy}", m.kinetic);
        }
        energy = energy.min(m.kinetic);
    }
}

#[test]
fn a_hanging_sheet_swings_in_its_period() {
    // N = 32, 16 substeps: the discrete chain's 1.68170 s within 0.3 %.
    let stepper = Stepper::on_cpu(scene::builtin("s3", 32).unwrap(), Options { tethers: 0, ..options(16) }).unwrap();
    let period = support::swing_period(stepper);
    assert!((period / 1.68170 - 1.0).abs() < 3e-3, "{period}");
}

#[test]
fn a_pin_that_is_freed_holds_nothing() {
    let mut stepper = run(scene::builtin("s1", 17).unwrap(), options(4), 300);
    stepper.set_pinned(0, 0, false).unwrap();
    (0..600).for_each(|_| assert!(stepper.advance(FRAME).is_ok()));
    // It hangs by the other corner alone, the far one below it.
    let p = stepper.positions(0).unwrap();
    let far = (0..3).map(|c| (p[16 * 17][c] - p[16][c]).powi(2)).sum::<f32>().sqrt();
    assert!((far / 2f32.sqrt() - 1.0).abs() < 0.02 && p[16 * 17][1] < -1.38, "{far} {:?}", p[16 * 17]);
}

#[test]
fn cloth_cut_right_through_falls_off_its_tethers() {
    let mut stepper = run(scene::builtin("s1", 33).unwrap(), options(4), 300);
    stepper.cut([0.5, -0.52, 5.0], [-1.0, -0.52, -5.0], [2.0, -0.52, -5.0]).unwrap();
    (0..60).for_each(|_| assert!(stepper.advance(FRAME).is_ok()));
    let p = stepper.positions(0).unwrap();
    // A second of fall, less what damping takes.
    assert!(p[32 * 33 + 16][1] < -3.0, "{:?}", p[32 * 33 + 16]);
    assert!(p[10 * 33 + 16][1] > -0.6, "{:?}", p[10 * 33 + 16]);
}

#[test]
fn options_that_change_on_the_way_do_what_they_say() {
    // One relaxation after several is the same as one alone: no multiplier is left over.
    for backwards in [false, true] {
        let mut scene = scene::builtin("s1k", 17).unwrap();
        scene.gravity = [0.0, -2.0, 1.0];
        let mut change =
            Stepper::on_cpu(scene.clone(), Options { iterations: 1 + u32::from(backwards), ..options(4) }).unwrap();
        let mut plain = Stepper::on_cpu(scene, Options { iterations: 1, ..options(4) }).unwrap();
        if !backwards {
            change.set_options(Options { iterations: 3, ..options(4) }).unwrap();
            change.advance(FRAME).unwrap();
            let mut three = Stepper::on_cpu(plain.scene().clone(), Options { iterations: 3, ..options(4) }).unwrap();
            three.advance(FRAME).unwrap();
            assert!(change.positions(0) == three.positions(0));
            continue;
        }
        change.set_options(Options { iterations: 1, ..options(4) }).unwrap();
        change.advance(FRAME).unwrap();
        plain.advance(FRAME).unwrap();
        assert!(change.positions(0) == plain.positions(0));
    }
}

#[test]
fn springs_to_no_particle_hold_nothing() {
    // A falling square whose middle is missing, with rest lengths everywhere, as a careless bundle may have.
    let flat = Flat::square("hole", 9).cloth().unwrap();
    let mut particles = flat.particles().to_vec();
    particles[40] = Particle::None;
    let rest = Rest::Image(vec![[0.125, 0.125, 0.176_776_7, 0.176_776_7]; 81]);
    let (grids, mass) = (flat.grids().to_vec(), Mass::Constant(1e-3));
    let parts = Parts { name: "hole".into(), grids, positions: flat.positions().to_vec(), particles, rest, mass };
    for pyramid in [0, 1] {
        let mut stepper =
            Stepper::on_cpu(scene(Cloth::new(parts.clone()).unwrap()), Options { pyramid, ..options(4) }).unwrap();
        (0..30).for_each(|_| assert!(stepper.advance(FRAME).is_ok()));
        // Half a second of free fall: 1.2 m, for all alike.
        for (k, p) in stepper.positions(0).unwrap().iter().enumerate().filter(|(k, _)| *k != 40) {
            assert!((p[1] + 1.2263).abs() < 0.03, "pyramid {pyramid}, particle {k}: {p:?}");
        }
    }
}

#[test]
fn numbers_out_of_range_are_refused() {
    assert!(Options { tethers: 5, ..options(1) }.check().is_err());
    for wrong in [f32::NAN, -1.0, f32::INFINITY] {
        let mut scene = scene::builtin("s1k", 8).unwrap();
        scene.cloths[0].compliance = Compliance::Constant(wrong);
        assert!(Stepper::on_cpu(scene.clone(), options(1)).is_err(), "{wrong}");
        scene.cloths[0].compliance = Compliance::Image(vec![[0.0, wrong, 0.0, 0.0]; 64].into());
        assert!(Stepper::on_cpu(scene.clone(), options(1)).is_err(), "{wrong}");
    }
    let mut scene = scene::builtin("s1k", 8).unwrap();
    scene.cloths[0].compliance = Compliance::Image(vec![[0.0; 4]; 63].into());
    assert!(Stepper::on_cpu(scene, options(1)).is_err());
}

#[test]
fn sizes_of_colliders_out_of_range_are_refused() {
    for (size, sound) in [(1e-3, true), (1e6, true), (1e30, false), (0.0, false), (-1.0, false), (f32::NAN, false)] {
        let collider = Collider::new(Shape::Box { half: [1.0, size, 1.0] }, [0.0; 3]);
        assert_eq!(collider.check().is_ok(), sound, "{size}");
    }
}
