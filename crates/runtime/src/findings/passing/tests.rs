use super::*;
use crate::collider::{Collider, Shape};

/// -1 to 1, the same for the same number.
fn noise(k: usize) -> f64 {
    let mut x = (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 31)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^= x >> 29;
    (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn solids(count: usize, seed: usize) -> Vec<Solid<f32>> {
    let shapes = [
        Shape::Capsule { half_height: 0.2, radius: 0.05 },
        Shape::Sphere { radius: 0.1 },
        Shape::Box { half: [0.1, 0.05, 0.2] },
        Shape::HalfSpace,
        Shape::Ellipsoid { radii: [0.1, 0.2, 0.07], closest: true },
        Shape::TaperedCapsule { half_height: 0.2, radii: [0.08, 0.04] },
    ];
    let of = |n: usize| {
        let x = |k: usize| noise(seed * 100_000 + n * 100 + k) as f32;
        let mut c = Collider::new(shapes[n % 6], [x(0), x(1), x(2)]);
        let q = [x(3), x(4), x(5), x(6)];
        let norm = q.iter().map(|x| x * x).sum::<f32>().sqrt();
        c.rotation = q.map(|x| x / norm);
        if !n.is_multiple_of(3) {
            (c.velocity, c.spin) = ([3.0 * x(7), x(8), x(9)], [8.0 * x(10), 5.0 * x(11), x(12)]);
        }
        Solid::new(&c)
    };
    (0..count).map(of).collect()
}

/// Every particle with every collider.
fn one_by_one(solids: &[Solid<f32>], now: &[[f32; 4]], was: &[[f32; 4]], frame: f32) -> Vec<Passing> {
    let each = solids.iter().enumerate().filter_map(|(collider, solid)| {
        let core = Core::new(collider, solid)?;
        let through = |k: &usize| now[*k][3] > 0.0 && core.passed(xyz(was[*k]), xyz(now[*k]), frame);
        let all: Vec<usize> = (0..now.len()).filter(through).collect();
        Some(Passing { collider, particles: all.len(), particle: *all.first()? })
    });
    each.collect()
}

#[test]
fn groups_and_vectors_leave_out_no_particle_that_passed() {
    let frame = 1.0 / 60.0;
    let mut found = 0;
    for seed in 0..40 {
        let solids = solids([1, 5, 16, 17, 48][seed % 5], seed);
        // Groups that are small and fly far, and wide ones that hardly move.
        let (wide, way) = [(0.02, 0.5), (0.2, 0.1), (0.5, 0.02), (0.01, 0.01)][seed % 4];
        let all = (0..1003).map(|k| {
            let x = |n: usize| noise(seed * 1_000_003 + k * 16 + n);
            let middle = |c: usize| noise(seed * 7919 + k / 24 * 3 + c);
            let was = [0, 1, 2].map(|c| (middle(c) + wide * x(c)) as f32);
            let now = [0, 1, 2].map(|c| was[c] + (way * x(3 + c)) as f32);
            let w = if k % 13 == 5 { 0.0 } else { 2.0 };
            let bad = if k % 101 == 7 { f32::NAN } else { 1.0 };
            ([now[0] * bad, now[1], now[2], w], [was[0], was[1], was[2], w])
        });
        let (now, was): (Vec<_>, Vec<_>) = all.unzip();
        let want = one_by_one(&solids, &now, &was, frame as f32);
        assert_eq!(search(&solids, &now, &was, frame), want, "{seed}");
        found += want.iter().map(|p| p.particles).sum::<usize>();
    }
    assert!(found > 100, "{found}");
}

#[test]
fn no_particle_and_no_collider_pass_nothing() {
    assert_eq!(search::<f32>(&[], &[[0.0; 4]; 3], &[[0.0; 4]; 3], 0.1), []);
    assert_eq!(search::<f32>(&solids(3, 0), &[], &[], 0.1), []);
}
