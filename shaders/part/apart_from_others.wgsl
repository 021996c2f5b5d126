// Cloth that meets no other cloth.
fn meet_others(k: u32, p: vec4<f32>, moved: vec3<f32>) {}
