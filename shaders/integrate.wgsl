// One Verlet step of every free particle: now becomes before. w is the inverse mass, 0 pinned, -1 no particle.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;

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
  before[k] = p;
  now[k] = vec4<f32>(p.xyz + moved * on + a * step.scale, p.w);
}
