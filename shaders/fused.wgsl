// The whole frame of a cloth by one workgroup: every step, from the integration to the contact, then what ends a frame.
// A workgroup a cloth. A frame with much work is several dispatches, each of which makes some of its steps. `gust_program`,
// `air_program`, `step_program`, `coarse_program`, `round_program` and `frame_program` are made from the schedule: the rules of the separate passes, in the same
// order, with a barrier after each. `find_lists` and the places of lists, `NAME_from`, are made by
// crates/runtime/src/shaders/lists.rs.
override threads: u32 = 64u;

// The particle at hand among those of the thread, which has the same in every pass: every `threads`-th one.
var<private> mine: u32;

@compute @workgroup_size(threads)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) local: u32) {
  let job = jobs_at(batch.x + workgroup.x);
  find_lists(job);
  base = job.first;
  row = job.row;
  first_solid = job.solid;
  let first_step = part.x * frame.most;
  let end_step = min(first_step + frame.most, frame.steps);
  for (mine = 0u; has_more(job.count); mine++) {
    let k = job.first + local + mine * threads;
    if (k < job.first + job.count) {
      take(k);
      take_was(k);
      take_own(k);
    }
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
    if (n == 0u) {
      gust_program(job, local);
    }
    if (n % job.hold == 0u) {
      air_program(job, local);
    }
    step_program(job, local);
    coarse_program(n, job, local);
    for (var r = 0u; r < frame.rounds; r++) {
      round_program(job, local);
    }
  }
  for (mine = 0u; has_more(job.count); mine++) {
    let k = job.first + local + mine * threads;
    if (k < job.first + job.count) {
      let p = place(k);
      now[k] = p;
      give_was(k, p.w);
    }
  }
  storageBarrier();
  if (end_step == frame.steps) {
    frame_program(job, local);
  }
}
