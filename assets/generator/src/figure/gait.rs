//! Loops of the figure: a walk in place, and a turn about the vertical axis.

use super::pose::{Quat, STILL, about, bone, hermite, inverse, pitch, reach, roll, times, turn, yaw};
use super::rig::{
    CHEST, COUNT, FEET, FOREARMS, HEAD, HIPS, NECK, SHINS, SHOULDERS, SIDES, SPINE, THIGHS, UPPER_ARMS, joints,
};
use super::sit::sit;
use crate::body::ARM;
use crate::glb::{Between, Clip, Joint, Track};
use crate::math::{PI, V3, add, cos, sin, smoothstep, sub};

/// Duration of the walk and of the turn, and of sitting \[s\], and keys per second.
const SECONDS: f64 = 2.4;
const SEATED: f64 = 5.0;
const RATE: usize = 30;
/// Cycles of two steps in the walk.
const CYCLES: f64 = 2.0;
/// Distance \[m\] that a foot on the ground goes back, and the share of the cycle that it is there.
const STRIDE: f64 = 0.60;
const STANCE: f64 = 0.6;
/// Pivots of a foot from its ankle \[m\] in the bind pose: heel and ball.
const HEEL: V3 = [0.0, -0.070, -0.045];
const BALL: V3 = [0.012, -0.070, 0.100];

/// A pose: the place of the hips, and the rotation of each joint in its parent.
pub struct Pose {
    pub hips: V3,
    pub turns: [Quat; COUNT],
}

/// All clips.
pub fn clips() -> Vec<Clip> {
    let joints = joints();
    vec![
        clip("Walk", SECONDS, &joints, |t| walk(&joints, t)),
        clip("Turn", SECONDS, &joints, |t| whirl(&joints, t)),
        clip("Sit", SEATED, &joints, |t| sit(&joints, t)),
    ]
}

/// A clip of a pose over 0..=1.
fn clip(name: &'static str, seconds: f64, joints: &[Joint], pose: impl Fn(f64) -> Pose) -> Clip {
    let keys = (seconds * RATE as f64).round() as usize;
    let times: Vec<f32> = (0..=keys).map(|k| (k as f64 / RATE as f64) as f32).collect();
    // The last key is the first one again, to the last bit; a whole turn ends in the opposite quaternion, which is the same rotation.
    let poses: Vec<Pose> = (0..=keys).map(|k| pose(k as f64 / keys as f64)).collect();
    let track = |joint, path, values| Track { joint, path, between: Between::Linear, times: times.clone(), values };
    let place = |p: &Pose| p.hips.map(|c| ((c * 1e6).round() / 1e6) as f32);
    let mut tracks = vec![track(HIPS, "translation", poses.iter().flat_map(place).collect())];
    for joint in 0..joints.len() {
        if poses.iter().any(|p| p.turns[joint] != STILL) {
            let values: Vec<f32> = poses.iter().flat_map(|p| p.turns[joint].map(|c| c as f32)).collect();
            tracks.push(track(joint, "rotation", values));
        }
    }
    Clip { name, tracks }
}

/// The place and the pitch of a foot on its way through a cycle.
pub struct Foot {
    pub ankle: V3,
    pub pitch: f64,
}

/// A foot at phase 0..1 of its cycle, which begins as the heel comes down; `ankle` is its place in the bind pose.
fn step(ankle: V3, phase: f64) -> Foot {
    let raised = |p: f64| -0.30 * smoothstep(0.12, 0.0, p) + 0.62 * smoothstep(0.36, STANCE, p);
    let on_ground = |p: f64| {
        let pitch_now = raised(p);
        let pivot = if p < 0.12 { HEEL } else { BALL };
        let back = STRIDE * (0.5 - p / STANCE);
        let on = add(add(ankle, pivot), [0.0, 0.0, back - 0.03]);
        Foot { ankle: sub(on, turn(pitch(pitch_now), pivot)), pitch: pitch_now }
    };
    if phase <= STANCE {
        return on_ground(phase);
    }
    let (off, down) = (on_ground(STANCE), on_ground(0.0));
    let t = (phase - STANCE) / (1.0 - STANCE);
    let back = -STRIDE / STANCE * (1.0 - STANCE);
    let z = hermite(off.ankle[2], down.ankle[2], [0.2, back], t);
    let y = hermite(off.ankle[1], down.ankle[1], [0.12, -0.10], t) + 0.03 * sin(PI * t) * sin(PI * t);
    let toes = 0.62 * smoothstep(0.55, 0.0, t) - 0.30 * smoothstep(0.35, 1.0, t);
    Foot { ankle: [ankle[0], y, z], pitch: toes }
}

/// Legs whose feet are given, under hips that are where the pose has them.
pub fn stand(joints: &[Joint], pose: &mut Pose, feet: [Foot; 2]) {
    let at = |j: usize| joints[j].at;
    for (k, foot) in feet.into_iter().enumerate() {
        let (thigh, shin, ankle) = (THIGHS[k], SHINS[k], FEET[k]);
        let hips = pose.turns[HIPS];
        let hip = add(pose.hips, turn(hips, bone(at(HIPS), at(thigh))));
        let (upper, lower) = (bone(at(thigh), at(shin)), bone(at(shin), at(ankle)));
        let (turned, bend) = reach(upper, lower, sub(foot.ankle, hip));
        pose.turns[thigh] = times(inverse(hips), turned);
        pose.turns[shin] = pitch(bend);
        let shin_in_world = times(turned, pitch(bend));
        pose.turns[ankle] = times(inverse(shin_in_world), pitch(foot.pitch));
    }
}

