// The triangles of a surface, two rows each: corners and flags, then the triangles across the sides and the patch. Flags have a bit for each hollow
// side, and from the fourth on one for each corner on a border. Behind them are the triangles by patches, where each patch begins among
// these, the triangle in the middle of each patch, and one over the square of the distance in metres at which it passes near. `action` has the numbers of triangles and of patches in its second row.
@group(0) @binding(95) var<storage, read> surface_triangles: array<vec4<u32>>;

const NO_TRIANGLE = 0xffffffffu;

fn triangle_count() -> u32 {
  return u32(action[1].x);
}

fn patch_count() -> u32 {
  return u32(action[1].y);
}

fn surface_word(n: u32) -> u32 {
  return surface_triangles[n / 4u][n % 4u];
}

fn ordered_triangle(n: u32) -> u32 {
  return surface_word(8u * triangle_count() + n);
}

fn patch_start(n: u32) -> u32 {
  return surface_word(9u * triangle_count() + n);
}

fn patch_middle(n: u32) -> u32 {
  return surface_word(9u * triangle_count() + patch_count() + 1u + n);
}

fn patch_reach(n: u32) -> f32 {
  return bitcast<f32>(surface_word(9u * triangle_count() + 2u * patch_count() + 1u + n));
}

// Where a vertex is at the start of the frame, and at its end.
fn start_of(v: u32) -> vec3<f32> {
  return surface_vertices[4u * v].xyz;
}

fn end_of(v: u32) -> vec3<f32> {
  return surface_vertices[4u * v + 1u].xyz;
}
