// Positions in the memory of the workgroup.
override places: u32 = 64u;
var<workgroup> held: array<vec4<f32>, places>;

fn place(k: u32) -> vec4<f32> {
  return held[k - base];
}

fn put(k: u32, p: vec4<f32>) {
  held[k - base] = p;
}

fn take(k: u32) {
  held[k - base] = now[k];
}

fn sync() {
  workgroupBarrier();
}
