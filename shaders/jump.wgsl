// How far the vertices of a bound mesh would jump as the cloth changes its level: the way from where they are on the new level to where they
// were on the last one, in their frames on the new one; 0 for vertices that are not bound.
// Three per vertex: position, normal, tangent.
@group(0) @binding(66) var<storage, read> wrapped: array<vec4<f32>>;
@group(0) @binding(81) var<storage, read_write> jumps: array<vec4<f32>>;

fn inward(frame: VertexFrame, v: vec3<f32>) -> vec4<f32> {
  return vec4<f32>(dot(frame.tangent, v), dot(frame.bitangent, v), dot(frame.normal, v), 0.0);
}

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let n = element(workgroup, rows, local);
  if (4u * n >= arrayLength(&bound_vertices)) {
    return;
  }
  if (bound_vertices[4u * n].x == 0xffffffffu) {
    jumps[3u * n] = vec4<f32>(0.0);
    jumps[3u * n + 1u] = vec4<f32>(0.0);
    jumps[3u * n + 2u] = vec4<f32>(0.0);
    return;
  }
  let frame = vertex_frame(n);
  let own_offset = bitcast<vec4<f32>>(bound_vertices[4u * n + 1u]).yzw;
  let own_normal = bitcast<vec4<f32>>(bound_vertices[4u * n + 2u]).xyz;
  let own_tangent = bitcast<vec4<f32>>(bound_vertices[4u * n + 3u]).xyz;
  let here = frame.corner + (frame.way + outward(frame, own_offset));
  jumps[3u * n] = inward(frame, wrapped[3u * n].xyz - here);
  jumps[3u * n + 1u] = inward(frame, wrapped[3u * n + 1u].xyz) - vec4<f32>(own_normal, 0.0);
  jumps[3u * n + 2u] = inward(frame, wrapped[3u * n + 2u].xyz) - vec4<f32>(own_tangent, 0.0);
}
