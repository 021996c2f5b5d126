//! The distance at the third corner of a triangle from those at the other two.

/// A wave from one point has come as far as `far_a` at A and `far_b` at B; the sides are `ab`, `ac` and `bc`. Returns how
/// far it has come where it reaches C straight through the side AB, or nothing where it goes past that side, or where no
/// triangle has such sides: then the way to C leads along an edge.
///
/// The point lies at the given distances on the other side of AB from C. More at A or B never gives less at C, so that
/// distances that are still too large cannot make one too small.
pub(super) fn unfold(far_a: f64, far_b: f64, ab: f64, ac: f64, bc: f64) -> Option<f64> {
    // A at the origin, B along x, C below and the source above.
    let half = 0.5 / ab;
    let (cx, sx) = ((ac * ac + ab * ab - bc * bc) * half, (far_a * far_a + ab * ab - far_b * far_b) * half);
    let (cy, sy) = (ac * ac - cx * cx, far_a * far_a - sx * sx);
    if cy.is_nan() || cy <= 0.0 || sy.is_nan() || sy < 0.0 {
        return None;
    }
    let (cy, sy) = (cy.sqrt(), sy.sqrt());
    // Where the line from the source to C crosses AB, times the whole height.
    let (height, cross) = (cy + sy, sx * cy + cx * sy);
    (cross >= 0.0 && cross <= ab * height).then(|| ((cx - sx).powi(2) + height * height).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_source_beside_the_side_does_not_reach_through_it() {
        assert_eq!(unfold(1.0, 3.0, 2.0, 1.0, 1.0), None);
        assert_eq!(unfold(10.0, 10.0, 2.0, 0.5, 0.5), None);
        assert_eq!(unfold(f64::NAN, 1.0, 1.0, 1.0, 1.0), None);
    }

    proptest! {
        #[test]
        fn the_distance_in_the_plane_is_found(
            s in (-3.0..3.0f64, 0.01..5.0f64),
            c in (-2.0..2.0f64, 0.01..2.0f64),
            ab in 0.1..2.0f64,
        ) {
            let to = |x: f64, y: f64, p: (f64, f64)| (p.0 - x).hypot(p.1 - y);
            let found = unfold(to(0.0, 0.0, s), to(ab, 0.0, s), ab, to(0.0, 0.0, c), to(ab, 0.0, c));
            let cross = s.0 + (c.0 - s.0) * s.1 / (s.1 + c.1);
            let margin = cross.min(ab - cross);
            prop_assume!(margin.abs() > 1e-6);
            prop_assert_eq!(found.is_some(), margin > 0.0);
            if let Some(d) = found {
                prop_assert!((d - to(s.0, s.1, (c.0, -c.1))).abs() < 1e-9);
            }
        }

        #[test]
        fn larger_distances_never_give_a_smaller_one(
            a in 1.0..3.0f64, b in 1.0..3.0f64, more in 0.0..0.5f64, ac in 0.5..1.5f64, bc in 0.5..1.5f64,
        ) {
            if let (Some(before), Some(after)) = (unfold(a, b, 1.0, ac, bc), unfold(a + more, b, 1.0, ac, bc)) {
                prop_assert!(after >= before - 1e-12);
            }
        }
    }
}
