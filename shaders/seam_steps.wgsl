// The duplicates of every seam point take their mean, or the position of the first pinned one, in positions and in previous
// positions: coarser grids move both. A thread a ring.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let ring = element(workgroup, rows, local);
  if (ring + 1u >= arrayLength(&starts)) {
    return;
  }
  let first = starts[ring];
  let end = starts[ring + 1u];
  var at = vec3<f32>(0.0);
  var was = vec3<f32>(0.0);
  var pinned = false;
  for (var m = first; m < end && !pinned; m++) {
    let p = now[members[m]];
    let b = before[members[m]].xyz;
    pinned = p.w == 0.0;
    at = select(at + p.xyz, p.xyz, pinned);
    was = select(was + b, b, pinned);
  }
  let share = select(1.0 / f32(end - first), 1.0, pinned);
  for (var m = first; m < end; m++) {
    let k = members[m];
    now[k] = vec4<f32>(at * share, now[k].w);
    before[k] = vec4<f32>(was * share, before[k].w);
  }
}
