// One grid of particles. Laid out as `GridRow` in crates/runtime/src/layout.rs.
struct Grid {
  first: u32,
  width: u32,
  height: u32,
  soft: f32,
  rest: vec4<f32>,
}
