// Texture coordinates. A triangle across a seam of the texture takes those of its first corner: between the two sides
// of the seam lies no texture.
@group(0) @binding(20) var<storage, read> uv: array<vec2<f32>>;

fn texture(t: vec3<u32>, corner: u32) -> vec2<f32> {
  let one = abs(uv[t.y] - uv[t.x]);
  let two = abs(uv[t.z] - uv[t.x]);
  let far = max(max(one.x, one.y), max(two.x, two.y));
  return select(uv[t[corner]], uv[t.x], far > view.jump);
}
