// Puts the particles of a cloth that were held back. The previous position is changed so that of the motion along the change only what led into it
// ends: contact pushes and lets previous positions follow, and a push that is held back must leave no speed the other way.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;
@group(0) @binding(87) var<storage, read> places: array<vec4<f32>>;

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
  let to = places[k].xyz;
  let change = to - p.xyz;
  let long = sqrt(dot(change, change));
  if (p.w > 0.0 && sane(p) && long > 0.0) {
    let was = before[k];
    let ahead = dot(p.xyz - was.xyz, change) / long;
    let follows = clamp(ahead + long, 0.0, long) / long;
    now[k] = vec4<f32>(to, p.w);
    before[k] = vec4<f32>(was.xyz + change * follows, was.w);
    clear_lost(k);
  }
}
