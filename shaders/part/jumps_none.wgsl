// A cloth that has not changed its level for a while.
fn jumped(row: u32, own: vec3<f32>) -> vec3<f32> {
  return own;
}

fn turned(row: u32, own: vec3<f32>, frame: VertexFrame) -> vec3<f32> {
  return outward(frame, own);
}
