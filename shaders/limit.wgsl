// A particle is no farther from its target than its limit: a hard motion constraint, as NvCloth and Chaos have it.
// The limit in metres is the w of the target; below 0 there is none.
fn limit(k: u32) {
  let p = place(k);
  let to = aim(k);
  if (p.w <= 0.0 || to.w < 0.0) {
    return;
  }
  let d = p.xyz - to.xyz;
  let far = sqrt(dot(d, d));
  if (far > to.w) {
    put(k, vec4<f32>(to.xyz + d * (to.w / max(far, 1e-30)), p.w));
  }
}
