//! Solids that end where their samples do. The free end of a capsule costs nothing where no sample tells where it is, and may be thousands of kilometres away.

use nalgebra::Vector3;

use super::samples::Sample;
use super::solid::{Form, Solid};
use crate::base::vec3::{distance, dot, sub};

/// The solid, cut to its samples if it is larger than the box around all of them. O(n).
pub(super) fn bounded(solid: Solid, joint: Option<u32>, samples: &[Sample]) -> Solid {
    let box_of = |c: usize| {
        let each = || samples.iter().map(move |s| s.point[c]);
        [each().fold(f64::INFINITY, f64::min), each().fold(f64::NEG_INFINITY, f64::max)]
    };
    let [x, y, z] = [0, 1, 2].map(box_of);
    let size = distance([x[0], y[0], z[0]], [x[1], y[1], z[1]]);
    if !size.is_finite() || largest(&solid.form) <= size {
        return solid;
    }
    let axis: [f64; 3] = (solid.turn() * Vector3::y()).into();
    let along = samples.iter().filter(|s| s.joint == joint).map(|s| dot(sub(s.point, solid.center), axis));
    let [low, high] = along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], t| [low.min(t), high.max(t)]);
    let cut = |half: f64| if low <= high { [low.clamp(-half, half), high.clamp(-half, half)] } else { [0.0; 2] };
    let (form, middle) = match solid.form {
        Form::Capsule { half_height, radius } => {
            let [low, high] = cut(half_height);
            (Form::Capsule { half_height: (high - low) / 2.0, radius: radius.min(size) }, (low + high) / 2.0)
        }
        Form::TaperedCapsule { half_height, radii: [a, b] } => {
            let [low, high] = cut(half_height);
            let radius = |t: f64| (a + (b - a) * (t + half_height) / (2.0 * half_height)).min(size);
            let radii = [radius(low), radius(high)];
            let least = 1.01 * (radii[0] - radii[1]).abs() / 2.0;
            (Form::TaperedCapsule { half_height: ((high - low) / 2.0).max(least), radii }, (low + high) / 2.0)
        }
        Form::Sphere { radius } => (Form::Sphere { radius: radius.min(size) }, 0.0),
        Form::Box { half } => (Form::Box { half: half.map(|h| h.min(size)) }, 0.0),
        Form::Ellipsoid { radii } => (Form::Ellipsoid { radii: radii.map(|r| r.min(size)) }, 0.0),
    };
    Solid { form, center: [0, 1, 2].map(|c| solid.center[c] + middle * axis[c]), ..solid }
}

/// The largest of its numbers \[m\].
fn largest(form: &Form) -> f64 {
    match *form {
        Form::Sphere { radius } => radius,
        Form::Capsule { half_height, radius } => half_height.max(radius),
        Form::TaperedCapsule { half_height, radii: [a, b] } => half_height.max(a).max(b),
        Form::Box { half: [a, b, c] } | Form::Ellipsoid { radii: [a, b, c] } => a.max(b).max(c),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_capsule_whose_end_no_sample_knows_is_cut_to_its_samples() {
        let samples: Vec<Sample> = (0..30).map(|k| Sample::on([0.1, 0.02 * f64::from(k), 0.0], Some(3))).collect();
        // From 0 to 2,000 km along y.
        let long = |form| Solid { form, center: [0.0, 1e6, 0.0], rotation: [0.0, 0.0, 0.0, 1.0] };
        let capsule = long(Form::Capsule { half_height: 1e6, radius: 0.1 });
        for solid in [capsule, long(Form::TaperedCapsule { half_height: 1e6, radii: [0.1, 0.2] })] {
            let cut = bounded(solid, Some(3), &samples);
            assert!(largest(&cut.form) < 0.6 && (cut.center[1] - 0.29).abs() < 0.01, "{cut:?}");
            assert!(samples.iter().all(|s| cut.distance(s.point).abs() < 1e-3), "{cut:?}");
        }
        let fits =
            Solid { form: Form::Capsule { half_height: 0.29, radius: 0.1 }, center: [0.0, 0.29, 0.0], ..capsule };
        assert_eq!(bounded(fits, Some(3), &samples), fits);
        assert!(largest(&bounded(capsule, None, &samples).form) < 0.6);
    }
}
