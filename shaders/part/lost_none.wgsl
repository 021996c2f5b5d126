// Cloth that keeps no remainders.
fn clear_lost(k: u32) {}
