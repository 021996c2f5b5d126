// Those between neighbours of a seam point too.
fn ties_end(row: vec4<u32>) -> u32 {
  return row.y;
}
