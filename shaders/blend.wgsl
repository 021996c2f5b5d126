// The vertices of a bound mesh that are on the skin, or between the skin and the cloth, after shaders/wrap.wgsl, a thread a vertex. `action` has the
// poses of the joints.
// For each: where it is at rest, and its share of the cloth; its normal at rest, and its number; its tangent at rest; then the joints of
// each set and their weights.
@group(0) @binding(76) var<storage, read> blending: array<vec4<u32>>;
// Three per vertex: position, normal, tangent.
@group(0) @binding(66) var<storage, read_write> wrapped: array<vec4<f32>>;

// Sets of four joints per vertex.
override sets: u32 = 1u;

fn direction(v: vec3<f32>) -> vec3<f32> {
  let length = sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
  return select(vec3<f32>(0.0), v * (1.0 / length), length > 0.0);
}

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let n = element(workgroup, rows, local);
  let size = 3u + 2u * sets;
  if (n >= arrayLength(&blending) / size) {
    return;
  }
  let head = bitcast<vec4<f32>>(blending[size * n]);
  let second = blending[size * n + 1u];
  let own_normal = bitcast<vec3<f32>>(second.xyz);
  let own_tangent = bitcast<vec3<f32>>(blending[size * n + 2u].xyz);
  var pose = no_pose();
  var follows = false;
  for (var s = 0u; s < sets; s++) {
    let joints = blending[size * n + 3u + 2u * s];
    let weights = bitcast<vec4<f32>>(blending[size * n + 4u + 2u * s]);
    for (var c = 0u; c < 4u; c++) {
      if (weights[c] > 0.0) {
        follows = true;
        pose = with_joint(pose, POSE_ROWS * joints[c], weights[c]);
      }
    }
  }
  if (!follows) {
    pose = still_pose();
  }
  var at = placed(pose, head.xyz);
  var normal = direction(posed_direction(pose, own_normal));
  var tangent = direction(posed_direction(pose, own_tangent));
  let first = 3u * second.w;
  let sign = wrapped[first + 2u].w;
  if (head.w > 0.0) {
    at += (wrapped[first].xyz - at) * head.w;
    normal += (wrapped[first + 1u].xyz - normal) * head.w;
    tangent += (wrapped[first + 2u].xyz - tangent) * head.w;
  }
  wrapped[first] = vec4<f32>(at, 1.0);
  wrapped[first + 1u] = vec4<f32>(direction(normal), 0.0);
  wrapped[first + 2u] = vec4<f32>(direction(tangent), sign);
}
