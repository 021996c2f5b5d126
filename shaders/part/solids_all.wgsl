// All colliders that are bound are the cloth's.
fn solid_count() -> u32 {
  return arrayLength(&solids);
}

fn solid_at(c: u32) -> Solid {
  return solids[c];
}
