// A cut may run between a node and a neighbour of its duplicate: only duplicates are tied.
fn ties_end(row: vec4<u32>) -> u32 {
  return row.z;
}
