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

    /// A walking person in A-pose with a chest, calves, feet, hands and a head.
    pub fn person() -> Self {
        let mut body = Self::trunk();
        for s in [1.0, -1.0] {
            body.parts.extend(Self::leg(s).parts);
            body.parts.extend(Self::arm(s).parts);
        }
        body
    }

    /// The person without arms and legs.
    pub fn trunk() -> Self {
        let mut parts = trunk();
        // A thinner neck, the skull, the jaw and the nose.
        parts.pop();
        parts.extend([
            cone([0.0, 1.40, -0.012], [0.0, 1.58, 0.008], 0.060, 0.047),
            ellipsoid([0.0, 1.655, 0.010], [0.081, 0.113, 0.100]),
            cone([0.0, 1.612, 0.030], [0.0, 1.580, 0.062], 0.057, 0.031),
            cone([0.0, 1.665, 0.098], [0.0, 1.632, 0.112], 0.010, 0.012),
        ]);
        for s in [1.0, -1.0] {
            parts.push(ellipsoid([s * 0.072, 1.265, 0.072], [0.062, 0.066, 0.052]));
            parts.push(ellipsoid([s * 0.078, 0.905, -0.072], [0.086, 0.095, 0.070]));
        }
        Self { parts }
    }

    /// An arm of the person with its hand, on the side of this sign of x.
    pub fn arm(s: f64) -> Self {
        let shoulder = [s * SHOULDER[0], SHOULDER[1], SHOULDER[2]];
        let along = |t: f64, z: f64| add(shoulder, [s * ARM[0] * t, ARM[1] * t, z]);
        let parts = vec![
            cone(along(0.0, 0.0), along(0.28, 0.0), 0.056, 0.041),
            cone(along(0.28, 0.0), along(0.36, 0.0), 0.042, 0.042),
            cone(along(0.36, 0.0), along(0.52, 0.0), 0.042, 0.027),
            // Palm, fingers and thumb.
            cone(along(0.53, -0.007), along(0.61, -0.010), 0.029, 0.027),
            cone(along(0.53, 0.007), along(0.61, 0.010), 0.029, 0.027),
            cone(along(0.61, 0.0), along(0.685, 0.0), 0.028, 0.021),
            cone(along(0.555, 0.018), along(0.600, 0.040), 0.021, 0.016),
        ];
        Self { parts }
    }

    /// A leg of the person with its foot, on the side of this sign of x.
    pub fn leg(s: f64) -> Self {
        let at = |x: f64, y: f64, z: f64| [s * x, y, z];
        let mut parts = leg(s);
        parts.extend([
            cone(at(0.116, 0.40, -0.014), at(0.122, 0.26, -0.018), 0.052, 0.040),
            // Heel, ball of the foot and toes.
            cone(at(0.130, 0.048, -0.035), at(0.142, 0.042, 0.090), 0.043, 0.040),
            cone(at(0.142, 0.040, 0.090), at(0.144, 0.032, 0.150), 0.038, 0.028),
        ]);
        Self { parts }
    }

    /// The person with a cone in place of a stride, over which a skirt is draped.
    pub fn person_on_stand() -> Self {
        let mut body = Self::person();
        body.parts.push(Part::Cone { a: [0.0, 0.85, 0.0], b: [0.0, 0.35, 0.0], ra: 0.13, rb: 0.17 });
        body
    }

    fn without_arms() -> Self {
        let mut parts = trunk();
        [-1.0, 1.0].into_iter().for_each(|s| parts.extend(leg(s)));
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

fn ellipsoid(centre: V3, radii: V3) -> Part {
    Part::Ellipsoid { centre, radii }
}

fn cone(a: V3, b: V3, ra: f64, rb: f64) -> Part {
    Part::Cone { a, b, ra, rb }
}

/// Hips, waist, ribs, shoulders and neck.
fn trunk() -> Vec<Part> {
    vec![
        ellipsoid([0.0, 0.93, -0.01], [0.175, 0.15, 0.125]),
        ellipsoid([0.0, 1.10, 0.0], [0.137, 0.20, 0.100]),
        ellipsoid([0.0, 1.28, 0.005], [0.162, 0.18, 0.118]),
        cone([-0.135, 1.405, 0.0], [0.135, 1.405, 0.0], 0.058, 0.058),
        cone([0.0, 1.40, -0.01], [0.0, 1.60, 0.015], 0.066, 0.056),
    ]
}

/// Thigh and shin on the side of this sign of x.
fn leg(s: f64) -> Vec<Part> {
    vec![
        cone([s * 0.092, 0.88, 0.0], [s * 0.112, 0.48, 0.01], 0.082, 0.054),
        cone([s * 0.112, 0.48, 0.01], [s * 0.13, 0.05, -0.01], 0.054, 0.042),
    ]
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
