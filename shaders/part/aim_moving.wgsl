// Where the skin is at the end of the step, and the limit: on its way in the frame, as colliders are on theirs.
fn aim(k: u32) -> vec4<f32> {
  let to = targets_at(k);
  return vec4<f32>(to.xyz - drifts_at(k).xyz * step.left, to.w);
}
