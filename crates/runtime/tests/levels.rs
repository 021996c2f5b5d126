//! Level of detail: what a switch moves, and what it leaves as it is.

use crate::support::alike::rounding;
use crate::support::rig::{Rig, largest};
use crate::support::{self, FRAME, all_colliders, curtain, hung_tube, made_of, scene, two_charts, wind};
use gimage_runtime::*;

/// A curtain in a wind of this strength, beside a tube with a seam.
fn moving(n: u32, strength: f32) -> Scene {
    let mut scene = scene(curtain(n));
    scene.cloths[0].damping = 0.5;
    scene.cloths.push(hung_tube(1));
    let air = wind(true);
    let velocity = [0.8, 0.1, 0.4].map(|x| x * strength);
    scene.wind = Some(Wind { velocity, ..air }).filter(|_| strength > 0.0);
    scene
}

/// Points of the surface that is drawn: vertices, and the middles of triangles' sides; by the texels of the finest image.
fn drawn(stepper: &Stepper, positions: &[[f32; 4]]) -> Vec<([u32; 2], [f64; 3])> {
    let cloth = &stepper.scene().cloths[0];
    let samples = stepper.level_samples(0).unwrap();
    // The width of level 0.
    let width = 1 + samples[cloth.grids()[0].width as usize - 1];
    let at = |k: usize| [samples[k] % width, samples[k] / width];
    let p = |k: usize| [0, 1, 2].map(|c| f64::from(positions[k][c]));
    let mut points: Vec<_> = (0..cloth.len()).map(|k| (at(k).map(|x| 2 * x), p(k))).collect();
    for triangle in cloth.indices().chunks(3) {
        for (a, b) in [(0, 1), (1, 2), (2, 0)].map(|(a, b)| (triangle[a] as usize, triangle[b] as usize)) {
            let (u, v) = (at(a), at(b));
            points.push(([u[0] + v[0], u[1] + v[1]], [0, 1, 2].map(|c| (p(a)[c] + p(b)[c]) / 2.0)));
        }
    }
    points
}

