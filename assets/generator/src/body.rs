//! The figure the garments are draped over: a smooth union of ellipsoids and round cones, standing with arms lowered.

use crate::math::{V3, add, dot, norm, scale, sub, unit};

/// A solid given by its (approximate) signed distance.
pub struct Body {
    parts: Vec<Part>,
}

enum Part {
    Ellipsoid { centre: V3, radii: V3 },
    Cone { a: V3, b: V3, ra: f64, rb: f64 },
}

/// Where the arms hang from.
pub const SHOULDER: V3 = [0.165, 1.395, 0.0];
/// The direction of the left arm, 50 degrees below the horizon; the right one mirrors it.
pub const ARM: V3 = [0.642_788, -0.766_044, 0.0];

impl Body {
    /// Torso, neck, arms and legs of a figure about 1.75 m tall.
    pub fn figure() -> Self {
        let mut body = Self::without_arms();
        for s in [-1.0, 1.0] {
            let a = [s * SHOULDER[0], SHOULDER[1], SHOULDER[2]];
            let b = add(a, scale([s * ARM[0], ARM[1], ARM[2]], 0.5));
            body.parts.push(Part::Cone { a, b, ra: 0.056, rb: 0.038 });
        }
        body
    }

    /// The figure with a cone for legs, as on a dressmaker's stand, which holds skirts open.
    pub fn stand() -> Self {
        let mut body = Self::figure();
        body.parts.push(Part::Cone { a: [0.0, 0.85, 0.0], b: [0.0, 0.35, 0.0], ra: 0.11, rb: 0.15 });
        body
    }

    /// The stand with its arms close to its sides, for a cape that covers them.
    pub fn arms_down() -> Self {
        let mut body = Self::without_arms();
        body.parts.push(Part::Cone { a: [0.0, 0.85, 0.0], b: [0.0, 0.35, 0.0], ra: 0.11, rb: 0.15 });
        for s in [-1.0, 1.0] {
            let (a, b) = ([s * 0.165, 1.395, 0.0], [s * 0.26, 0.92, 0.03]);
            body.parts.push(Part::Cone { a, b, ra: 0.060, rb: 0.045 });
        }
        body
    }

    fn without_arms() -> Self {
        let ellipsoid = |y: f64, z: f64, radii: V3| Part::Ellipsoid { centre: [0.0, y, z], radii };
        let cone = |a: V3, b: V3, ra: f64, rb: f64| Part::Cone { a, b, ra, rb };
        let mut parts = vec![
            ellipsoid(0.93, -0.01, [0.175, 0.15, 0.125]),
            ellipsoid(1.10, 0.0, [0.137, 0.20, 0.100]),
            ellipsoid(1.28, 0.005, [0.162, 0.18, 0.118]),
            cone([-0.135, 1.405, 0.0], [0.135, 1.405, 0.0], 0.058, 0.058),
            cone([0.0, 1.40, -0.01], [0.0, 1.60, 0.015], 0.066, 0.056),
        ];
        for s in [-1.0, 1.0] {
            parts.push(cone([s * 0.092, 0.88, 0.0], [s * 0.112, 0.48, 0.01], 0.082, 0.054));
            parts.push(cone([s * 0.112, 0.48, 0.01], [s * 0.13, 0.05, -0.01], 0.054, 0.042));
        }
        Self { parts }
    }

    /// The signed distance of `p`, negative inside.
    pub fn distance(&self, p: V3) -> f64 {
        let mut d = f64::MAX;
        for part in &self.parts {
            let e = part.distance(p);
            // The polynomial smooth minimum; it rounds off the creases between the parts.
            let k = 0.025;
            let h = (k - (d - e).abs()).max(0.0) / k;
            d = d.min(e) - h * h * k * 0.25;
        }
        d
    }

    /// The outward direction at `p`.
    pub fn outward(&self, p: V3) -> V3 {
        let e = 1e-4;
        unit([0, 1, 2].map(|k| {
            let mut step = [0.0; 3];
            step[k] = e;
            self.distance(add(p, step)) - self.distance(sub(p, step))
        }))
    }
}

impl Part {
    fn distance(&self, p: V3) -> f64 {
        match self {
            Self::Ellipsoid { centre, radii } => {
                let q = sub(p, *centre);
                let k0 = norm([q[0] / radii[0], q[1] / radii[1], q[2] / radii[2]]);
                let r2 = radii.map(|r| r * r);
                let k1 = norm([q[0] / r2[0], q[1] / r2[1], q[2] / r2[2]]);
                if k1 > 0.0 { k0 * (k0 - 1.0) / k1 } else { -radii[2] }
            }
            Self::Cone { a, b, ra, rb } => {
                let (ab, ap) = (sub(*b, *a), sub(p, *a));
                let t = (dot(ap, ab) / dot(ab, ab)).clamp(0.0, 1.0);
                norm(sub(ap, scale(ab, t))) - (ra + t * (rb - ra))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inside_is_negative_and_outward_leaves() {
        let body = Body::figure();
        assert!(body.distance([0.0, 1.2, 0.0]) < 0.0);
        assert!(body.distance([0.5, 1.6, 0.3]) > 0.0);
        let p = [0.0, 1.2, 0.1];
        assert!(body.distance(add(p, scale(body.outward(p), 0.05))) > body.distance(p));
    }
}