/// An arm: lowered from the bind pose, swung forward and bent at the elbow \[rad\].
pub fn swing(pose: &mut Pose, k: usize, lowered: f64, forward: f64, bend: f64) {
    pose.turns[UPPER_ARMS[k]] = times(pitch(-forward), roll(-SIDES[k] * lowered));
    // Across the arm, so that the hand goes forward.
    pose.turns[FOREARMS[k]] = about([ARM[1], -SIDES[k] * ARM[0], 0.0], bend);
}

pub fn ankles(joints: &[Joint]) -> [V3; 2] {
    FEET.map(|j| joints[j].at.map(f64::from))
}

pub fn upright(joints: &[Joint]) -> Pose {
    Pose { hips: joints[HIPS].at.map(f64::from), turns: [STILL; COUNT] }
}

/// The walk at a share of its loop.
fn walk(joints: &[Joint], t: f64) -> Pose {
    let cycle = t * CYCLES - (t * CYCLES).floor();
    let wave = |times: f64, late: f64| cos(2.0 * PI * times * (cycle - late));
    let mut pose = upright(joints);
    // The weight goes to the foot on the ground; the other side of the hips sinks. Lowest with both feet down.
    let left = wave(1.0, 0.32);
    let sway = [0.022 * left, -0.030 - 0.014 * wave(2.0, 0.06), 0.008 * wave(2.0, 0.3)];
    pose.hips = add(pose.hips, sway);
    let ahead = wave(1.0, 0.02);
    pose.turns[HIPS] = times(yaw(-0.13 * ahead), times(roll(0.055 * left), pitch(0.03)));
    pose.turns[SPINE] = times(yaw(0.10 * ahead), times(roll(-0.05 * left), pitch(0.02 + 0.012 * wave(2.0, 0.1))));
    pose.turns[CHEST] = times(yaw(0.12 * ahead), times(roll(-0.025 * left), pitch(0.01)));
    let look = 0.16 * sin(2.0 * PI * t);
    pose.turns[NECK] = times(yaw(-0.05 * ahead + 0.4 * look), pitch(-0.03));
    pose.turns[HEAD] = times(yaw(-0.04 * ahead + 0.6 * look), times(roll(0.015 * left), pitch(-0.02)));
    for k in 0..2 {
        // Arms swing against the legs, a little late.
        let forward = -SIDES[k] * wave(1.0, 0.04);
        pose.turns[SHOULDERS[k]] = yaw(SIDES[k] * -0.05 * forward);
        swing(&mut pose, k, 0.45, 0.04 + 0.40 * forward, 0.30 + 0.20 * (forward + 0.3).max(0.0));
    }
    let [l, r] = ankles(joints);
    let late = if cycle < 0.5 { cycle + 0.5 } else { cycle - 0.5 };
    // Feet come in towards the line of the walk.
    let inwards = |p: V3| [0.78 * p[0], p[1], p[2]];
    stand(joints, &mut pose, [step(inwards(l), cycle), step(inwards(r), late)]);
    pose
}

/// A whole turn to the left in four steps, from rest to rest.
fn whirl(joints: &[Joint], t: f64) -> Pose {
    let mut pose = upright(joints);
    let done = t - sin(2.0 * PI * t) / (2.0 * PI);
    let speed = 0.5 - 0.5 * cos(2.0 * PI * t);
    let lift = |from: f64| {
        let x = ((t - from) / 0.2).clamp(0.0, 1.0);
        sin(PI * x) * sin(PI * x)
    };
    let lifts = [lift(0.12) + lift(0.52), lift(0.32) + lift(0.72)];
    let side = lifts[1] - lifts[0];
    pose.hips = add(pose.hips, [0.03 * side, -0.025, 0.0]);
    pose.turns[SPINE] = times(yaw(0.10 * speed), pitch(0.03));
    pose.turns[CHEST] = yaw(0.12 * speed);
    pose.turns[NECK] = yaw(0.10 * speed);
    pose.turns[HEAD] = yaw(0.12 * speed);
    for (k, side) in SIDES.iter().enumerate() {
        swing(&mut pose, k, 0.45 - 0.30 * speed, 0.05 + 0.12 * side * speed, 0.25);
    }
    let at = ankles(joints);
    let foot = |k: usize| Foot { ankle: add(at[k], [0.0, 0.07 * lifts[k], 0.03 * lifts[k]]), pitch: 0.35 * lifts[k] };
    stand(joints, &mut pose, [foot(0), foot(1)]);
    let spin = yaw(2.0 * PI * done);
    pose.hips = turn(spin, pose.hips);
    pose.turns[HIPS] = times(spin, pose.turns[HIPS]);
    pose
}
