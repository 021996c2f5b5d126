// Takes away the triangles of each quad that the cutting triangle meets. A thread a quad, which owns its bits.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read_write> holes: array<u32>;

// Whether an axis separates the triangle 0, a.., from b... The margin, 1e-6 of the reach, is above all rounding, so
// that no triangle that is met is missed, whatever the order of its corners: both sides of a seam answer alike.
fn separates(axis: vec3<f32>, a: mat2x3<f32>, b: mat3x3<f32>, reach: f32) -> bool {
  let x = axis * a;
  let y = axis * b;
  let margin = dot(abs(axis), vec3<f32>(reach * 1e-6));
  let low = min(0.0, min(x.x, x.y)) - max(y.x, max(y.y, y.z));
  let high = min(y.x, min(y.y, y.z)) - max(0.0, max(x.x, x.y));
  return max(low, high) > margin;
}

fn largest(v: vec3<f32>) -> f32 {
  return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

// Separating axes, those of flat and of degenerate pairs among them; an axis of no length separates nothing.
fn meets(corners: vec3<u32>) -> bool {
  let origin = now[corners.x].xyz;
  let a = mat2x3<f32>(now[corners.y].xyz - origin, now[corners.z].xyz - origin);
  let b = mat3x3<f32>(action[0].xyz - origin, action[1].xyz - origin, action[2].xyz - origin);
  let reach = max(max(largest(a[0]), largest(a[1])), max(largest(b[0]), max(largest(b[1]), largest(b[2]))));
  var e = array<vec3<f32>, 3>(a[0], a[1] - a[0], -a[1]);
  var f = array<vec3<f32>, 3>(b[1] - b[0], b[2] - b[1], b[0] - b[2]);
  for (var k = 0u; k < 3u; k++) {
    var axis = vec3<f32>(0.0);
    axis[k] = 1.0;
    if (separates(axis, a, b, reach)) {
      return false;
    }
  }
  let m = cross(e[0], e[1]);
  let n = cross(f[0], f[1]);
  if (separates(m, a, b, reach) || separates(n, a, b, reach)) {
    return false;
  }
  for (var k = 0u; k < 3u; k++) {
    if (separates(cross(m, e[k]), a, b, reach) || separates(cross(n, f[k]), a, b, reach)) {
      return false;
    }
    for (var l = 0u; l < 3u; l++) {
      if (separates(cross(e[k], f[l]), a, b, reach)) {
        return false;
      }
    }
  }
  return true;
}

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  if (id.x >= grid.width || id.y >= grid.height) {
    return;
  }
  let q = quad(grid, id.x, id.y);
  let k = grid.first + id.y * grid.width + id.x;
  var bits = holes[k];
  if (q.count > 0u && (bits & 1u) == 0u) {
    bits |= u32(meets(q.first));
  }
  if (q.count > 1u && (bits & 2u) == 0u) {
    bits |= u32(meets(q.second)) << 1u;
  }
  holes[k] = bits;
}
