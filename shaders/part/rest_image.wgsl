// Rest lengths from an image: right, down, down-right, up-right.
@group(0) @binding(4) var<storage, read> rest: array<vec4<f32>>;

fn rest_length(grid: u32, k: u32, direction: u32) -> f32 {
  return rest[k][direction];
}