/// The largest way of a point that is drawn of both surfaces [m].
fn jump(a: &[([u32; 2], [f64; 3])], b: &[([u32; 2], [f64; 3])]) -> f64 {
    let known: std::collections::HashMap<_, _> = a.iter().copied().collect();
    let both = b.iter().filter_map(|(at, p)| Some((known.get(at)?, p)));
    let far = both.map(|(p, q)| (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f64>().sqrt());
    let (most, count) = far.fold((0.0, 0), |(most, n), d| (f64::max(most, d), n + 1));
    assert!(count * 4 > a.len().min(b.len()), "{count} points in common");
    most
}

fn velocities(rig: &mut Rig) -> Vec<[f32; 3]> {
    rig.stepper.state(0).unwrap().velocities()
}

/// Strengths of the wind, the largest jump of the surface at a switch to the coarse image as a share of a coarse cell, and the fastest
/// frame after a switch over the fastest before.
const STRENGTHS: [(f32, f64); 3] = [(0.0, 0.005), (0.5, 0.05), (1.0, 0.3)];
/// A coarse cell [m].
const CELL: f64 = 1.0 / 16.0;

#[test]
fn a_switch_moves_the_surface_by_less_than_a_share_of_a_cell() {
    for (strength, most) in STRENGTHS {
        for mut rig in Rig::both(&moving(33, strength), &Options::default()) {
            let name = rig.name();
            rig.frames(120);
            let before = drawn(&rig.stepper, &rig.positions(0));
            let fast = velocities(&mut rig);
            let handle = rig.stepper.handle(0).unwrap();
            rig.stepper.set_level(handle, 1).unwrap();
            assert_eq!((rig.stepper.level(0).unwrap(), rig.stepper.handle(0).unwrap()), (1, handle));
            assert_eq!(rig.stepper.scene().cloths[0].grids()[0].width, 17);
            let down = jump(&before, &drawn(&rig.stepper, &rig.positions(0))) / CELL;
            let coarse = velocities(&mut rig);
            let samples = rig.stepper.level_samples(0).unwrap();
            let of = |v: &[f32; 3], w: &[f32; 3]| (0..3).map(|c| (v[c] - w[c]).abs()).fold(0.0, f32::max);
            let slower = coarse.iter().zip(&samples).map(|(v, k)| of(v, &fast[*k as usize])).fold(0.0, f32::max);

            rig.frames(30);
            let before = drawn(&rig.stepper, &rig.positions(0));
            let slow = velocities(&mut rig);
            rig.stepper.set_level(handle, 0).unwrap();
            let up = jump(&drawn(&rig.stepper, &rig.positions(0)), &before) / CELL;
            let fine = velocities(&mut rig);
            let faster = slow.iter().zip(&samples).map(|(v, k)| of(v, &fine[*k as usize])).fold(0.0, f32::max);
            eprintln!("{name} {strength}: down {down:.4}, up {up:.7} of a cell; velocities {slower} and {faster} m/s");
            assert!(down < most, "{name} {strength}: to the coarse image the surface jumps {down:.4} of a cell");
            assert!(up < 1e-5, "{name} {strength}: to the fine image the surface jumps {up:.7} of a cell");
            assert!(slower.max(faster) < 2e-3, "{name} {strength}: velocities change by {slower} and {faster} m/s");
            rig.frames(30);
            assert!(rig.positions(0).iter().flatten().all(|x| x.is_finite()), "{name}");
        }
    }
}

#[test]
fn both_backends_switch_alike() {
    let sewn = Scene { wind: Some(wind(true)), ..scene(two_charts(23)) };
    let woven = Scene { wind: Some(wind(true)), ..scene(made_of(curtain(24))) };
    for (name, of) in [("curtain", moving(33, 1.0)), ("charts", sewn), ("material", woven)] {
        let mut rigs = Rig::both(&of, &Options { substeps: Some(4), ..Options::default() });
        let [here, there] = &mut rigs[..] else { return };
        let limit = there.device().map_or(1e-6, |device| rounding(device, 1e-6));
        here.frames(60);
        for level in [1, 2, 1, 0, 2, 0] {
            // From the same state and time, as rounding grows from frame to frame.
            let state = here.stepper.snapshot().unwrap();
            there.stepper.restore(&state).unwrap();
            let gap = |here: &Rig, there: &Rig| {
                let of = |list: fn(&Rig, usize) -> Vec<[f32; 4]>| largest(&list(here, 0), &list(there, 0));
                of(Rig::positions).max(of(Rig::previous))
            };
            [&mut *here, &mut *there].into_iter().for_each(|rig| rig.stepper.set_level(0, level).unwrap());
            let switched = gap(here, there);
            [&mut *here, &mut *there].into_iter().for_each(|rig| rig.frame(FRAME));
            let stepped = gap(here, there);
            eprintln!("{name}, level {level}: {switched:e} m apart behind the switch, {stepped:e} m after four steps");
            assert!(switched <= limit && stepped <= 4.0 * limit, "{name}, level {level}: {switched} and {stepped} m");
            here.frames(10);
        }
    }
}

#[test]
fn motion_goes_on_as_fast_as_before() {
    for (strength, _) in STRENGTHS {
        for mut rig in Rig::both(&moving(33, strength), &Options::default()) {
            let name = rig.name();
            rig.frames(120);
            let mut last = drawn(&rig.stepper, &rig.positions(0));
            let fastest = |rig: &mut Rig, last: &mut Vec<_>| {
                let mut most = 0f64;
                for _ in 0..6 {
                    rig.frame(FRAME);
                    let now = drawn(&rig.stepper, &rig.positions(0));
                    most = most.max(jump(last, &now));
                    *last = now;
                }
                most
            };
            for level in [1, 2, 1, 0, 2, 0] {
                let before = fastest(&mut rig, &mut last);
                rig.stepper.set_level(0, level).unwrap();
                last = drawn(&rig.stepper, &rig.positions(0));
                let after = fastest(&mut rig, &mut last);
                eprintln!("{name} {strength}: level {level}: {before:.4} m per frame before, {after:.4} m after");
                assert!(
                    after < 1.5 * before + 0.004,
                    "{name} {strength}: level {level}: {before} m per frame, then {after}"
                );
                rig.frames(30);
                last = drawn(&rig.stepper, &rig.positions(0));
            }
        }
    }
}

#[test]
fn seams_stay_closed_and_other_cloths_keep_their_bits() {
    let mut of = scene(two_charts(17));
    of.cloths[0].damping = 0.5;
    of.cloths.push(curtain(12));
    of.cloths.push(hung_tube(1));
    for (mut rig, mut other) in Rig::both(&of, &Options::default()).into_iter().zip(Rig::both(&of, &Options::default()))
    {
        let name = rig.name();
        for (frame, level) in [(10, 1), (10, 2), (10, 0), (5, 1)] {
            rig.frames(frame);
            other.frames(frame);
            rig.stepper.set_levels(&[(0.into(), level), (2.into(), level.min(1))]).unwrap();
            for cloth in [0, 2] {
                let positions = rig.positions(cloth);
                let (starts, members) = rig.stepper.scene().cloths[cloth].rings();
                assert!(starts.len() > 2, "{name}: there are seams on level {level}");
                for ring in starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]) {
                    let bits = |k: &u32| [0, 1, 2].map(|c| positions[*k as usize][c].to_bits());
                    assert!(ring.iter().all(|k| bits(k) == bits(&ring[0])), "{name}: level {level}");
                }
            }
        }
        rig.frames(10);
        other.frames(10);
        assert_eq!(rig.positions(1), other.positions(1), "{name}: a cloth that stays keeps its bits");
        assert!(rig.positions(0).iter().flatten().all(|x| x.is_finite()), "{name}");
    }
}

