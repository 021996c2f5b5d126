// Cloth without seams.
fn tie(head: vec4<u32>, local: u32, n: u32) {
}
