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

// Light from sky and ground, a lamp, one at the eye, and the sheen that fibres have at the outline.
fn lit(base: vec3<f32>, n: vec3<f32>, at: vec3<f32>) -> vec3<f32> {
  let d = view.eye - at;
  let to_eye = d * (1.0 / max(sqrt(dot(d, d)), 1e-9));
  let facing = clamp(dot(n, to_eye), 0.0, 1.0);
  let sky = 0.32 + 0.12 * n.y;
  let lamp = 0.62 * max(dot(n, view.light), 0.0);
  let edge = (1.0 - facing) * (1.0 - facing) * (1.0 - facing);
  return base * (sky + lamp + 0.14 * facing) + vec3<f32>(0.05 * edge);
}

fn checker(uv: vec2<f32>) -> f32 {
  let cell = floor(uv * view.tiles);
  let odd = cell.x + cell.y - 2.0 * floor((cell.x + cell.y) * 0.5);
  return 1.0 - view.shade * odd;
}

fn encoded(linear: vec3<f32>) -> vec3<f32> {
  let c = clamp(linear, vec3<f32>(0.0), vec3<f32>(1.0));
  let curved = 1.055 * pow(c, vec3<f32>(1.0 / 2.4)) - 0.055;
  return select(curved, c * 12.92, c <= vec3<f32>(0.0031308));
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
