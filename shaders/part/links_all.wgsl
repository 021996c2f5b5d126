// Cloth that was never cut: everything follows all nodes around it.
fn followed(k: u32) -> u32 {
  return 15u;
}
