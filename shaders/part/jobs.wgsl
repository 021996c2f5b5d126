// Cloths that lie in the same buffers: the numbers of a frame, and what a workgroup does for which of them.
// Laid out as `FrameRow` in crates/runtime/src/layout.rs. Rows: the first step, then one for each group of steps.
struct Frame {
  steps: u32,
  rounds: u32,
  together: u32,
  solids: u32,
  // Steps of a dispatch, but for the last.
  most: u32,
  // Steps from one with the passes on coarser grids to the next.
  pyramid: u32,
  unused1: u32,
  unused2: u32,
  rows: array<Step, 129>,
}
@group(0) @binding(31) var<uniform> frame: Frame;
// Where the jobs of the dispatch begin, as x, and how many grids each has at most, as y.
@group(0) @binding(52) var<uniform> batch: vec4<u32>;
// In whole frames, x is the number of the dispatch in the frame. Else x is the step, y is one more than the step whose last passes this
// dispatch makes first, 0 for none, and z is 1 in the first dispatch of the frame.
@group(0) @binding(53) var<uniform> part: vec4<u32>;

// Which part of the buffers is a cloth's, and its own numbers of the first and of the other steps. Laid out as `JobRow`.
struct Job {
  first: u32,
  count: u32,
  grid: u32,
  grids: u32,
  ring: u32,
  rings: u32,
  row: u32,
  solid: u32,
  keep: vec2<f32>,
  longest: vec2<f32>,
  // Steps from one with the forces of air to the next.
  hold: u32,
  // Where its images begin in lists by texels, which instances of a cloth share.
  image: u32,
  // Colliders that the cloth meets.
  solids: u32,
  // Most coarser levels of a grid; 0 without a pyramid.
  levels: u32,
  // Acceleration and wind in the frame of reference of the cloth.
  gravity: vec4<f32>,
  wind: vec4<f32>,
}
// The lists that frames only read, of all cloths that lie in the same buffers. The head has the place of each list, and the number of
// particles that there is room for.
@group(0) @binding(49) var<storage, read> lists: array<vec4<u32>>;

fn jobs_at(n: u32) -> Job {
  let k = jobs_from + 6u * n;
  let a = lists[k];
  let b = lists[k + 1u];
  let c = bitcast<vec4<f32>>(lists[k + 2u]);
  let d = lists[k + 3u];
  let gravity = bitcast<vec4<f32>>(lists[k + 4u]);
  let wind = bitcast<vec4<f32>>(lists[k + 5u]);
  return Job(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.xy, c.zw, d.x, d.y, d.z, d.w, gravity, wind);
}

fn grids_at(g: u32) -> Grid {
  let k = grids_from + 2u * g;
  let a = lists[k];
  return Grid(a.x, a.y, a.z, bitcast<f32>(a.w), bitcast<vec4<f32>>(lists[k + 1u]));
}

var<private> step: Step;
// The cloth's first particle, and its row of faults.
var<private> base: u32;
var<private> row: u32;
// The first collider that the cloth meets.
var<private> first_solid: u32;

fn fault(n: u32) -> u32 {
  return FAULT_STRIDE * row + n;
}

fn begin(n: u32, job: Job) {
  step = frame.rows[select(1u + n / frame.together, 0u, n == 0u)];
  step.keep = job.keep[min(n, 1u)];
  step.longest = job.longest[min(n, 1u)];
  step.gravity = job.gravity.xyz;
  step.wind = job.wind.xyz;
}
