// Cloth without seams.
fn is_kin(k: u32, other: u32) -> bool {
  return false;
}
