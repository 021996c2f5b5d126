// The ends of a spring go to its rest length, in place. No spring where there is no rest length, or no particle.
fn relax_hard(grid: u32, ends: Ends, direction: u32) {
  let k = ends.k;
  let other = ends.other;
  let length = rest_length(grid, k, direction);
  let a = place(k);
  let b = place(other);
  let sum = a.w + b.w;
  if (length <= 0.0 || min(a.w, b.w) < 0.0 || sum <= 0.0) {
    return;
  }
  let d = b.xyz - a.xyz;
  let far = max(sqrt(dot(d, d)), 1e-9);
  let by = d * (1.0 - length / far);
  put(k, vec4<f32>(a.xyz + by * (a.w / sum), a.w));
  put(other, vec4<f32>(b.xyz - by * (b.w / sum), b.w));
}
