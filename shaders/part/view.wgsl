// Parameters of a picture. Laid out as `ViewRow` in crates/runtime/src/draw/rows.rs. Colours are linear.
struct View {
  clip: mat4x4<f32>,
  eye: vec3<f32>,
  fraction: f32,
  middle: vec3<f32>,
  tiles: f32,
  background: vec3<f32>,
  shade: f32,
  light: vec3<f32>,
  jump: f32,
  front: vec4<f32>,
  back: vec4<f32>,
}
@group(0) @binding(0) var<uniform> view: View;

// A corner of a triangle; the fourth component of `back` is the distance at which the surface has faded, 0 for never.
struct Corner {
  at: vec3<f32>,
  normal: vec3<f32>,
  uv: vec2<f32>,
  front: vec4<f32>,
  back: vec4<f32>,
}
