// The triangles of a bound mesh that are left of a cloth that was cut: a thread a pair of a triangle of the cloth, twice the texel of its quad
// plus 1 for the second one, and a triangle of the mesh that covers it, which becomes a point if the former is cut away. Threads of one
// triangle write the same.
@group(0) @binding(82) var<storage, read> covers: array<vec2<u32>>;
@group(0) @binding(83) var<storage, read> mesh_indices: array<u32>;
@group(0) @binding(84) var<storage, read_write> left_indices: array<u32>;

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let n = element(workgroup, rows, local);
  if (n >= arrayLength(&covers)) {
    return;
  }
  let pair = covers[n];
  if ((removed(pair.x >> 1u) >> (pair.x & 1u) & 1u) == 1u) {
    let first = mesh_indices[3u * pair.y];
    left_indices[3u * pair.y + 1u] = first;
    left_indices[3u * pair.y + 2u] = first;
  }
}
