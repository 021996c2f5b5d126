// The vertices of the surface of a body where joints put them, a thread a vertex: `surface_vertices` has four rows each, the positions at the
// start and at the end of the frame, then the normals. The fourth numbers of the first three are the position at rest. `action` has the poses of the joints: those of the end of the frame, then those of its
// beginning.
@group(0) @binding(93) var<storage, read> surface_shape: array<vec4<u32>>;
@group(0) @binding(94) var<storage, read_write> surface_vertices: array<vec4<f32>>;

// Sets of four joints per vertex; 0 for a surface that rests.
override sets: u32 = 1u;

// `surface_shape` has for each vertex its position at rest, its normal there, then the joints of each set and their weights.
fn pose_of(n: u32, first: u32) -> Pose {
  if (sets == 0u) {
    return still_pose();
  }
  let at = n * (2u + 2u * sets);
  var pose = no_pose();
  for (var s = 0u; s < sets; s++) {
    let joints = surface_shape[at + 2u + 2u * s];
    let weights = bitcast<vec4<f32>>(surface_shape[at + 3u + 2u * s]);
    for (var c = 0u; c < 4u; c++) {
      if (weights[c] > 0.0) {
        pose = with_joint(pose, first + POSE_ROWS * joints[c], weights[c]);
      }
    }
  }
  return pose;
}

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let n = element(workgroup, rows, local);
  if (4u * n >= arrayLength(&surface_vertices)) {
    return;
  }
  let at = n * (2u + 2u * sets);
  let rest = bitcast<vec3<f32>>(surface_shape[at].xyz);
  let normal = bitcast<vec3<f32>>(surface_shape[at + 1u].xyz);
  let begin = pose_of(n, arrayLength(&action) / 2u);
  let end = pose_of(n, 0u);
  surface_vertices[4u * n] = vec4<f32>(placed(begin, rest), rest.x);
  surface_vertices[4u * n + 1u] = vec4<f32>(placed(end, rest), rest.y);
  surface_vertices[4u * n + 2u] = vec4<f32>(posed_direction(begin, normal), rest.z);
  surface_vertices[4u * n + 3u] = vec4<f32>(posed_direction(end, normal), 0.0);
}
