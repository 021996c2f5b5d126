// Whether a place is a number and within all bounds.
const FARTHEST: f32 = 1e8;

fn sane(p: vec4<f32>) -> bool {
  // Comparisons with NaN are false.
  return abs(p.x) <= FARTHEST && abs(p.y) <= FARTHEST && abs(p.z) <= FARTHEST;
}
