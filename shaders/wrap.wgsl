// The vertices of a mesh that is bound to the cloth: each keeps its place in the frame of the drawn surface at its point.
// Three per vertex: position, normal, tangent.
@group(0) @binding(66) var<storage, read_write> wrapped: array<vec4<f32>>;

fn move_vertex(n: u32) {
  let corner = bound_vertices[4u * n].x;
  let own_offset = bitcast<vec4<f32>>(bound_vertices[4u * n + 1u]).yzw;
  let own_normal = bitcast<vec4<f32>>(bound_vertices[4u * n + 2u]);
  let own_tangent = bitcast<vec4<f32>>(bound_vertices[4u * n + 3u]);
  if (corner == 0xffffffffu) {
    wrapped[3u * n] = vec4<f32>(own_offset, 1.0);
    wrapped[3u * n + 1u] = vec4<f32>(own_normal.xyz, 0.0);
    wrapped[3u * n + 2u] = own_tangent;
    return;
  }
  let frame = vertex_frame(n);
  let offset = outward(frame, jumped(3u * n, own_offset));
  wrapped[3u * n] = vec4<f32>(frame.corner + (frame.way + offset), 1.0);
  wrapped[3u * n + 1u] = vec4<f32>(turned(3u * n + 1u, own_normal.xyz, frame), 0.0);
  wrapped[3u * n + 2u] = vec4<f32>(turned(3u * n + 2u, own_tangent.xyz, frame), own_tangent.w);
}

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let n = element(workgroup, rows, local);
  if (4u * n < arrayLength(&bound_vertices)) {
    move_vertex(n);
  }
}
