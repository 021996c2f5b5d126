// Positions one step before, in the memory of the workgroup until the frame ends.
override befores: u32 = 192u;
var<workgroup> held_before: array<f32, befores>;

fn was(k: u32) -> vec3<f32> {
  let n = 3u * (k - base);
  return vec3<f32>(held_before[n], held_before[n + 1u], held_before[n + 2u]);
}

fn set_was(k: u32, p: vec4<f32>) {
  let n = 3u * (k - base);
  held_before[n] = p.x;
  held_before[n + 1u] = p.y;
  held_before[n + 2u] = p.z;
}

fn take_was(k: u32) {
  set_was(k, before[k]);
}

fn give_was(k: u32, w: f32) {
  before[k] = vec4<f32>(was(k), w);
}
