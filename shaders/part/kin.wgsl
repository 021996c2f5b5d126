// Whether a particle is near another on the surface, by way of a seam.
fn is_kin(k: u32, other: u32) -> bool {
  let end = kin[kin[4] + k + 1u];
  for (var n = kin[kin[4] + k]; n < end; n++) {
    if (kin[kin[5] + n] == other) {
      return true;
    }
  }
  return false;
}
