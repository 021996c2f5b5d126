// Draws triangles whose corners a part above makes, lit from both sides.

// Whether the target wants sRGB and does not convert by itself.
override encode: bool = false;

struct Point {
  @builtin(position) clip: vec4<f32>,
  @location(0) at: vec3<f32>,
  @location(1) normal: vec3<f32>,
  @location(2) uv: vec2<f32>,
  @location(3) @interpolate(flat) front: vec4<f32>,
  @location(4) @interpolate(flat) back: vec4<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Point {
  let c = corner(index, instance);
  return Point(view.clip * vec4<f32>(c.at, 1.0), c.at, c.normal, c.uv, c.front, c.back);
}

fn checker(uv: vec2<f32>) -> f32 {
  let cell = floor(uv * view.tiles);
  let odd = cell.x + cell.y - 2.0 * floor((cell.x + cell.y) * 0.5);
  return 1.0 - view.shade * odd;
}

@fragment
fn fragment(p: Point, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
  let side = select(-1.0, 1.0, front);
  let n = p.normal * (side / max(sqrt(dot(p.normal, p.normal)), 1e-9));
  let base = select(p.back.xyz, p.front.xyz, front) * checker(p.uv);
  var color = lit(base, n, p.at);
  if (p.back.w > 0.0) {
    let d = p.at - view.middle;
    let far = clamp(sqrt(dot(d, d)) / p.back.w, 0.0, 1.0);
    color += (view.background - color) * (far * far * (3.0 - 2.0 * far));
  }
  return vec4<f32>(select(color, encoded(color), encode), p.front.w);
}
