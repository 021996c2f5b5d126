// The numbers of one step. Laid out as `Step` in crates/runtime/src/layout.rs.
struct Step {
  gravity: vec3<f32>,
  keep: f32,
  wind: vec3<f32>,
  scale: f32,
  drift: vec3<f32>,
  response: f32,
  turn: f32,
  fineness: f32,
  longest: f32,
  dt: f32,
  rate: f32,
  drag: f32,
  lift: f32,
  left: f32,
}
