// No particle is farther from its anchors than along the surface: hard, one anchor after the other.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;
// For each particle `slots` pairs of the anchor's index, all ones for none, and the bits of its distance.
@group(0) @binding(19) var<storage, read> tethers: array<vec2<u32>>;

override slots: u32 = 1u;

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
  var at = p.xyz;
  for (var s = 0u; s < slots; s++) {
    let tether = tethers[k * slots + s];
    if (tether.x == 0xffffffffu) {
      continue;
    }
    // Nothing moves pinned anchors here; what is no longer pinned holds nothing.
    let end = now[tether.x];
    if (end.w != 0.0) {
      continue;
    }
    let anchor = end.xyz;
    let most = bitcast<f32>(tether.y);
    let d = at - anchor;
    let far = sqrt(dot(d, d));
    if (far > most) {
      at = anchor + d * (most / max(far, 1e-30));
    }
  }
  now[k] = vec4<f32>(at, p.w);
}
