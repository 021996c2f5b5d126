// As integrate.wgsl, and what is too small for the position to take up is kept for the next step: steps of a thousandth of
// a second or less move particles by few units in the last place.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;
@group(0) @binding(28) var<storage, read_write> lost: array<vec4<f32>>;

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
  if (p.w <= 0.0) {
    return;
  }
  let moved = p.xyz - before[k].xyz;
  let a = acceleration(k, p.xyz, moved);
  // A jump, as out of a collider, must not become a velocity.
  let on = select(step.keep, 0.0, dot(moved, moved) > step.longest);
  let left = lost[k].xyz;
  // After a fault it may be no number, for which the comparison is false.
  let by = moved * on + a * step.scale + select(vec3<f32>(0.0), left, abs(left) <= vec3<f32>(1.0));
  let to = p.xyz + by;
  lost[k] = vec4<f32>(by - (to - p.xyz), 0.0);
  before[k] = p;
  now[k] = vec4<f32>(to, p.w);
}
