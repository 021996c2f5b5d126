// Of the colliders of all coats, those that the workgroup's cloth meets, of which each cloth may have another number.
fn solid_count() -> u32 {
  return cloth.solids;
}

fn solid_at(c: u32) -> Solid {
  return solids[first_solid + c];
}
