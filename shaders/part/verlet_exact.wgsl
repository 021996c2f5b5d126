// A Verlet step of a free particle, of which what is too small for the position to take up is kept for the next: steps of a
// thousandth of a second or less move particles by few units in the last place.

// The same number; but a compiler, which may reorder sums, cannot see that, as no step is shorter than 0.
fn kept(v: vec3<f32>) -> vec3<f32> {
  return bitcast<vec3<f32>>(bitcast<vec3<u32>>(v) ^ vec3<u32>(u32(step.dt < 0.0)));
}

fn moved_on(k: u32, p: vec4<f32>, was: vec3<f32>) -> vec4<f32> {
  let moved = p.xyz - was;
  let a = acceleration(k, p.xyz, moved);
  // A jump, as out of a collider, must not become a velocity.
  let on = select(step.keep, 0.0, dot(moved, moved) > step.longest);
  let left = lost_at(k).xyz;
  // After a fault it may be NaN, whose bits are greater than those of 1.
  let small = (bitcast<vec3<u32>>(left) & vec3<u32>(0x7fffffffu)) <= vec3<u32>(bitcast<u32>(1.0f));
  let by = moved * on + a * step.scale + select(vec3<f32>(0.0), left, small);
  let to = kept(p.xyz + by);
  lose(k, vec4<f32>(by - kept(to - p.xyz), 0.0));
  return vec4<f32>(to, p.w);
}
