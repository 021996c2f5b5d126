// Cloth that was never cut: everything follows all nodes around it.
fn followed(k: u32) -> u32 {
  return 15u;
}

fn followed_by_node(n: u32) -> u32 {
  return 15u;
}