#[test]
fn pins_come_along_both_ways() {
    let mut of = scene(curtain(17));
    // A pin between coarse texels.
    of.cloths[0].pin(&[8 * 17 + 7]).unwrap();
    for mut rig in Rig::both(&of, &Options::default()) {
        rig.frames(20);
        let held = rig.positions(0)[8 * 17 + 7];
        rig.stepper.set_level(0, 1).unwrap();
        rig.frames(5);
        let pinned = |rig: &Rig| rig.stepper.scene().cloths[0].select(&Select::Pinned).unwrap();
        assert_eq!(pinned(&rig).len(), 9 + 1, "{}", rig.name());
        // The host moves the row on the coarse level, and frees its end.
        let row: Vec<u32> = (0..9).collect();
        let at: Vec<[f32; 3]> = (0..9).map(|i| [i as f32 / 8.0, 0.1, 0.0]).collect();
        rig.stepper.set_pins(0, &row, &at).unwrap();
        rig.stepper.unpin(0, &[8]).unwrap();
        rig.frames(2);
        rig.stepper.set_level(0, 0).unwrap();
        assert_eq!(pinned(&rig).len(), 15 + 1, "{}: the last two are free", rig.name());
        let now = rig.positions(0);
        assert!((0..15).all(|k| (now[k][1] - 0.1).abs() < 1e-6 && now[k][3] == 0.0), "{}", rig.name());
        assert!((0..3).all(|c| (now[8 * 17 + 7][c] - held[c]).abs() < 1e-6), "{}: {held:?}", rig.name());
    }
}

