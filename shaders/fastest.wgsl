// The largest squared displacement of all workgroups. One workgroup.
@group(0) @binding(15) var<storage, read> partial: array<f32>;
@group(0) @binding(16) var<storage, read_write> fastest: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(local_invocation_index) local: u32) {
  var far = 0.0;
  for (var n = local; n < arrayLength(&partial); n += 64u) {
    far = larger(far, partial[n]);
  }
  far = most(far, local);
  if (local == 0u) {
    fastest[0] = far;
  }
}
