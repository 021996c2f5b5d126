// Where the joints of a cloth put each of its particles, a thread a particle. `skinned` has where each is to be
// at the end of the frame, its limit as w, then for each how fast it gets there in m/s, its w being 1 for a particle that follows.
// `action` has the poses of the joints: those of the end of the frame, then those of its beginning.
@group(0) @binding(56) var<storage, read> influences: array<vec4<u32>>;
@group(0) @binding(57) var<storage, read_write> skinned: array<vec4<f32>>;

// Sets of four joints per particle.
override sets: u32 = 1u;

// `influences` has for each particle its position at rest, then the joints of each set and their weights.
fn skin_at(n: u32, first: u32) -> vec3<f32> {
  let at = n * (1u + 2u * sets);
  var pose = no_pose();
  for (var s = 0u; s < sets; s++) {
    let joints = influences[at + 1u + 2u * s];
    let weights = bitcast<vec4<f32>>(influences[at + 2u + 2u * s]);
    for (var c = 0u; c < 4u; c++) {
      pose = with_joint(pose, first + POSE_ROWS * joints[c], weights[c]);
    }
  }
  return placed(pose, bitcast<vec3<f32>>(influences[at].xyz));
}

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let n = element(workgroup, rows, local);
  let count = arrayLength(&skinned) / 2u;
  if (n >= count) {
    return;
  }
  // The last row is the rate in 1/s at which the way of a frame is made.
  let last = arrayLength(&action) - 1u;
  let rate = action[last].x;
  let to = skin_at(n, 0u);
  var speed = vec3<f32>(0.0);
  if (rate > 0.0) {
    speed = (to - skin_at(n, last / 2u)) * rate;
  }
  skinned[n] = vec4<f32>(to, skinned[n].w);
  skinned[count + n] = vec4<f32>(speed, skinned[count + n].w);
}
