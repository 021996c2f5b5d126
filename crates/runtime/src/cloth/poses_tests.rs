use nalgebra::{DualQuaternion, Isometry3, Matrix3, Point3, Translation3, UnitDualQuaternion, UnitQuaternion, Vector3};

use super::*;

/// Numbers of -1 to 1 by a rule.
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

fn rigid(next: &mut impl FnMut() -> f64) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(next(), next(), next()) * 1.5);
    Isometry3::from_parts(Translation3::new(next(), next(), next()), turn)
}

fn rows(linear: &Matrix3<f64>, shift: &Vector3<f64>) -> Rows {
    [0, 1, 2].map(|r| [linear[(r, 0)], linear[(r, 1)], linear[(r, 2)], shift[r]].map(|x| x as f32))
}

fn rows_of(motion: &Isometry3<f64>) -> Rows {
    rows(motion.rotation.to_rotation_matrix().matrix(), &motion.translation.vector)
}

fn gap(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}

fn influence(weights: [f32; 4]) -> [Influence; 1] {
    [Influence { joints: [0, 1, 2, 3], weights }]
}

#[test]
fn rigid_motions_blend_as_dual_quaternions_of_nalgebra() {
    let mut next = numbers(7);
    for _ in 0..300 {
        let motions: Vec<Isometry3<f64>> = (0..4).map(|_| rigid(&mut next)).collect();
        let parts: Vec<f64> = (0..4).map(|_| next().abs() + 0.05).collect();
        let weights: [f32; 4] = std::array::from_fn(|k| (parts[k] / parts.iter().sum::<f64>()) as f32);
        let p = [next(), next(), next()];
        // The sum of the dual quaternions, each on the side of the sum so far.
        let mut sum = DualQuaternion::from_real_and_dual(
            nalgebra::Quaternion::new(0.0, 0.0, 0.0, 0.0),
            nalgebra::Quaternion::new(0.0, 0.0, 0.0, 0.0),
        );
        for (motion, weight) in motions.iter().zip(weights) {
            let one = UnitDualQuaternion::from_isometry(motion).into_inner();
            let sign = if sum.real.coords.dot(&one.real.coords) < 0.0 { -1.0 } else { 1.0 };
            sum += one * (f64::from(weight) * sign);
        }
        // A sum of unit dual quaternions has a length with a dual part, along which nothing moves.
        let length = sum.real.norm();
        let (real, dual) = (sum.real / length, sum.dual / length);
        let shift = (dual * real.conjugate()).imag() * 2.0;
        let turned = UnitQuaternion::new_unchecked(real) * Point3::from(p);
        let want: [f64; 3] = (turned + shift).coords.into();
        let matrices: Vec<Rows> = motions.iter().map(rows_of).collect();
        let found = Poses::<f64>::new(Skinning::DualQuaternion, &matrices).place(&influence(weights), p);
        assert!(gap(found, want) < 1e-6, "{found:?} {want:?}");
        let single =
            Poses::<f32>::new(Skinning::DualQuaternion, &matrices).place(&influence(weights), p.map(|x| x as f32));
        assert!(gap(single.map(f64::from), want) < 1e-5, "{single:?} {want:?}");
    }
}

#[test]
fn one_joint_moves_points_as_its_matrix_whatever_that_is() {
    let mut next = numbers(11);
    for n in 0..400 {
        let mut linear = Matrix3::from_fn(|_, _| next());
        match n % 8 {
            // Mirrored, flat, a line, a point, even, tiny and large.
            1 => linear.column_mut(0).neg_mut(),
            2 => linear.set_column(2, &(linear.column(0) * 2.0)),
            3 => (1..3).for_each(|c| linear.set_column(c, &(linear.column(0) * c as f64))),
            4 => linear.fill(0.0),
            5 => linear = *rigid(&mut next).rotation.to_rotation_matrix().matrix() * 3.0,
            6 => linear *= 1e-5,
            7 => linear *= 1e5,
            _ => {}
        }
        let shift = Vector3::new(next(), next(), next());
        let matrix = rows(&linear, &shift);
        let (p, v) = ([next(), next(), next()], [next(), next(), next()]);
        let weights = influence([1.0, 0.0, 0.0, 0.0]);
        let want = Poses::<f64>::new(Skinning::Linear, &[matrix]);
        let found = Poses::<f64>::new(Skinning::DualQuaternion, &[matrix]);
        let size = linear.norm() + 1.0;
        let (a, b) = (want.place(&weights, p), found.place(&weights, p));
        assert!(gap(a, b) < 1e-7 * size, "case {n}: {a:?} {b:?} by {linear}");
        let one = || std::iter::once((0, 1.0));
        let (a, b) = (want.blend(one()).turn(v), found.blend(one()).turn(v));
        assert!(gap(a, b) < 1e-7 * size, "case {n}: {a:?} {b:?} by {linear}");
    }
}

#[test]
fn a_limb_that_twists_by_half_a_turn_keeps_its_volume() {
    // Two joints along x, the second one turned about it.
    for degrees in [90.0f32, 179.0, 180.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let still = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let turned = [[1.0, 0.0, 0.0, 0.0], [0.0, cos, -sin, 0.0], [0.0, sin, cos, 0.0]];
        let radius = |skinning, share: f32| {
            let poses = Poses::<f32>::new(skinning, &[still, turned]);
            let round = (0..16).map(|k| k as f32 / 16.0 * std::f32::consts::TAU);
            let places = round.map(|angle| {
                let p = [0.3, 0.1 * angle.cos(), 0.1 * angle.sin()];
                poses.place(&influence([1.0 - share, share, 0.0, 0.0]), p)
            });
            places.map(|p| (p[1] * p[1] + p[2] * p[2]).sqrt()).fold(0.0, f32::max)
        };
        for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
            assert!((radius(Skinning::DualQuaternion, share) - 0.1).abs() < 1e-6);
        }
        if degrees == 180.0 {
            assert!(radius(Skinning::Linear, 0.5) < 1e-6);
        }
    }
}

#[test]
fn stretches_are_blended_linearly_and_apart() {
    // One joint doubles, one rests: half of each is one and a half.
    let still: Rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let double: Rows = [[2.0, 0.0, 0.0, 0.4], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]];
    let weights = influence([0.5, 0.5, 0.0, 0.0]);
    for skinning in [Skinning::Linear, Skinning::DualQuaternion] {
        let found = Poses::<f64>::new(skinning, &[still, double]).place(&weights, [1.0, 2.0, 3.0]);
        assert!(gap(found, [1.7, 3.0, 4.5]) < 1e-7, "{skinning:?}: {found:?}");
    }
}
