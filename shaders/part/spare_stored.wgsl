// A number per thread. Positions lie in storage, so the memory of the workgroup has room.
var<workgroup> spares: array<f32, threads>;

fn spare(n: u32) -> f32 {
  return spares[n];
}

fn set_spare(n: u32, x: f32) {
  spares[n] = x;
}
