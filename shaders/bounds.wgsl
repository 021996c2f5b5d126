// The box around 64 particles, now and one step before, and their largest squared displacement. Every number is the
// largest of all, as bits that are ordered as numbers are; the low corner has its sign changed.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> before: array<vec4<f32>>;
@group(0) @binding(45) var<storage, read_write> bounds: array<atomic<u32>>;

var<workgroup> shared_low: array<vec3<f32>, 64>;
var<workgroup> shared_high: array<vec3<f32>, 64>;
var<workgroup> shared_far: array<f32, 64>;

// Above 0 for every number, so that 0 is none.
fn ordered(x: f32) -> u32 {
  let bits = bitcast<u32>(x);
  return select(bits | 0x80000000u, ~bits, (bits >> 31u) == 1u);
}

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let k = element(workgroup, rows, local);
  var low = vec3<f32>(FARTHEST);
  var high = vec3<f32>(-FARTHEST);
  var far = 0.0;
  if (k < arrayLength(&now)) {
    let p = now[k];
    let q = before[k];
    if (p.w >= 0.0 && sane(p) && sane(q)) {
      low = min(p.xyz, q.xyz);
      high = max(p.xyz, q.xyz);
      far = dot(p.xyz - q.xyz, p.xyz - q.xyz);
    }
  }
  shared_low[local] = low;
  shared_high[local] = high;
  shared_far[local] = far;
  workgroupBarrier();
  for (var half = 32u; half > 0u; half /= 2u) {
    if (local < half) {
      shared_low[local] = min(shared_low[local], shared_low[local + half]);
      shared_high[local] = max(shared_high[local], shared_high[local + half]);
      shared_far[local] = max(shared_far[local], shared_far[local + half]);
    }
    workgroupBarrier();
  }
  if (local == 0u && shared_low[0].x <= shared_high[0].x) {
    for (var c = 0u; c < 3u; c++) {
      atomicMax(&bounds[c], ordered(-shared_low[0][c]));
      atomicMax(&bounds[3u + c], ordered(shared_high[0][c]));
    }
    atomicMax(&bounds[6], bitcast<u32>(shared_far[0]));
  }
}
