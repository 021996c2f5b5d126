// The normal of every particle from the triangles around it, weighed by area; w is the length of their sum.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> normals: array<vec4<f32>>;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  if (id.x >= grid.width || id.y >= grid.height) {
    return;
  }
  let k = grid.first + id.y * grid.width + id.x;
  let p = now[k];
  var sum = vec3<f32>(0.0);
  if (p.w >= 0.0) {
    for (var quadrant = 0u; quadrant < 4u; quadrant++) {
      let t = triangles(grid, id.x, id.y, quadrant);
      if (t.x >= 0) {
        sum += cross(now[t.x].xyz - p.xyz, now[t.y].xyz - p.xyz);
      }
      if (t.z >= 0) {
        sum += cross(now[t.z].xyz - p.xyz, now[t.w].xyz - p.xyz);
      }
    }
  }
  normals[k] = unit(sum);
}
