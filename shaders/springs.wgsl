// One of eight passes: springs of one direction and parity have no particle in common, so ends are moved in place.
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
  let length = rest_length(id.z, k, direction);
  let a = now[k];
  let b = now[other];
  let sum = a.w + b.w;
  if (length <= 0.0 || min(a.w, b.w) < 0.0 || sum <= 0.0) {
    return;
  }
  let d = b.xyz - a.xyz;
  let far = max(sqrt(dot(d, d)), 1e-9);
  let by = d * (1.0 - length / far);
  now[k] = vec4<f32>(a.xyz + by * (a.w / sum), a.w);
  now[other] = vec4<f32>(b.xyz - by * (b.w / sum), b.w);
}
