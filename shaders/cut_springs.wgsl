// Springs that are an edge of a triangle that is cut away, or that cross it in its quad, get the rest length 0, which
// means no spring. One thread per texel, which owns its four springs.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> rest: array<vec4<f32>>;

@compute @workgroup_size(16, 4)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
  let grid = grids[id.z];
  if (id.x >= grid.width || id.y >= grid.height) {
    return;
  }
  let i = i32(id.x);
  let j = i32(id.y);
  let here = sides(grid, i, j).y;
  let left = sides(grid, i - 1, j).y;
  let above = sides(grid, i, j - 1).y;
  let cut = vec4<bool>(
    ((here & 2u) | (above & 1u)) != 0u,
    ((here & 1u) | (left & 2u)) != 0u,
    here != 0u,
    above != 0u);
  let k = grid.first + id.y * grid.width + id.x;
  rest[k] = select(rest[k], vec4<f32>(0.0), cut);
}
