//! A loop in which the figure sits down, stays for a while, and stands up again.

use super::gait::{Foot, Pose, ankles, stand, swing, upright};
use super::pose::{pitch, times};
use super::rig::{CHEST, HEAD, HIPS, NECK, SPINE};
use crate::glb::Joint;
use crate::math::{PI, add, sin, smoothstep};

/// How far \[m\] the hips go down and back, and the feet apart and forward.
const DOWN: f64 = 0.375;
const BACK: f64 = 0.36;
const APART: f64 = 0.03;
const FORWARD: f64 = 0.02;

/// The pose at a share of the loop: down in the second quarter, up in the last.
pub fn sit(joints: &[Joint], t: f64) -> Pose {
    let seated = smoothstep(0.10, 0.38, t) * smoothstep(0.95, 0.67, t);
    // The trunk goes forward on the way, so that the weight stays over the feet.
    let lean = sin(PI * seated).max(0.0);
    let mut pose = upright(joints);
    // First back, then down.
    let back = BACK * smoothstep(0.0, 0.9, seated);
    pose.hips = add(pose.hips, [0.0, -0.025 - DOWN * seated, -back]);
    pose.turns[HIPS] = pitch(0.30 * lean - 0.06 * seated);
    pose.turns[SPINE] = pitch(0.22 * lean + 0.05 * seated);
    pose.turns[CHEST] = pitch(0.15 * lean + 0.02 * seated);
    pose.turns[NECK] = pitch(-0.2 * lean);
    pose.turns[HEAD] = times(pitch(-0.2 * lean), pitch(-0.03 * seated));
    (0..2).for_each(|k| swing(&mut pose, k, 0.45 - 0.10 * seated, 0.05 + 0.42 * seated, 0.25 + 0.45 * seated));
    let at = ankles(joints);
    let foot = |k: usize| {
        let side = if k == 0 { APART } else { -APART };
        Foot { ankle: add(at[k], [side, 0.0, FORWARD]), pitch: 0.0 }
    };
    stand(joints, &mut pose, [foot(0), foot(1)]);
    pose
}
