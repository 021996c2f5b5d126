//! The skeleton of the figure, and the joints that each point of its surface follows.

use crate::body::{ARM, Body, SHOULDER};
use crate::figure::nets::on_surface;
use crate::glb::Joint;
use crate::math::{V3, add, dot, scale, smoothstep, sub};

/// Indices of joints; those of the right side follow the left ones.
pub const HIPS: usize = 0;
/// The lower back.
pub const SPINE: usize = 1;
/// The ribs.
pub const CHEST: usize = 2;
/// The neck.
pub const NECK: usize = 3;
/// The head.
pub const HEAD: usize = 4;
/// The collar bones: left, right.
pub const SHOULDERS: [usize; 2] = [5, 6];
/// The upper arms.
pub const UPPER_ARMS: [usize; 2] = [7, 8];
/// The forearms.
pub const FOREARMS: [usize; 2] = [9, 10];
/// The hands.
pub const HANDS: [usize; 2] = [11, 12];
/// The thighs.
pub const THIGHS: [usize; 2] = [13, 14];
/// The shins.
pub const SHINS: [usize; 2] = [15, 16];
/// The feet.
pub const FEET: [usize; 2] = [17, 18];
/// Number of joints.
pub const COUNT: usize = 19;

/// Lengths \[m\] along the arm of the elbow and the wrist.
const ELBOW: f64 = 0.28;
const WRIST: f64 = 0.52;

/// Left and right: signs of x.
pub const SIDES: [f64; 2] = [1.0, -1.0];

/// The joints, parents first.
pub fn joints() -> Vec<Joint> {
    const NAMES: [[&str; 2]; 7] = [
        ["shoulder.L", "shoulder.R"],
        ["upper_arm.L", "upper_arm.R"],
        ["forearm.L", "forearm.R"],
        ["hand.L", "hand.R"],
        ["thigh.L", "thigh.R"],
        ["shin.L", "shin.R"],
        ["foot.L", "foot.R"],
    ];
    let joint = |name, parent, at: V3| Joint { name, parent, at: at.map(|c| ((c * 1e5).round() / 1e5) as f32) };
    let mut out = vec![
        joint("hips", None, [0.0, 0.95, 0.0]),
        joint("spine", Some(HIPS), [0.0, 1.06, 0.0]),
        joint("chest", Some(SPINE), [0.0, 1.22, 0.0]),
        joint("neck", Some(CHEST), [0.0, 1.45, -0.005]),
        joint("head", Some(NECK), [0.0, 1.575, 0.010]),
    ];
    let arm = |t: f64| add(SHOULDER, scale(ARM, t));
    let rows = [
        (CHEST, [0.03, 1.42, 0.0]),
        (SHOULDERS[0], SHOULDER),
        (UPPER_ARMS[0], arm(ELBOW)),
        (FOREARMS[0], arm(WRIST)),
        (HIPS, [0.092, 0.88, 0.0]),
        (THIGHS[0], [0.112, 0.48, 0.01]),
        (SHINS[0], [0.13, 0.075, -0.01]),
    ];
    for ((parent, at), names) in rows.into_iter().zip(NAMES) {
        for (k, side) in SIDES.into_iter().enumerate() {
            let above = if parent > HEAD { parent + k } else { parent };
            out.push(joint(names[k], Some(above), [side * at[0], at[1], at[2]]));
        }
    }
    out
}

/// The figure without arms and without legs, and each of those alone: where a limb is nearer than the trunk, its joints rule.
pub struct Rig {
    body: Body,
    trunk: Body,
    arms: [Body; 2],
    legs: [Body; 2],
}

impl Rig {
    /// The rig of [`Body::person`].
    pub fn new() -> Self {
        Rig { body: Body::person(), trunk: Body::trunk(), arms: SIDES.map(Body::arm), legs: SIDES.map(Body::leg) }
    }

