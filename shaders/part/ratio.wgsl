// The square of length / rest length of a spring; 0 where there is none, or none that can move.
fn squared_ratio(a: vec4<f32>, b: vec4<f32>, length: f32) -> f32 {
  if (length <= 0.0 || min(a.w, b.w) < 0.0 || a.w + b.w <= 0.0) {
    return 0.0;
  }
  let d = b.xyz - a.xyz;
  return dot(d, d) / (length * length);
}
