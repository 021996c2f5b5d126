// Positions one step before, four numbers per particle; those after the step lie elsewhere.
@group(0) @binding(3) var<storage, read> before: array<vec4<f32>>;
@group(0) @binding(35) var<storage, read_write> passed: array<vec4<f32>>;

fn earlier(k: u32) -> vec3<f32> {
  return before[k].xyz;
}

fn pass_on(k: u32, p: vec4<f32>) {
  passed[k] = p;
}

fn carry(k: u32) {
  passed[k] = before[k];
}
