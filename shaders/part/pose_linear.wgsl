// The effect of several joints on a point: linear blend skinning. `action` has three rows per joint, its matrix.
struct Pose {
  x: vec4<f32>,
  y: vec4<f32>,
  z: vec4<f32>,
}

// Rows of `action` per joint.
const POSE_ROWS = 3u;

fn no_pose() -> Pose {
  return Pose(vec4<f32>(0.0), vec4<f32>(0.0), vec4<f32>(0.0));
}

fn still_pose() -> Pose {
  return Pose(vec4<f32>(1.0, 0.0, 0.0, 0.0), vec4<f32>(0.0, 1.0, 0.0, 0.0), vec4<f32>(0.0, 0.0, 1.0, 0.0));
}

// The blend with a joint whose first row is given.
fn with_joint(pose: Pose, row: u32, weight: f32) -> Pose {
  return Pose(
    pose.x + action[row] * weight, pose.y + action[row + 1u] * weight, pose.z + action[row + 2u] * weight);
}

fn placed(pose: Pose, at: vec3<f32>) -> vec3<f32> {
  let p = vec4<f32>(at, 1.0);
  return vec3<f32>(dot(pose.x, p), dot(pose.y, p), dot(pose.z, p));
}

fn posed_direction(pose: Pose, v: vec3<f32>) -> vec3<f32> {
  return vec3<f32>(dot(pose.x.xyz, v), dot(pose.y.xyz, v), dot(pose.z.xyz, v));
}
