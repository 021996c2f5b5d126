// One of eight passes: springs with compliance, of one direction and parity, so that none has a particle in common.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;

// 0 right, 1 down, 2 down-right, 3 up-right; the parity is that of the column for "right", else of the upper row.
override direction: u32 = 0u;
override parity: u32 = 0u;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  var i = id.x;
  var j = id.y;
  if (direction == 0u) {
    i = 2u * i + parity;
  } else {
    j = 2u * j + parity;
  }
  let right = u32(direction != 1u);
  let down = u32(direction != 0u);
  if (i + right >= grid.width || j + down >= grid.height) {
    return;
  }
  var k = grid.first + j * grid.width + i;
  var other = k + down * grid.width + right;
  if (direction == 3u) {
    other = k + 1u;
    k = k + grid.width;
  }
  let rest = rest_length(id.z, k, direction);
  let a = now[k];
  let b = now[other];
  if (rest <= 0.0 || min(a.w, b.w) < 0.0) {
    return;
  }
  let d = b.xyz - a.xyz;
  let far = max(sqrt(dot(d, d)), 1e-9);
  let g = multiplier(id.z, k, direction, far, rest, a.w + b.w);
  now[k] = vec4<f32>(a.xyz + d * (g * a.w), a.w);
  now[other] = vec4<f32>(b.xyz - d * (g * b.w), b.w);
}
