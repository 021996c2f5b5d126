// The multipliers of the last step end with it.
@group(0) @binding(18) var<storage, read_write> sums: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let k = element(workgroup, rows, local);
  if (k < arrayLength(&sums)) {
    sums[k] = vec4<f32>(0.0);
  }
}
