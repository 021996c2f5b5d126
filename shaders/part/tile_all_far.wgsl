// No list of the colliders that are near.
fn find_near(local: u32) {}
