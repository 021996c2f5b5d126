//! Cloth that is spanned between pins, as a canopy is by its corners.

use crate::cloth::{Cloth, of_pins};
use crate::number::real::{V3, add, cast, cross, dot, scale, sub};

/// Groups of pins that span cloth.
const GROUPS: usize = 3;
/// Distance of a group from the line through the two that are far apart, as a share of their distance, from which they are not on a line.
const ASIDE: f64 = 0.1;
/// Measured: squares of cotton (0.4, 1, 3 m), denim and rubber (1 m) hung by four corners, with 256 substeps and no tethers.
const GIVE: f64 = 0.42;

/// The distance \[m\] of the two groups of pins that are farthest apart, if three or more hold a cloth that do not lie on a line. A curtain
/// on a rail hangs straight down from its pins, and a garment on its shoulders; cloth between pins that surround it pulls at all of
/// them. Takes time linear in the particles.
pub fn span(cloth: &Cloth) -> Option<f64> {
    if super::pins(cloth) < GROUPS {
        return None;
    }
    let (group, count) = of_pins(cloth);
    if count < GROUPS {
        return None;
    }
    let mut sums = vec![([0.0; 3], 0.0); count];
    for (at, group) in cloth.positions().iter().zip(&group).filter(|(_, group)| **group != u32::MAX) {
        let (sum, number) = &mut sums[*group as usize];
        (*sum, *number) = (add(*sum, cast(*at)), *number + 1.0);
    }
    let means: Vec<V3<f64>> = sums.into_iter().map(|(sum, number)| scale(sum, 1.0 / number)).collect();
    let farthest = |from: V3<f64>| {
        let far = |a: &&V3<f64>, b: &&V3<f64>| square(sub(**a, from)).total_cmp(&square(sub(**b, from)));
        means.iter().max_by(far).copied().unwrap_or(from)
    };
    let one = farthest(means[0]);
    let way = sub(farthest(one), one);
    let aside = |at: &V3<f64>| square(cross(sub(*at, one), way));
    let is_spanned = means.iter().map(aside).fold(0.0, f64::max) > (ASIDE * square(way)).powi(2);
    is_spanned.then(|| square(way).sqrt())
}

/// How far the tethers of cloth of a material give that is spanned over `span` \[m\], as a share of their length: without it they would hold
/// flat what the fabric lets sag. 0 of cloth without a material.
///
/// A flat membrane of stiffness E \[N/m\] and weight w \[N/m^2\] over a span L is strained by a multiple of (w L / E)^(2/3) (H. Hencky, 1915, for
/// the circle). The load of a canopy goes along its threads and across them.
pub fn give(cloth: &Cloth, gravity: [f32; 3], span: f64) -> f64 {
    let Some(sheet) = cloth.membrane() else { return 0.0 };
    let [warp, weft, shear] = sheet.woven.stiffness;
    let (along, across) = (0.5 * (warp + weft), 4.0 / (1.0 / warp + 1.0 / weft + 1.0 / shear));
    let stiffness = 2.0 / (1.0 / along + 1.0 / across);
    GIVE * (sheet.woven.density * super::length(gravity.map(f64::from)) * span / stiffness).powf(2.0 / 3.0)
}

fn square(v: V3<f64>) -> f64 {
    dot(v, v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloth::Flat;

    /// A sheet of 9 x 9 with these texels pinned.
    fn pinned(texels: &[usize]) -> Cloth {
        let mut cloth = Flat::square("sheet", 9).cloth().unwrap();
        texels.iter().for_each(|k| cloth.set_pinned(*k, true).unwrap());
        cloth
    }

    #[test]
    fn corners_span_a_sheet_and_a_rail_does_not() {
        let far = span(&pinned(&[0, 8, 72, 80])).unwrap();
        assert!((far - 2f64.sqrt()).abs() < 1e-6 && span(&pinned(&[0, 8, 76])).is_some(), "{far}");
        // Two groups, two large groups, a row of groups, and a corner that is one group.
        for on_a_line in [&[0, 8][..], &[0, 1, 9, 7, 8, 17], &[0, 2, 4, 6, 8], &[0, 40, 80], &[0, 1, 10], &[]] {
            assert_eq!(span(&pinned(on_a_line)), None, "{on_a_line:?}");
        }
    }
}
