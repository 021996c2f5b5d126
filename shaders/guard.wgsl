// Counts the particles whose position is NaN or out of bounds.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
// Such particles in this frame, frames taken back, and one more than the last of such particles.
@group(0) @binding(23) var<storage, read_write> faults: array<atomic<u32>, 4>;

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let k = element(workgroup, rows, local);
  if (k >= arrayLength(&now)) {
    return;
  }
  let p = now[k];
  if (p.w >= 0.0 && !sane(p)) {
    atomicAdd(&faults[0], 1u);
    atomicMax(&faults[2], k + 1u);
  }
}
