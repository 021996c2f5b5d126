// The multiplier of bending at each texel: the Laplacian of position over what a step of this length makes of its
// compliance, or over the bound with which no step goes too far. w is 1 where there is one.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(26) var<storage, read> bends: array<vec2<f32>>;
@group(0) @binding(27) var<storage, read_write> moments: array<vec4<f32>>;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  if (id.x >= grid.width || id.y >= grid.height) {
    return;
  }
  let k = grid.first + id.y * grid.width + id.x;
  let bend = bends[k];
  var whole = bend.x > 0.0;
  var sum = vec3<f32>(0.0);
  if (whole) {
    let at = now[k].xyz;
    for (var n = 0u; n < 8u; n++) {
      let e = edge(grid, id.xy, n);
      if (e.weight != 0.0) {
        sum += (now[e.other].xyz - at) * e.weight;
        whole = whole && unbroken(e);
      }
    }
  }
  let scale = 1.0 / max(bend.x / (step.dt * step.dt), bend.y);
  moments[k] = select(vec4<f32>(0.0), vec4<f32>(sum * scale, 1.0), whole);
}