    /// Weights of all joints at the point of the surface that is nearest to `p`, of sum 1.
    pub fn weights(&self, p: V3) -> [f64; COUNT] {
        let p = on_surface(&self.body, p);
        let mut w = [0.0; COUNT];
        let trunk = self.trunk.distance(p);
        let arms = [0, 1].map(|k| {
            let beside = smoothstep(0.10, 0.19, SIDES[k] * p[0]);
            beside * smoothstep(-0.045, 0.035, trunk - self.arms[k].distance(p))
        });
        let legs = [0, 1].map(|k| {
            let own = smoothstep(-0.03, 0.03, SIDES[k] * p[0]);
            own * (1.0 - arms[k])
                * smoothstep(0.97, 0.82, p[1])
                * smoothstep(-0.10, 0.02, trunk - self.legs[k].distance(p))
        });
        let rest = (1.0 - arms[0] - arms[1] - legs[0] - legs[1]).max(0.0);
        trunk_weights(p, rest, &mut w);
        for k in 0..2 {
            let t = dot(sub(p, SHOULDER_OF[k]), [SIDES[k] * ARM[0], ARM[1], 0.0]);
            let shares = [smoothstep(ELBOW - 0.05, ELBOW + 0.05, t), smoothstep(WRIST - 0.03, WRIST + 0.03, t)];
            chain(&mut w, [UPPER_ARMS[k], FOREARMS[k], HANDS[k]], arms[k], shares);
            let shares = [smoothstep(0.55, 0.41, p[1]), smoothstep(0.12, 0.055, p[1])];
            chain(&mut w, [THIGHS[k], SHINS[k], FEET[k]], legs[k], shares);
        }
        let sum: f64 = w.iter().sum();
        w.map(|x| x / sum)
    }
}

const SHOULDER_OF: [V3; 2] = [SHOULDER, [-SHOULDER[0], SHOULDER[1], SHOULDER[2]]];

fn trunk_weights(p: V3, rest: f64, w: &mut [f64; COUNT]) {
    let levels = [(0.97, 1.09), (1.12, 1.26), (1.43, 1.51), (1.555, 1.615)].map(|(a, b)| smoothstep(a, b, p[1]));
    let collar = [0, 1].map(|k| {
        let out = smoothstep(0.03, 0.15, SIDES[k] * p[0]);
        out * smoothstep(1.28, 1.41, p[1]) * (1.0 - levels[2])
    });
    let mut left = rest;
    for (joint, share) in [HEAD, NECK, CHEST, SPINE].into_iter().zip(levels.into_iter().rev()) {
        w[joint] = left * share;
        left -= w[joint];
    }
    w[HIPS] = left;
    for k in 0..2 {
        w[SHOULDERS[k]] = w[CHEST] * collar[k] * 0.8;
    }
    w[CHEST] -= w[SHOULDERS[0]] + w[SHOULDERS[1]];
}

/// Divides the weight of a limb among its three joints.
fn chain(w: &mut [f64; COUNT], joints: [usize; 3], all: f64, [second, third]: [f64; 2]) {
    w[joints[2]] = all * third;
    w[joints[1]] = (all - w[joints[2]]) * second;
    w[joints[0]] = all - w[joints[2]] - w[joints[1]];
}

/// The four largest weights as bytes of sum 255, and their joints.
pub fn four(w: &[f64; COUNT]) -> ([u8; 4], [u8; 4]) {
    let mut order: Vec<usize> = (0..COUNT).collect();
    order.sort_by(|&a, &b| w[b].total_cmp(&w[a]).then(a.cmp(&b)));
    let total: f64 = order[..4].iter().map(|&j| w[j]).sum();
    let mut bytes = [0, 1, 2, 3].map(|k| (255.0 * w[order[k]] / total).round() as i32);
    bytes[0] += 255 - bytes.iter().sum::<i32>();
    // A joint without a weight is joint 0, as glTF asks.
    let joints = [0, 1, 2, 3].map(|k| if bytes[k] > 0 { order[k] as u8 } else { 0 });
    (joints, bytes.map(|b| b as u8))
}
