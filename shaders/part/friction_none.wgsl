// Colliders that are all smooth.
fn rub(solid: Solid, k: u32, at: vec3<f32>, n: vec3<f32>, depth: f32) -> vec3<f32> {
  return at;
}