#[test]
fn levels_that_are_not_there_change_nothing() {
    let mut stepper = Stepper::on_cpu(scene(curtain(17)), Options::default()).unwrap();
    stepper.advance(0.1).unwrap();
    let before = stepper.state(0).unwrap();
    let error = stepper.set_level(0, 9).unwrap_err();
    assert!(matches!(error, Error::Coarser { .. }), "{error}");
    assert_eq!((stepper.state(0).unwrap(), stepper.level(0).unwrap()), (before, 0));
    assert!(stepper.set_level(1, 0).is_err() && stepper.level(1).is_err());
    stepper.set_level(0, 1).unwrap();
    stepper.cut([0.3, -0.3, -1.0], [0.3, -0.3, 1.0], [0.6, -0.4, 0.0]).unwrap();
    let error = stepper.set_level(0, 0).unwrap_err().to_string();
    assert!(error.contains("before the first cut"), "{error}");
    let far = [0.0, 5.0, 9.5, 10.0, 24.0, 26.0, f64::INFINITY].map(|d| level_at(d, 1, &[10.0, 25.0], 0.1));
    assert_eq!(far, [0, 0, 1, 1, 1, 2, 2]);
    assert_eq!(level_at(f64::NAN, 1, &[10.0], 0.1), 1);
}

#[test]
fn limits_and_teleports_follow() {
    let mut limited = curtain(17);
    limited.limits = Some(vec![0.1; 289].into());
    limited.damping = 0.5;
    let mut of = scene(limited);
    of.wind = Some(wind(true));
    for mut rig in Rig::both(&of, &Options { substeps: Some(8), ..Options::default() }) {
        rig.frames(10);
        rig.stepper.teleport(0, &scene::Pose { position: [3.0, 0.0, 0.0], ..Default::default() }).unwrap();
        for level in [1, 0, 1] {
            rig.stepper.set_level(0, level).unwrap();
            rig.frames(10);
            let start = rig.stepper.scene().cloths[0].positions();
            for (k, p) in rig.positions(0).iter().enumerate() {
                let way = [p[0] - start[k][0] - 3.0, p[1] - start[k][1], p[2] - start[k][2]];
                let far = way.iter().map(|x| x * x).sum::<f32>().sqrt();
                assert!(far < 0.105, "{}: particle {k} is {far} m away on level {level}", rig.name());
            }
        }
    }
}

#[test]
fn materials_go_on_among_colliders() {
    let mut of = scene(made_of(curtain(17)));
    of.colliders = all_colliders();
    for mut rig in Rig::both(&of, &Options { substeps: Some(16), ..Options::default() }) {
        rig.frames(10);
        for level in [1, 0, 1] {
            rig.stepper.set_level(0, level).unwrap();
            rig.frames(10);
            let state = rig.stepper.state(0).unwrap();
            let health = rig.stepper.examine(0, state.positions(), state.previous()).unwrap();
            let longest = health.stretch.map_or(0.0, |s| s.p99);
            assert!(longest < 0.1, "{}: {longest} on level {level}", rig.name());
            assert!(health.depth < 0.01, "{}: {} m deep on level {level}", rig.name(), health.depth);
        }
    }
}

#[test]
fn a_lost_device_continues_on_the_level_of_the_switch() {
    let Some(device) = support::device() else { return };
    let mut of = moving(17, 1.0);
    // A pin between coarse texels.
    of.cloths[0].pin(&[8 * 17 + 7]).unwrap();
    let mut rig = Rig::gpu(of, &Options::default(), &device);
    // The last state on the host is of the level before the switch.
    for (from, to) in [(0, 1), (1, 0), (0, 2), (2, 0)] {
        rig.stepper.set_level(0, from).unwrap();
        rig.frames(5);
        rig.stepper.state(0).unwrap();
        rig.stepper.set_level(0, to).unwrap();
        let switched = rig.positions(0);
        rig.frames(5);
        let other = support::device().unwrap();
        rig.recover(&other);
        rig.frame(0.0);
        assert_eq!(rig.stepper.level(0).unwrap(), to);
        let far = largest(&rig.positions(0), &switched);
        assert!(far < 1e-5, "from level {from} to {to}: {far} m");
    }
    rig.frames(3);
    assert!(rig.positions(0).iter().flatten().all(|x| x.is_finite()));
}
