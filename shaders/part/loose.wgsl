// A duplicate of a seam point before the seams are closed.
fn loose(k: u32) -> vec4<f32> {
  return place(k);
}
