// Of the colliders of all coats, those that the workgroup's cloth meets.
var<private> first_solid: u32;

fn solid_count() -> u32 {
  return frame.solids;
}

fn solid_at(c: u32) -> Solid {
  return solids[first_solid + c];
}
