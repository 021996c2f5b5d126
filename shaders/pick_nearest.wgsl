// The nearest candidate of all workgroups, and where the corners of its triangle are. One workgroup.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(13) var<storage, read> candidates: array<vec4<u32>>;
@group(0) @binding(14) var<storage, read_write> found: array<vec4<u32>>;

fn corner(k: u32) -> vec4<u32> {
  return vec4<u32>(bitcast<vec3<u32>>(now[k].xyz), k);
}

@compute @workgroup_size(64)
fn main(@builtin(local_invocation_index) local: u32) {
  var best = NOTHING;
  for (var c = local; c < arrayLength(&candidates); c += 64u) {
    best = nearer(best, candidates[c]);
  }
  best = nearest(best, local);
  if (local > 0u) {
    return;
  }
  found[0] = best;
  if (best.x == NOTHING.x) {
    return;
  }
  let k = best.y / 2u;
  var g = 0u;
  var more = true;
  for (var n = 1u; n < arrayLength(&grids) && more; n++) {
    more = grids[n].first <= k;
    g = select(g, n, more);
  }
  let at = k - grids[g].first;
  let q = quad(grids[g], at % grids[g].width, at / grids[g].width);
  let corners = select(q.first, q.second, best.y % 2u == 1u);
  found[1] = corner(corners.x);
  found[2] = corner(corners.y);
  found[3] = corner(corners.z);
}
