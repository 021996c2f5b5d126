// The direction and the length of a vector.
fn unit(v: vec3<f32>) -> vec4<f32> {
  let length = sqrt(dot(v, v));
  if (length > 0.0) {
    return vec4<f32>(v * (1.0 / length), length);
  }
  return vec4<f32>(0.0);
}
