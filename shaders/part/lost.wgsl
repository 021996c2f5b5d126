// What positions are too coarse for, of each particle, where it lies.
@group(0) @binding(28) var<storage, read_write> lost: array<vec4<f32>>;

fn lose(k: u32, what: vec4<f32>) {
  lost[k] = what;
}
