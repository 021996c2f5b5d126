// Of the colliders of all coats, those that the workgroup's cloth meets.
fn solid_count() -> u32 {
  return frame.solids;
}

fn solid_at(c: u32) -> Solid {
  return solids[first_solid + c];
}
