// Effect of air on the triangles around each particle, as an acceleration: a third of each triangle's force.
// Drag along the flow, lift across it in the plane of flow and normal, both as the area that faces the wind.

// The velocity of the air at a particle.
fn flow_at(k: u32) -> vec3<f32> {
  return air_at(k) - (place(k).xyz - was(k)) * step.rate;
}

// 18 times the force, from twice the area as a vector across the triangle, and three times the flow past it.
fn force(area: vec3<f32>, flow: vec3<f32>) -> vec3<f32> {
  let facing = dot(area, flow);
  let square = dot(flow, flow);
  let root = sqrt(max(square * dot(area, area), 1e-36));
  let lift = facing * (step.lift / root);
  return flow * (step.drag * abs(facing) - facing * lift) + area * (square * lift);
}

fn on_triangle(k: u32, own: vec3<f32>, a: i32, b: i32) -> vec3<f32> {
  let at = place(k).xyz;
  let area = cross(place(u32(a)).xyz - at, place(u32(b)).xyz - at);
  return force(area, own + flow_at(u32(a)) + flow_at(u32(b)));
}

fn blow(g: u32, cell: vec2<u32>, k: u32) {
  let grid = grids_at(g);
  let w = max(place(k).w, 0.0);
  var sum = vec3<f32>(0.0);
  if (w > 0.0) {
    let own = flow_at(k);
    for (var quadrant = 0u; quadrant < 4u; quadrant++) {
      let t = triangles(grid, cell.x, cell.y, quadrant);
      if (t.x >= 0) {
        sum += on_triangle(k, own, t.x, t.y);
      }
      if (t.z >= 0) {
        sum += on_triangle(k, own, t.z, t.w);
      }
    }
  }
  set_field(k, vec4<f32>(sum * (w * (1.0 / 54.0)), 0.0));
}
