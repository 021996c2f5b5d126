// A Verlet step of a free particle that was elsewhere a step ago.
fn moved_on(k: u32, p: vec4<f32>, was: vec3<f32>) -> vec4<f32> {
  let moved = p.xyz - was;
  let a = acceleration(k, p.xyz, moved);
  // A jump, as out of a collider, must not become a velocity.
  let on = select(step.keep, 0.0, dot(moved, moved) > step.longest);
  return vec4<f32>(p.xyz + moved * on + a * step.scale, p.w);
}
