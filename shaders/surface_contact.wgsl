// A particle nearer to a plane of the surface of a body than its clearance leaves along the normal, and friction takes back its way along the
// plane since the last step. `surface_planes` has two planes per particle, four rows each: a point at the end of the frame and the clearance,
// the normal there and the friction, and how fast both get there.
fn leave_surface(k: u32) {
  let p = place(k);
  if (p.w > 0.0) {
    // The side at which it is has the last word.
    put(k, vec4<f32>(off_plane(8u * k, off_plane(8u * k + 4u, p.xyz, was(k)), was(k)), p.w));
  }
}

fn off_plane(n: u32, p: vec3<f32>, start: vec3<f32>) -> vec3<f32> {
  let at = surface_planes_at(n);
  if (at.w <= NO_PLANE) {
    return p;
  }
  let end = surface_planes_at(n + 1u);
  let drift = surface_planes_at(n + 2u).xyz;
  let normal = end.xyz - surface_planes_at(n + 3u).xyz * step.left;
  let depth = at.w - dot(p - (at.xyz - drift * step.left), normal);
  if (!(depth > 0.0)) {
    return p;
  }
  let out = p + normal * depth;
  if (end.w <= 0.0) {
    return out;
  }
  let moved = out - start - drift * step.dt;
  let along = moved - normal * dot(moved, normal);
  let far = sqrt(dot(along, along));
  let most = end.w * depth;
  return out - along * select(most / far, 1.0, most >= far);
}
