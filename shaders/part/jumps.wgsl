// How far vertices would have jumped as the cloth changed its level, in their frames; three per vertex: position, normal, tangent.
// `action`: the share of that which is left (y).
@group(0) @binding(81) var<storage, read> jumps: array<vec4<f32>>;

fn jumped(row: u32, own: vec3<f32>) -> vec3<f32> {
  return own + jumps[row].xyz * action[0].y;
}

fn turned(row: u32, own: vec3<f32>, frame: VertexFrame) -> vec3<f32> {
  return direction(outward(frame, jumped(row, own)));
}
