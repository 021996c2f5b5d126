// Positions in the memory of the workgroup, where there is room for three numbers each: inverse masses, which do not
// change, are read from where they lie.
override places: u32 = 64u;
override numbers: u32 = 192u;
var<workgroup> held: array<f32, numbers>;

fn place(k: u32) -> vec4<f32> {
  let n = k - base;
  return vec4<f32>(held[n], held[n + places], held[n + 2u * places], now[k].w);
}

fn put(k: u32, p: vec4<f32>) {
  let n = k - base;
  held[n] = p.x;
  held[n + places] = p.y;
  held[n + 2u * places] = p.z;
}

fn take(k: u32) {
  put(k, now[k]);
}

fn sync() {
  workgroupBarrier();
}
