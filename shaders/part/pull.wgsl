// The ends of a spring, and how it moves them.
struct Pull {
  a: vec4<f32>,
  b: vec4<f32>,
  // From a to b, never of no length.
  d: vec3<f32>,
  far: f32,
  rest: f32,
  // Whether there is a spring.
  there: bool,
}

fn pull_of(grid: u32, ends: Ends, direction: u32) -> Pull {
  let rest = rest_length(grid, ends.k, direction);
  let a = place(ends.k);
  let b = place(ends.other);
  var d = b.xyz - a.xyz;
  var far = max(sqrt(dot(d, d)), 1e-9);
  if (direction == 0u && far < rest * SHORT) {
    d += way(ends.k - grids_at(grid).first) * (rest * ASIDE);
    far = max(sqrt(dot(d, d)), 1e-9);
  }
  return Pull(a, b, d, far, rest, rest > 0.0 && min(a.w, b.w) >= 0.0);
}

// Each end moves by its inverse mass.
fn draw_together(ends: Ends, pull: Pull, g: f32) {
  put(ends.k, vec4<f32>(pull.a.xyz + pull.d * (g * pull.a.w), pull.a.w));
  put(ends.other, vec4<f32>(pull.b.xyz - pull.d * (g * pull.b.w), pull.b.w));
}
