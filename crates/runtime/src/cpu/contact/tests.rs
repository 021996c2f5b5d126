use super::*;
use crate::cloth::Grid;
use crate::collider::{Collider, Shape};

/// -1 to 1, the same for the same numbers.
fn noise(k: usize, of: usize) -> f64 {
    let mut x = (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (of as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 31)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^= x >> 29;
    (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

const RADII: [f32; 3] = [0.3, 0.21, 0.25];

fn shapes() -> [Shape; 10] {
    [
        Shape::HalfSpace,
        Shape::Sphere { radius: 0.25 },
        Shape::Capsule { half_height: 0.2, radius: 0.15 },
        Shape::Box { half: RADII },
        Shape::Ellipsoid { radii: RADII, closest: false },
        Shape::Ellipsoid { radii: RADII, closest: true },
        Shape::Ellipsoid { radii: [0.2, 0.3, 0.2], closest: true },
        Shape::Box { half: [0.2; 3] },
        Shape::TaperedCapsule { half_height: 0.2, radii: [0.1, 0.25] },
        Shape::TaperedCapsule { half_height: 0.06, radii: [0.2, 0.12] },
    ]
}

/// The `k`-th of many ways to be somewhere and to move.
fn collider(shape: Shape, k: usize) -> Collider {
    let n = |of| noise(k, of) as f32;
    let mut c = Collider::new(shape, [0.0; 3]);
    if !k.is_multiple_of(3) {
        c.center = [0.1 * n(0), 0.1 * n(1), 0.1 * n(2)];
        let q = [n(3), n(4), n(5), n(6)];
        let norm = q.iter().map(|x| x * x).sum::<f32>().sqrt();
        c.rotation = q.map(|x| x / norm);
    }
    if k % 3 > 1 {
        (c.velocity, c.spin) = ([2.0 * n(7), n(8), n(9)], [5.0 * n(10), n(11), n(12)]);
    }
    c.friction = if k.is_multiple_of(2) { 0.4 } else { 0.0 };
    c
}

/// Particles in and around the middle of the world that have come a way \[m\] of this size, some of them from where they
/// are, some in the very middle or on an axis, some pinned.
fn sheet<T: Real>(way: f64, seed: usize) -> Sheet<T> {
    let mut sheet = Sheet::new(&Grid { name: String::new(), first: 0, width: 37, height: 21 });
    for k in 0..37 * 21 {
        let on = |c: usize| f64::from(u8::from(!(k % 11 == 1 && k % 3 != c) && k % 53 != 7));
        let p = [0, 1, 2].map(|c| 0.45 * on(c) * noise(k + 1000 * seed, c));
        let moves = f64::from(u8::from(k % 5 > 0));
        let b = [0, 1, 2].map(|c| p[c] + moves * way * noise(k + 1000 * seed, 3 + c));
        let place = sheet.triple(k);
        for c in 0..3 {
            let sign = if k % 22 == 1 && p[c] == 0.0 { -0.0 } else { p[c] };
            sheet.now[place + 2 * c * sheet.half] = T::of(sign);
            sheet.before[place + 2 * c * sheet.half] = T::of(b[c]);
        }
    }
    sheet.weigh(|k| T::of(if k % 17 == 3 { 0.0 } else { 2.0 }));
    sheet
}

fn run<T: Real>(
    threads: &Threads,
    sheet: &mut Sheet<T>,
    clear: &mut Clear<T>,
    solids: &[Solid<T>],
    (dt, left): (T, T),
) {
    super::run(threads, sheet, clear, &Posed::new(solids.iter().copied(), dt, left));
}

/// Applies the rule to every particle alone; returns how often one moved.
fn alone<T: Real>(sheet: &mut Sheet<T>, solids: &[Solid<T>], dt: T) -> usize {
    let (half, mut moved) = (sheet.half, 0);
    for k in 0..sheet.width * sheet.height {
        let place = sheet.triple(k);
        if sheet.w[sheet.single(k)] <= T::of(0.0) {
            continue;
        }
        let was = [0, 1, 2].map(|c| sheet.before[place + 2 * c * half]);
        for solid in solids {
            if let Some(out) = meet(solid, sheet.at(place), was, dt) {
                sheet.put(place, out);
                moved += 1;
            }
        }
    }
    moved
}

/// Both ways, by bits; how many particles meet something.
fn compare<T: Real + std::fmt::Debug>(solids: &[Solid<T>], way: f64, seed: usize, threads: &Threads) -> usize {
    compare_sheet(&sheet::<T>(way, seed), solids, threads)
}

fn compare_sheet<T: Real + std::fmt::Debug>(start: &Sheet<T>, solids: &[Solid<T>], threads: &Threads) -> usize {
    let dt = T::of(1.0 / 480.0);
    let (mut together, mut apart) = (start.clone(), start.clone());
    run(threads, &mut together, &mut Clear::default(), solids, (dt, T::of(0.0)));
    let moved = alone(&mut apart, solids, dt);
    for k in 0..together.width * together.height {
        let (a, b) = (together.at(together.triple(k)), apart.at(apart.triple(k)));
        let (a, b) = (bytemuck::bytes_of(&a), bytemuck::bytes_of(&b));
        assert!(a == b, "particle {k}: {solids:?}");
    }
    moved
}

#[test]
fn vectors_of_particles_meet_as_each_does_alone() {
    let threads = Threads::one();
    for (s, shape) in shapes().into_iter().enumerate() {
        for seed in 0..12 {
            let collider = collider(shape, seed);
            // Short beside the collider, some of them short, and none of them.
            for way in [1e-4, 0.03, 0.1, 2.0] {
                let solid = Solid::<f32>::new(&collider).coated(0.01 * (seed % 4) as f32);
                let moved = compare(&[solid], way, seed * 8 + s, &threads);
                assert!(moved > 40, "{shape:?}, {way}: {moved} of 777 meet it");
                compare(&[Solid::<f64>::new(&collider)], way, seed * 8 + s, &threads);
            }
        }
    }
}

/// Of particles that meet a collider the number that friction moves, and how deep the deepest one is inside afterwards, as a share of a metre
/// or of its largest coordinate.
fn slide<T: Real>(collider: &Collider, way: f64, seed: usize) -> (usize, f64) {
    let (solid, sheet, dt) = (Solid::<T>::new(collider), sheet::<T>(way, seed), T::of(1.0 / 480.0));
    let smooth = Solid { friction: T::of(0.0), ..solid };
    let (mut moved, mut deepest) = (0, 0.0f64);
    for place in (0..sheet.width * sheet.height).map(|k| sheet.triple(k)) {
        let was = [0, 1, 2].map(|c| sheet.before[place + 2 * c * sheet.half]);
        let [out, without] = [&solid, &smooth].map(|solid| meet(solid, sheet.at(place), was, dt));
        let (Some(out), Some(without)) = (out, without) else { continue };
        moved += usize::from(out != without);
        let size = out.iter().chain(&was).fold(1.0, |size, x| x.get().abs().max(size));
        deepest = deepest.max(solid.exit(out).map_or(0.0, |exit| exit.depth.get() / size));
    }
    (moved, deepest)
}

#[test]
fn friction_moves_no_particle_into_a_collider() {
    for (s, shape) in shapes().into_iter().enumerate() {
        let mut moved = 0;
        for seed in 0..24 {
            let collider = Collider { friction: [0.4, 3.0][seed / 3 % 2], ..collider(shape, seed) };
            for way in [1e-4, 0.03, 0.3, 2.0] {
                let single = slide::<f32>(&collider, way, 8 * seed + s);
                let double = slide::<f64>(&collider, way, 8 * seed + s);
                assert!(single.1 < 1e-5, "{collider:?}, {way}: {:e}", single.1);
                assert!(double.1 < 2e-14, "{collider:?}, {way}: {:e}", double.1);
                moved += double.0;
            }
        }
        assert!(moved > 5_000, "{shape:?}: {moved}");
    }
}

/// Rows of particles that lie on a solid, all of a row as far above or below its surface, and come by a way \[m\] from there.
fn rows_on<T: Real>(solid: &Solid<T>, way: f64, seed: usize) -> Sheet<T> {
    let depths = [-1e-2, -1e-3, -1e-5, -1e-6, -1e-7, 0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2];
    let mut sheet = sheet::<T>(0.0, seed);
    for k in 0..sheet.width * sheet.height {
        let inside = [0, 1, 2].map(|c| solid.center[c] + T::of(0.1 * noise(k + 1000 * seed, c)));
        let Some(Exit { at, normal, .. }) = solid.exit(inside) else { continue };
        let p = add(at, scale(normal, T::of(depths[k / sheet.width % depths.len()])));
        let place = sheet.triple(k);
        sheet.put(place, p);
        for (c, x) in p.into_iter().enumerate() {
            sheet.before[place + 2 * c * sheet.half] = x + T::of(way * noise(k, 7 + c));
        }
    }
    sheet
}

#[test]
fn vectors_at_the_very_surface_of_a_capsule_are_not_taken_for_far() {
    let threads = Threads::one();
    for seed in 0..36 {
        let capsule = collider(shapes()[2], seed);
        let (solid, wide) = (Solid::<f32>::new(&capsule), Solid::<f64>::new(&capsule));
        let mut moved = 0;
        for way in [0.0, 1e-6, 1e-3, 0.05] {
            moved += compare_sheet(&rows_on(&solid, way, seed), &[solid], &threads);
            compare_sheet(&rows_on(&wide, way, seed), &[wide], &threads);
        }
        assert!(moved > 100, "{moved}");
    }
}

#[test]
fn they_meet_one_collider_after_the_other() {
    for seed in 0..6 {
        let all: Vec<_> = (0..20).map(|n| collider(shapes()[n % 10], n + 20 * seed)).collect();
        for way in [1e-3, 0.1] {
            let solids: Vec<Solid<f32>> = all.iter().map(Solid::new).collect();
            compare(&solids, way, seed, &Threads::one());
            compare(&solids, way, seed, &Threads::new(3).unwrap());
        }
    }
}

#[test]
fn what_is_no_number_is_left_to_the_rule_and_spoils_no_other() {
    let one = [Solid::<f32>::new(&collider(shapes()[1], 0))];
    // Enough that those far from a vector of particles are told apart together.
    let many: Vec<_> = (0..20).map(|n| Solid::<f32>::new(&collider(shapes()[1 + n % 9], n))).collect();
    for solids in [&one[..], &many] {
        let [mut with, mut without, mut apart] = [(); 3].map(|()| sheet::<f32>(0.01, 0));
        let bad = [4, 40, 200, 202, 500].map(|k| with.triple(k));
        for sheet in [&mut with, &mut apart] {
            let numbers = [f32::NAN, f32::INFINITY, 3e38, -f32::NAN, 1e30];
            bad.into_iter().zip(numbers).for_each(|(at, x)| sheet.now[at] = x);
        }
        let start = with.clone();
        run(&Threads::one(), &mut with, &mut Clear::default(), solids, (0.01, 0.0));
        run(&Threads::one(), &mut without, &mut Clear::default(), solids, (0.01, 0.0));
        alone(&mut apart, solids, 0.01);
        let same = |a: V3<f32>, b: V3<f32>| {
            (0..3).all(|c| a[c].to_bits() == b[c].to_bits() || (a[c].is_nan() && b[c].is_nan()))
        };
        for k in 0..37 * 21 {
            let place = with.triple(k);
            let p = with.at(place);
            // A NaN is not near by itself, but in a vector with near particles it meets what they meet.
            let stays = start.at(place);
            let as_ruled = same(p, apart.at(place)) || same(p, stays);
            let fine = if bad.contains(&place) { as_ruled } else { same(p, without.at(place)) };
            assert!(fine, "{k}: {p:?}");
        }
    }
}

/// Particles over two metres, in a grid, so that most are far from a collider.
fn wide_sheet() -> Sheet<f32> {
    let mut sheet = Sheet::new(&Grid { name: String::new(), first: 0, width: 70, height: 20 });
    for k in 0..70 * 20 {
        let place = sheet.triple(k);
        sheet.put(place, [0.03 * (k % 70) as f32 - 1.0, 0.1 * noise(k, 0) as f32, 0.03 * (k / 70) as f32 - 0.3]);
    }
    sheet.before = sheet.now.clone();
    sheet.weigh(|k| if k % 17 == 3 { 0.0 } else { 2.0 });
    sheet
}

#[test]
fn distances_that_are_carried_from_step_to_step_leave_nothing_out() {
    let (threads, dt) = (Threads::one(), 1.0f32 / 480.0);
    let (mut skipped, mut given_up) = (0, 0);
    for (seed, shape) in (0..24).flat_map(|seed| shapes().map(|shape| (seed, shape))) {
        // Steps of a frame, in which cloth and colliders go some way, and a collider may come from outside of the sheet's reach.
        let mut colliders = vec![collider(shape, seed), collider(Shape::Sphere { radius: 0.2 }, seed + 1)];
        colliders[1].center = [0.0, 1.2, 0.0];
        colliders[1].velocity = [0.0, -20.0, 0.0];
        // Colliders that all particles are near: lists of them do not pay.
        let floors = if seed % 2 == 0 { 8 } else { 0 };
        colliders.extend((0..floors).map(|n| Collider::new(Shape::HalfSpace, [0.0, -0.01 * n as f32, 0.0])));
        let solids: Vec<_> = colliders.iter().map(Solid::<f32>::new).collect();
        let (mut carried, mut fresh) = (wide_sheet(), wide_sheet());
        let mut clear = Clear::default();
        for n in 0..24 {
            let left = (23 - n) as f32 * dt;
            let posed: Vec<_> = solids.iter().map(|s| s.posed(left)).collect();
            for sheet in [&mut carried, &mut fresh] {
                for k in 0..sheet.width * sheet.height {
                    let (place, most) = (sheet.triple(k), if seed % 3 == 0 { 0.5 } else { 0.012 });
                    let pace = most * noise(seed, 5) as f32;
                    let at = sheet.at(place);
                    if sheet.w[sheet.single(k)] > 0.0 {
                        let step = [0, 1, 2].map(|c| pace * noise(k + n, 7 + c) as f32);
                        (0..3).for_each(|c| sheet.before[place + 2 * c * sheet.half] = at[c]);
                        sheet.put(place, add(at, step));
                    }
                }
            }
            run(&threads, &mut carried, &mut clear, &posed, (dt, left));
            if clear.pays() {
                skipped += clear.parts().0.iter().filter(|block| block.listed == 0).count();
            } else {
                given_up += 1;
            }
            run(&threads, &mut fresh, &mut Clear::default(), &posed, (dt, 0.0));
            assert!(carried.now[..] == fresh.now[..], "{shape:?} {seed}, step {n}");
        }
    }
    assert!(skipped > 10_000 && given_up > 100, "{skipped}, {given_up}");
}

#[test]
fn lists_of_many_colliders_leave_out_none_that_a_particle_meets() {
    let (dt, steps) = (1.0f32 / 960.0, 16);
    for (seed, count) in [48, 1, 3, 64, 65, 100, 48, 140].into_iter().enumerate() {
        let of = |n: usize| {
            let mut c = collider(Shape::Capsule { half_height: 0.1, radius: 0.04 }, 3 * n + 2 + seed);
            c.center = [noise(n, 20 + seed) as f32, 0.2 * noise(n, 40) as f32, 0.4 * noise(n, 60) as f32];
            Solid::<f32>::new(&c)
        };
        let solids: Vec<_> = (0..count).map(of).collect();
        let (mut sheet, mut clear) = (wide_sheet(), Clear::default());
        let (mut moved, mut listed, mut all) = (0, 0, 0);
        for frame in 0..3 {
            clear.begin();
            for n in 0..steps {
                let left = (steps - 1 - n) as f32 * dt;
                let posed: Vec<_> = solids.iter().map(|s| s.posed(left)).collect();
                for k in (0..sheet.width * sheet.height).filter(|k| k % 17 != 3) {
                    // Towards the middle, so that colliders are met on and on; some particles much faster.
                    let (place, most) = (sheet.triple(k), if k % 97 == 0 { 0.02 } else { 0.0015 });
                    let at = sheet.at(place);
                    let by = [0, 1, 2].map(|c| most * noise(k + 31 * (n + frame), 7 + c) as f32);
                    (0..3).for_each(|c| sheet.before[place + 2 * c * sheet.half] = at[c]);
                    sheet.put(place, add(add(at, by), [0.0, -0.01 * at[1], 0.0]));
                }
                let mut apart = sheet.clone();
                run(&Threads::one(), &mut sheet, &mut clear, &posed, (dt, left));
                moved += alone(&mut apart, &posed, dt);
                assert!(sheet.now[..] == apart.now[..], "{count} colliders, frame {frame}, step {n}");
                let blocks = clear.parts().0;
                listed += blocks.iter().map(|block| block.listed.count_ones() as usize).sum::<usize>();
                all += blocks.len() * count.min(64);
            }
        }
        assert!(moved > 10 && listed * 2 < all, "{count}: {moved}, {listed} of {all}");
    }
}
