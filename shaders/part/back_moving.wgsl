// The sphere behind a particle where the skin is at the end of the step.
fn back(k: u32) -> vec4<f32> {
  let to = backs_at(k);
  return vec4<f32>(to.xyz - back_drifts_at(k).xyz * step.left, to.w);
}
