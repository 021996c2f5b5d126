// No particle is farther from its anchors than along the surface: hard, one anchor after the other.
// `tethers` are for each particle `slots` pairs of the anchor's index in the cloth, all ones for none, and the bits of its distance.

override slots: u32 = 1u;

fn held_back(k: u32, p: vec3<f32>) -> vec3<f32> {
  var at = p;
  for (var s = 0u; s < slots; s++) {
    let pair = tether_pair(k, s);
    if (pair.x == 0xffffffffu) {
      continue;
    }
    // Nothing moves pinned anchors here; a particle that is no longer pinned holds nothing.
    let end = anchor(pair.x);
    if (end.w != 0.0) {
      continue;
    }
    let most = bitcast<f32>(pair.y);
    let d = at - end.xyz;
    let far = sqrt(dot(d, d));
    if (far > most) {
      at = end.xyz + d * (most / max(far, 1e-30));
    }
  }
  return at;
}

fn tether(k: u32) {
  let p = place(k);
  if (p.w > 0.0) {
    put(k, vec4<f32>(held_back(k, p.xyz), p.w));
  }
}
