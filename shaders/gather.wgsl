// Where a step takes the particles of a cloth whose contact is safe: w is 1 for those that may be held back, 0 for pins and cloth that is asleep,
// -1 for none. As a frame begins, free particles are there already; pins that a host has moved go there in the first step, so that cloth gives way.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(86) var<storage, read_write> goals: array<vec4<f32>>;
@group(0) @binding(87) var<storage, read_write> places: array<vec4<f32>>;

override begins: bool = false;
// Whether all particles were put where they are.
override put: bool = false;
override sleeps: bool = false;

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
  // A particle that is nowhere stays where it was, until its cloth goes back to the last good frame.
  let goal = select(places[k].xyz, p.xyz, sane(p));
  let mark = select(select(0.0, 1.0, p.w > 0.0 && !sleeps), -1.0, p.w < 0.0);
  goals[k] = vec4<f32>(goal, mark);
  if (begins && (put || p.w > 0.0)) {
    places[k] = vec4<f32>(goal, mark);
  }
}
