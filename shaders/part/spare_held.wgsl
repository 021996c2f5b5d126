// A number per thread, in the memory of the positions: these are back in their buffer when a frame ends.
fn spare(n: u32) -> f32 {
  return held[n].x;
}

fn set_spare(n: u32, x: f32) {
  held[n].x = x;
}
