// The motion of a finer image, from that of the coarser one: on its triangles, pins between coarse texels beside theirs.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;
// Two rows for each pin between coarse texels, in ascending order: its fine particle and its coarse one, and the way from the latter.
@group(0) @binding(62) var<storage, read> beside: array<vec4<u32>>;

// The row of a pin beside which particle `k` is, or of the first one behind it.
fn pin_of(k: u32) -> u32 {
  var low = 0u;
  var high = arrayLength(&beside) / 2u;
  while (low < high) {
    let middle = (low + high) / 2u;
    if (beside[2u * middle].x < k) {
      low = middle + 1u;
    } else {
      high = middle;
    }
  }
  return low;
}

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let k = element(workgroup, rows, local);
  if (k >= table[0]) {
    return;
  }
  let corners = stencil_ends(k);
  let parts = stencil_weights(k);
  var p = origin[corners.x].xyz * parts.x + origin[corners.y].xyz * parts.y + origin[corners.z].xyz * parts.z;
  var b = origin_before[corners.x].xyz * parts.x + origin_before[corners.y].xyz * parts.y + origin_before[corners.z].xyz * parts.z;
  let pin = pin_of(k);
  if (pin < arrayLength(&beside) / 2u) {
    let ends = beside[2u * pin].xy;
    if (ends.x == k) {
      let way = bitcast<vec4<f32>>(beside[2u * pin + 1u]).xyz;
      p = origin[ends.y].xyz + way;
      b = origin_before[ends.y].xyz + way;
    }
  }
  let w = now[k].w;
  now[k] = vec4<f32>(p, w);
  before[k] = vec4<f32>(b, w);
}
