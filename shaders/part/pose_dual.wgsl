// The effect of several joints on a point: dual quaternions. `action` has four rows per joint: the quaternion of its turn, the dual part, and the
// symmetric matrix of its stretch, xx, yy, zz, then xy, yz, zx.
struct Pose {
  turn: vec4<f32>,
  dual: vec4<f32>,
  stretch: vec4<f32>,
  shear: vec4<f32>,
}

// Rows of `action` per joint.
const POSE_ROWS = 4u;

fn no_pose() -> Pose {
  return Pose(vec4<f32>(0.0), vec4<f32>(0.0), vec4<f32>(0.0), vec4<f32>(0.0));
}

fn still_pose() -> Pose {
  return Pose(vec4<f32>(0.0, 0.0, 0.0, 1.0), vec4<f32>(0.0), vec4<f32>(1.0, 1.0, 1.0, 0.0), vec4<f32>(0.0));
}

// The blend with a joint whose first row is given. A quaternion and its opposite are one turn: the one on the side of those before is the shorter way.
fn with_joint(pose: Pose, row: u32, weight: f32) -> Pose {
  let own = action[row];
  let side = select(weight, -weight, dot(pose.turn, own) < 0.0);
  return Pose(
    pose.turn + own * side,
    pose.dual + action[row + 1u] * side,
    pose.stretch + action[row + 2u] * weight,
    pose.shear + action[row + 3u] * weight);
}

fn stretched(pose: Pose, v: vec3<f32>) -> vec3<f32> {
  return vec3<f32>(
    pose.stretch.x * v.x + pose.shear.x * v.y + pose.shear.z * v.z,
    pose.shear.x * v.x + pose.stretch.y * v.y + pose.shear.y * v.z,
    pose.shear.z * v.x + pose.shear.y * v.y + pose.stretch.z * v.z);
}

fn rotated(turn: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
  return v + cross(turn.xyz, cross(turn.xyz, v) + v * turn.w) * 2.0;
}

// One over the length of the quaternion.
fn unit_scale(pose: Pose) -> f32 {
  let length = sqrt(dot(pose.turn, pose.turn));
  return select(0.0, 1.0 / length, length > 0.0);
}

fn placed(pose: Pose, at: vec3<f32>) -> vec3<f32> {
  let scale = unit_scale(pose);
  let turn = pose.turn * scale;
  let dual = pose.dual * scale;
  let shift = (dual.xyz * turn.w - turn.xyz * dual.w + cross(turn.xyz, dual.xyz)) * 2.0;
  return rotated(turn, stretched(pose, at)) + shift;
}

fn posed_direction(pose: Pose, v: vec3<f32>) -> vec3<f32> {
  return rotated(pose.turn * unit_scale(pose), stretched(pose, v));
}
