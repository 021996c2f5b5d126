// Boxes around 2 x 2 boxes, level by level, from those of tiles up. One workgroup for all grids.
@group(0) @binding(67) var<storage, read> kin: array<u32>;
@group(0) @binding(69) var<storage, read_write> boxes: array<vec4<f32>>;

const GROUP: u32 = 256u;

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) local: u32) {
  for (var g = 0u; g < arrayLength(&grids); g++) {
    let table = kin[kin[2] + 2u * g];
    let levels = kin[kin[2] + 2u * g + 1u];
    for (var n = 1u; n < levels; n++) {
      let row = table + 3u * n;
      let below = vec3<u32>(kin[row - 3u], kin[row - 2u], kin[row - 1u]);
      let level = vec3<u32>(kin[row], kin[row + 1u], kin[row + 2u]);
      for (var m = local; m < level.y * level.z; m += GROUP) {
        let corner = 2u * vec2<u32>(m % level.y, m / level.y);
        var low = vec3<f32>(FARTHEST);
        var high = vec3<f32>(-FARTHEST);
        for (var c = 0u; c < 4u; c++) {
          let cell = corner + vec2<u32>(c % 2u, c / 2u);
          if (cell.x < below.y && cell.y < below.z) {
            let node = below.x + cell.y * below.y + cell.x;
            low = min(low, boxes[2u * node].xyz);
            high = max(high, boxes[2u * node + 1u].xyz);
          }
        }
        let node = level.x + m;
        boxes[2u * node] = vec4<f32>(low, 0.0);
        boxes[2u * node + 1u] = vec4<f32>(high, 0.0);
      }
      storageBarrier();
    }
  }
}
