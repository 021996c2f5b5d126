// Cloth that was never cut.
fn removed(k: u32) -> u32 {
  return 0u;
}
