// Effect of air on the triangles around each particle, as an acceleration: a third of each triangle's force.
// Drag along the flow, lift across it in the plane of flow and normal, both as the area that faces the wind.
fn force(area: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
  let speed = max(sqrt(dot(v, v)), 1e-9);
  let size = max(sqrt(dot(area, area)), 1e-18);
  let facing = dot(area, v);
  let across = (area * (speed * speed) - v * facing) * (1.0 / (speed * size));
  let way = select(1.0, -1.0, facing < 0.0);
  return (v * step.drag + across * (step.lift * way)) * abs(facing);
}

fn on_triangle(k: u32, a: i32, b: i32) -> vec3<f32> {
  let at = place(k).xyz;
  let area = cross(place(u32(a)).xyz - at, place(u32(b)).xyz - at) * 0.5;
  let middle = (at + place(u32(a)).xyz + place(u32(b)).xyz) * (1.0 / 3.0);
  let earlier = (was(k) + was(u32(a)) + was(u32(b))) * (1.0 / 3.0);
  return force(area, air(middle) - (middle - earlier) * step.rate);
}

fn blow(g: u32, cell: vec2<u32>, k: u32) {
  let grid = grids_at(g);
  let w = max(place(k).w, 0.0);
  var sum = vec3<f32>(0.0);
  if (w > 0.0) {
    for (var quadrant = 0u; quadrant < 4u; quadrant++) {
      let t = triangles(grid, cell.x, cell.y, quadrant);
      if (t.x >= 0) {
        sum += on_triangle(k, t.x, t.y);
      }
      if (t.z >= 0) {
        sum += on_triangle(k, t.z, t.w);
      }
    }
  }
  set_field(k, vec4<f32>(sum * (w * (1.0 / 3.0)), 0.0));
}
