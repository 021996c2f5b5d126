// Compliance from an image: right, down, down-right, up-right.
@group(0) @binding(17) var<storage, read> soft: array<vec4<f32>>;

fn compliance(grid: u32, k: u32, direction: u32) -> f32 {
  return soft[k][direction];
}
