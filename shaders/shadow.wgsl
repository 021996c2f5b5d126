// A cloth as other cloths see it for some steps. Two vectors per particle: where it is and its inverse mass, 0 for cloth that is asleep; its
// velocity, and the speed above which contact wakes the cloth. `part` has one over the length of the last step, 0 for cloth that is asleep,
// and that speed.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> before: array<vec4<f32>>;
@group(0) @binding(53) var<uniform> part: vec4<f32>;
@group(0) @binding(80) var<storage, read_write> shadow: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let k = element(workgroup, rows, local);
  if (k >= arrayLength(&now)) {
    return;
  }
  let p = now[k];
  let rate = part.x;
  shadow[2u * k] = vec4<f32>(p.xyz, select(0.0, max(p.w, 0.0), rate > 0.0));
  shadow[2u * k + 1u] = vec4<f32>((p.xyz - before[k].xyz) * rate, part.y);
}
