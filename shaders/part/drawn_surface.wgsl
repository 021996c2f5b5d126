// Corners of triangles that the host moves: position, normal and colour.
@group(0) @binding(2) var<storage, read> mesh: array<vec4<f32>>;

fn corner(vertex: u32, instance: u32) -> Corner {
  let p = mesh[3u * vertex];
  let n = mesh[3u * vertex + 1u];
  let color = vec4<f32>(mesh[3u * vertex + 2u].xyz, 1.0);
  return Corner(p.xyz, n.xyz, vec2<f32>(0.0), color, vec4<f32>(color.xyz, 0.0));
}
