// Where particles are, only to be read.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;

fn place(k: u32) -> vec4<f32> {
  return now[k];
}
