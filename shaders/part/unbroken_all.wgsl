// Cloth that was never cut.
fn unbroken(edge: Edge) -> bool {
  return true;
}
