use super::*;
use crate::cloth::{Cloth, ClothContact, ContactTier, Flat};
use crate::crossings::{self, Drawn};
use crate::levels::joint::Joint;
use crate::levels::safe::ROUNDS;
use crate::number::real::sub;

/// -1 to 1, the same for the same numbers.
pub fn noise(k: usize, of: usize) -> f64 {
    let mut x = (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (of as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 31)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^= x >> 29;
    (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn sheet(flat: Flat) -> Cloth {
    let mut cloth = flat.cloth().unwrap();
    cloth.contact = Some(ClothContact { tier: ContactTier::Safe, ..ClothContact::default() });
    cloth
}

/// Two squares, one 3 cm above the other.
pub fn two(n: u32) -> Vec<Cloth> {
    [0.0, 0.03].map(|y| sheet(Flat { origin: [0.0, y, 0.0], ..Flat::square("sheet", n) })).into()
}

/// The lists of some cloths where they are at rest.
pub fn lists<T: Real>(cloths: &[Cloth]) -> (Joint, Lists<T>) {
    let of: Vec<&Cloth> = cloths.iter().collect();
    let layout = Joint::of(&of, &vec![0.01; of.len()]);
    let mut lists = Lists::new(layout.table.clone(), layout.particles);
    for (cloth, first) in cloths.iter().zip(&layout.firsts) {
        let w = |k: usize| T::of(cloth.inverse_mass(k).into());
        let at = |(k, p): (usize, &[f32; 3])| with_w(p.map(|x| T::of(x.into())), w(k));
        let now: Vec<[T; 4]> = cloth.positions().iter().enumerate().map(at).collect();
        gather::run(&mut lists, *first as usize, &now, [true, true, false]);
    }
    for g in 0..lists.grids() {
        let patch = lists.patch(g);
        for (i, j) in (0..patch.height).flat_map(|j| (0..patch.width).map(move |i| (i, j))) {
            lists.faces[patch.at([i, j])] = faces::features(&lists, &patch, [i, j], &[]);
        }
    }
    (layout, lists)
}

/// A step of all particles; how many were held back, how many pins left their half-spaces, and how many particles were too fast.
pub fn step<T: Real>(lists: &mut Lists<T>) -> [usize; 3] {
    let mut all = [0; 3];
    for _ in 0..ROUNDS {
        paths::run(lists);
        lists.refit();
        let counts = truncate::run(lists);
        all = [all[0] + counts.held, all[1] + counts.forced, counts.more];
        if counts.more == 0 {
            break;
        }
    }
    all
}

fn rounded<T: Real>(p: V3<f64>) -> V3<T> {
    p.map(|x| T::of((x as f32).into()))
}

/// Wants each particle, by its number, to go somewhere; all duplicates of a point go the same way.
fn want<T: Real>(lists: &mut Lists<T>, to: impl Fn(usize, V3<f64>) -> V3<f64>) {
    for k in 0..lists.goals.len() {
        let point = lists.point(k);
        if point != NOBODY {
            let at = xyz(lists.places[point as usize]).map(Real::get);
            lists.goals[k] = with_w(rounded(to(point as usize, at)), lists.goals[k][3]);
        }
    }
}

/// Pairs that cross, and that touch.
pub fn found<T: Real>(cloths: &[Cloth], layout: &Joint, lists: &Lists<T>) -> [u64; 2] {
    let now = |(cloth, first): (&Cloth, &u32)| -> Vec<[f32; 4]> {
        let places = &lists.places[*first as usize..][..cloth.len()];
        let of = |(k, p): (usize, &[T; 4])| with_w([0, 1, 2].map(|c| p[c].get() as f32), cloth.inverse_mass(k));
        places.iter().enumerate().map(of).collect()
    };
    let now: Vec<Vec<[f32; 4]>> = cloths.iter().zip(&layout.firsts).map(now).collect();
    let drawn: Vec<_> = cloths.iter().zip(&now).map(|(cloth, now)| Drawn::at(cloth, now)).collect();
    let found = crossings::find(&drawn, 0).unwrap();
    [found.total(), found.touching]
}

fn crumples<T: Real>(cloths: &[Cloth], (away, speed): (f64, f64), seed: usize) {
    let (layout, mut lists) = lists::<T>(cloths);
    want(&mut lists, |_, p| [p[0] + away, p[1], p[2]]);
    lists.places.clone_from(&lists.goals);
    let (mut held, mut moved) = (0, 0.0);
    let mut free: Vec<V3<f64>> = lists.places.iter().map(|p| xyz(*p).map(Real::get)).collect();
    for n in 0..50 {
        // Each pulls to where others are: through one another, crumpled, and then in a heap.
        let pull = |k: usize, p: V3<f64>| {
            let middle = [p[0] - away, p[1], p[2]];
            [0, 1, 2].map(|c| speed * (0.02 * noise(k, 3 * n + c + 1000 * seed) - 0.02 * middle[c]))
        };
        want(&mut lists, |k, p| add(p, pull(k, p)));
        free.iter_mut().enumerate().for_each(|(k, p)| *p = add(*p, pull(k, *p)));
        let before = lists.places.clone();
        let counts = step(&mut lists);
        (held, moved) = (held + counts[0], moved + way(&before, &lists.places));
        assert_eq!(counts[1], 0);
        assert_eq!(found(cloths, &layout, &lists)[0], 0, "{away} m away, seed {seed}, step {n}");
    }
    lists.places.iter_mut().zip(&free).for_each(|(place, free)| *place = with_w(free.map(T::of), place[3]));
    let crossed = found(cloths, &layout, &lists)[0];
    assert!(
        held > 1000 && moved > 0.2 && crossed > 10,
        "{held} held, {moved} m on the way, {crossed} crossings without"
    );
}

/// The mean way of particles.
fn way<T: Real>(before: &[[T; 4]], after: &[[T; 4]]) -> f64 {
    let far = |(a, b): (&[T; 4], &[T; 4])| sub(xyz(*b), xyz(*a)).map(|x| x.get().powi(2)).iter().sum::<f64>().sqrt();
    before.iter().zip(after).map(far).sum::<f64>() / before.len() as f64
}

/// A sheet whose first and last columns are one, as a tube.
pub fn tube(n: u32) -> Cloth {
    let mut tube = crate::cpu::joint::tests::sheet(Flat { height: 7, ..Flat::square("tube", n) });
    let around = |(k, _): (usize, &[f32; 3])| {
        let angle = std::f32::consts::TAU * (k as u32 % n % (n - 1)) as f32 / (n - 1) as f32;
        [0.16 * angle.cos() + 0.4, 0.2 + 0.1 * (k as u32 / n) as f32, 0.16 * angle.sin() + 0.4]
    };
    let positions = tube.positions().iter().enumerate().map(around).collect();
    let rings: Vec<[u32; 2]> = (0..7).map(|row| [row * n, row * n + n - 1]).collect();
    tube = sewn(tube, &rings);
    tube.place(positions).unwrap();
    tube
}

/// The cloth with duplicates at some pairs of particles.
fn sewn(cloth: Cloth, pairs: &[[u32; 2]]) -> Cloth {
    use crate::cloth::{Mass, Particle, Parts};
    let next = |k: u32| pairs.iter().find_map(|[a, b]| if *a == k { Some(*b) } else { (*b == k).then_some(*a) });
    let mut positions = cloth.positions().to_vec();
    pairs.iter().for_each(|[a, b]| positions[*b as usize] = positions[*a as usize]);
    let parts = Parts {
        name: cloth.name().into(),
        grids: cloth.grids().to_vec(),
        positions,
        particles: (0..cloth.len() as u32).map(|k| Particle::Free { next: next(k) }).collect(),
        rest: cloth.rest().clone(),
        mass: Mass::Constant(1e-3),
    };
    let mut sewn = Cloth::new(parts).unwrap();
    sewn.contact = cloth.contact;
    sewn
}

#[test]
fn whatever_particles_want_nothing_crosses() {
    crumples::<f32>(&two(9), (0.0, 1.0), 1);
    crumples::<f64>(&two(9), (0.0, 1.0), 2);
    let mut several = two(7);
    several.push(tube(9));
    // Where floats are sparse, and at many times the speed that a round allows.
    crumples::<f32>(&several, (0.0, 1.0), 3);
    crumples::<f32>(&several, (700.0, 1.0), 4);
    crumples::<f32>(&several, (0.0, 5.0), 5);
}

#[test]
fn a_sheet_slides_on_another_one_that_it_is_pressed_against() {
    let cloths = two(9);
    let (layout, mut lists) = lists::<f32>(&cloths);
    let upper = layout.firsts[1] as usize;
    for _ in 0..50 {
        want(&mut lists, |k, p| if k < upper { p } else { add(p, [0.002, -0.004, 0.0]) });
        step(&mut lists);
        assert_eq!(found(&cloths, &layout, &lists)[0], 0);
    }
    let slid = |k: usize| f64::from(lists.places[upper + k][0]) - f64::from(cloths[1].positions()[k][0]);
    let least = (0..81).map(slid).fold(f64::INFINITY, f64::min);
    let gap = lists.places[upper + 40][1] - lists.places[40][1];
    assert!(least > 0.095, "the last particle slid {least} m of 0.1");
    assert!(gap > 0.0 && gap < 0.003, "{gap} m are left of 0.03");
}

#[test]
fn pins_that_push_cloth_are_given_way_to_and_those_that_go_through_are_counted() {
    for (down, forces) in [(-0.004, false), (-0.06, true)] {
        let cloths = two(9);
        let (layout, mut lists) = lists::<f32>(&cloths);
        let upper = layout.firsts[1] as usize;
        lists.goals.iter_mut().filter(|goal| goal[3] > 0.0).for_each(|goal| goal[3] = 0.0);
        want(&mut lists, |k, p| if k < upper { p } else { add(p, [0.0, down, 0.0]) });
        assert_eq!(step(&mut lists)[1] > 0, forces, "{down} m");
        assert_eq!(lists.places[upper + 40][..3], lists.goals[upper + 40][..3], "pins go where they are told");
    }
}

#[test]
fn particles_of_even_blocks_cross_nothing_within_their_balls() {
    let cloths = [sheet(Flat::square("block", 3))];
    let (mut even, mut bent) = (0, 0);
    for seed in 0..400 {
        let (layout, mut lists) = lists::<f32>(&cloths);
        let curl = 2.0 * noise(seed, 1).abs();
        let turned = |k: usize, p: V3<f64>| {
            let at = [(curl * p[0]).sin() / curl, p[1] + (1.0 - (curl * p[0]).cos()) / curl, p[2]];
            add(at, [0, 1, 2].map(|c| 0.08 * noise(k, seed + 1000 * (c + 1))))
        };
        want(&mut lists, turned);
        lists.places.clone_from(&lists.goals);
        want(&mut lists, |k, p| add(p, [0, 1, 2].map(|c| 0.04 * noise(k, seed + 5000 * (c + 1)))));
        paths::run(&mut lists);
        let balls: Vec<Ball<f32>> = (0..9).map(|k| lists.ball(k)).collect();
        if !even::is_even(&std::array::from_fn(|k| balls[k]), 0.005) {
            continue;
        }
        even += 1;
        bent += usize::from(curl > 1.0);
        for time in 0..20 {
            for (k, ball) in balls.iter().enumerate() {
                let off = [0, 1, 2].map(|c| noise(k, seed + 31 * time + 7000 * (c + 1)));
                let far = off.iter().map(|x| x * x).sum::<f64>().sqrt();
                let off = off.map(|x| (x / far) as f32 * ball.radius);
                lists.places[k] = with_w(add(ball.center, off), 1.0);
            }
            assert_eq!(found(&cloths, &layout, &lists), [0, 0], "block {seed}");
        }
    }
    assert!(even > 100 && bent > 20, "{even} even blocks, {bent} of them bent");
}

#[test]
fn every_feature_of_cells_is_there_once() {
    let mut cloths = vec![tube(9)];
    cloths.extend(two(6));
    let (_, lists) = lists::<f32>(&cloths);
    let (mut edges, mut vertices, mut triangles) = (Vec::new(), Vec::new(), 0);
    for g in 0..lists.grids() {
        let patch = lists.patch(g);
        for (i, j) in (0..patch.height).flat_map(|j| (0..patch.width).map(move |i| (i, j))) {
            let (bits, k) = (lists.faces[patch.at([i, j])], patch.corners([i, j]));
            let on = |n: usize| bits >> n & 1 == 1;
            triangles += usize::from(on(0)) + usize::from(on(1));
            let own = faces::EDGES.iter().enumerate().filter(|(n, _)| on(10 + n));
            edges.extend(own.map(|(_, [a, b])| [k[*a].min(k[*b]), k[*a].max(k[*b])]));
            vertices.extend((0..4).filter(|n| on(16 + n)).map(|n| k[n]));
        }
    }
    // A tube of 9 columns, the last of which is the first, and 7 rows, and two squares of 6.
    assert_eq!(triangles, 2 * 8 * 6 + 2 * 2 * 25);
    let count = edges.len();
    edges.sort_unstable();
    edges.dedup();
    assert_eq!([edges.len(), count], [8 * 7 + 9 * 6 + 8 * 6 + 2 * (2 * 5 * 6 + 25); 2]);
    let count = vertices.len();
    vertices.sort_unstable();
    vertices.dedup();
    assert_eq!([vertices.len(), count], [63 + 72; 2]);
}

#[test]
fn a_particle_that_is_held_back_keeps_its_motion_along_the_surface() {
    let cloths = two(3);
    let (_, mut lists) = lists::<f64>(&cloths);
    let start = lists.places[..9].to_vec();
    // All fly to the right and down; they are held back where they are in height. Gravity, or a push that previous positions followed, led there.
    for (down, left) in [(0.02, 0.0), (0.0, 0.0)] {
        let mut now: Vec<[f64; 4]> = start.iter().map(|p| [p[0] + 0.01, p[1] - 0.02, p[2], 1.0]).collect();
        let mut before: Vec<[f64; 4]> = start.iter().map(|p| [p[0], p[1] - 0.02 + down, p[2], 1.0]).collect();
        for (place, p) in lists.places.iter_mut().zip(&now) {
            *place = [p[0], p[1] + 0.02, p[2], 1.0];
        }
        now[4][3] = 0.0;
        let pinned = now[4];
        hold_back::run(&lists, 0, &mut now, &mut before);
        assert_eq!(now[4], pinned);
        for k in (0..9).filter(|k| *k != 4) {
            let speed = sub(xyz(now[k]), xyz(before[k]));
            assert!((speed[0] - 0.01).abs() < 1e-12 && (speed[1] - left).abs() < 1e-12, "{speed:?}");
        }
    }
}
