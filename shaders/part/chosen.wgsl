// An action on each entry of a list of particles.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let n = element(workgroup, rows, local);
  if (n >= arrayLength(&chosen)) {
    return;
  }
  act(n);
}
