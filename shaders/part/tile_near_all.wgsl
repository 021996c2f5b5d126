// So few colliders that all are tried.
fn gather_all(local: u32, owned: vec2<u32>, columns: u32) {}
