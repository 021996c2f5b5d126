// The nearest triangle that a ray meets, one candidate a workgroup; after T. Moeller and B. Trumbore, "Fast, Minimum
// Storage Ray-Triangle Intersection", 1997, from both sides.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(13) var<storage, read_write> candidates: array<vec4<u32>>;

// An edge belongs to both of its triangles, so that no ray slips through between them.

fn meet(corners: vec3<u32>, code: u32) -> vec4<u32> {
  let a = now[corners.x].xyz;
  let e = now[corners.y].xyz - a;
  let f = now[corners.z].xyz - a;
  let s = action[0].xyz - a;
  let d = action[1].xyz;
  let h = cross(d, f);
  let det = dot(e, h);
  if (det == 0.0) {
    return NOTHING;
  }
  let over = 1.0 / det;
  let v = dot(s, h) * over;
  let q = cross(s, e);
  let w = dot(d, q) * over;
  let t = dot(f, q) * over;
  // Written so that no number is outside too.
  if (!(v >= -EDGE && w >= -EDGE && v + w <= 1.0 + EDGE && t >= 0.0 && t < 3.4e38)) {
    return NOTHING;
  }
  return vec4<u32>(bitcast<u32>(abs(t)), code, bitcast<u32>(v), bitcast<u32>(w));
}

@compute @workgroup_size(16, 4)
fn main(
  @builtin(global_invocation_id) id: vec3<u32>,
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) groups: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let grid = grids[id.z];
  let k = grid.first + id.y * grid.width + id.x;
  let q = quad(grid, id.x, id.y);
  var best = NOTHING;
  if (q.count > 0u) {
    let bits = removed(k);
    if ((bits & 1u) == 0u) {
      best = meet(q.first, 2u * k);
    }
    if (q.count > 1u && (bits & 2u) == 0u) {
      best = nearer(best, meet(q.second, 2u * k + 1u));
    }
  }
  best = nearest(best, local);
  if (local == 0u) {
    candidates[(workgroup.z * groups.y + workgroup.y) * groups.x + workgroup.x] = best;
  }
}
