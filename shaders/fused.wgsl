// The whole frame of a cloth by one workgroup: every step, from the integration to the contact, then what ends a frame.
// A workgroup a cloth. A frame with much work is several dispatches, each of which makes some of its steps. `air_program`,
// `step_program`, `round_program` and `frame_program` are made from the schedule: the rules of the separate passes, in the same
// order, with a barrier after each. `find_lists` and the places of lists, `NAME_from`, are made by
// crates/runtime/src/shaders/lists.rs.
// Laid out as `FrameRow` in crates/runtime/src/layout.rs. Rows: the first step, then one for each group of steps.
struct Frame {
  steps: u32,
  rounds: u32,
  together: u32,
  solids: u32,
  // Steps of a dispatch, but for the last.
  most: u32,
  unused1: u32,
  unused2: u32,
  unused3: u32,
  rows: array<Step, 129>,
}
@group(0) @binding(31) var<uniform> frame: Frame;
// Where the jobs of the dispatch begin, as x.
@group(0) @binding(52) var<uniform> batch: vec4<u32>;
// Which of the frame's dispatches it is, as x.
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
  unused1: u32,
  unused2: u32,
}
// The lists that frames only read, of all cloths that lie in the same buffers. The head has the place of each list, and the number of
// particles that there is room for.
@group(0) @binding(49) var<storage, read> lists: array<vec4<u32>>;

fn jobs_at(n: u32) -> Job {
  let k = jobs_from + 4u * n;
  let a = lists[k];
  let b = lists[k + 1u];
  let c = bitcast<vec4<f32>>(lists[k + 2u]);
  let d = lists[k + 3u];
  return Job(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.xy, c.zw, d.x, d.y, 0u, 0u);
}

fn grids_at(g: u32) -> Grid {
  let k = grids_from + 2u * g;
  let a = lists[k];
  return Grid(a.x, a.y, a.z, bitcast<f32>(a.w), bitcast<vec4<f32>>(lists[k + 1u]));
}

override threads: u32 = 64u;

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
}

@compute @workgroup_size(threads)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) local: u32) {
  let job = jobs_at(batch.x + workgroup.x);
  find_lists(job);
  base = job.first;
  row = job.row;
  first_solid = job.solid;
  let first_step = part.x * frame.most;
  let end_step = min(first_step + frame.most, frame.steps);
  for (var k = job.first + local; k < job.first + job.count; k += threads) {
    take(k);
    take_was(k);
  }
  if (local == 0u && first_step == 0u) {
    atomicStore(&faults[fault(FAULT_PARTICLES)], 0u);
    atomicStore(&faults[fault(FAULT_SPEED)], 0u);
    atomicStore(&faults[fault(FAULT_STRAIN)], 0u);
  }
  storageBarrier();
  sync();
  for (var n = first_step; n < end_step; n++) {
    begin(n, job);
    if (n % job.hold == 0u) {
      air_program(job, local);
    }
    step_program(job, local);
    for (var r = 0u; r < frame.rounds; r++) {
      round_program(job, local);
    }
  }
  for (var k = job.first + local; k < job.first + job.count; k += threads) {
    let p = place(k);
    now[k] = p;
    give_was(k, p.w);
  }
  storageBarrier();
  if (end_step == frame.steps) {
    frame_program(job, local);
  }
}
