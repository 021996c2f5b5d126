// No list of the colliders that are near.
fn find_near(ring: u32, work: vec3<u32>, local: u32) {}
