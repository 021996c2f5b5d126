// Boxes around the patches of a surface at the start of the frame, a thread a patch. `surface_boxes` has three rows each: the low corner, the
// high corner, and a vertex in the middle; their fourth numbers are how that vertex goes in the frame.
@group(0) @binding(94) var<storage, read> surface_vertices: array<vec4<f32>>;
@group(0) @binding(96) var<storage, read_write> surface_boxes: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let n = element(workgroup, rows, local);
  if (n >= patch_count()) {
    return;
  }
  var low = vec3<f32>(3.4e38);
  var high = vec3<f32>(-3.4e38);
  let end = patch_start(n + 1u);
  for (var k = patch_start(n); k < end; k++) {
    let corners = surface_triangles[2u * ordered_triangle(k)].xyz;
    for (var c = 0u; c < 3u; c++) {
      let p = start_of(corners[c]);
      low = min(low, p);
      high = max(high, p);
    }
  }
  let middle = surface_triangles[2u * patch_middle(n)].x;
  let way = end_of(middle) - start_of(middle);
  surface_boxes[3u * n] = vec4<f32>(low, way.x);
  surface_boxes[3u * n + 1u] = vec4<f32>(high, way.y);
  surface_boxes[3u * n + 2u] = vec4<f32>(start_of(middle), way.z);
}
