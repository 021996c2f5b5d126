// A particle stays out of the sphere behind it: its backstop. The radius in metres is the w of the centre; below 0 there is none.
fn backstop(k: u32) {
  let p = place(k);
  let behind = back(k);
  if (p.w <= 0.0 || behind.w < 0.0) {
    return;
  }
  let d = p.xyz - behind.xyz;
  let far = sqrt(dot(d, d));
  if (far < behind.w) {
    put(k, vec4<f32>(behind.xyz + d * (behind.w / max(far, 1e-30)), p.w));
  }
}
