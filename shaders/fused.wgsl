// The whole frame of a cloth by one workgroup: every step, from the integration to the contact, then what ends a frame.
// A workgroup a cloth. The rules are those of the separate passes, in the same order, with a barrier between colours.
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;
@group(0) @binding(23) var<storage, read_write> faults: array<atomic<u32>>;
@group(0) @binding(24) var<storage, read_write> good: array<vec4<f32>>;

// Laid out as `FrameRow` in crates/runtime/src/gpu/layout.rs. Rows: the first step, then one for each group of steps.
struct Frame {
  steps: u32,
  rounds: u32,
  together: u32,
  solids: u32,
  rows: array<Step, 129>,
}
@group(0) @binding(31) var<uniform> frame: Frame;

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
}
@group(0) @binding(32) var<storage, read> jobs: array<Job>;

override threads: u32 = 64u;
override right: bool = true;
override down: bool = true;
override down_right: bool = true;
override up_right: bool = true;
// Further rounds of tethers and of springs to the right and down.
override polish: u32 = 0u;

var<private> step: Step;
// The cloth's first particle, and its row of faults.
var<private> base: u32;
var<private> row: u32;

fn begin(n: u32, job: Job) {
  step = frame.rows[select(1u + n / frame.together, 0u, n == 0u)];
  step.keep = job.keep[min(n, 1u)];
  step.longest = job.longest[min(n, 1u)];
}

fn integrate_all(job: Job, local: u32) {
  for (var k = job.first + local; k < job.first + job.count; k += threads) {
    let p = place(k);
    if (p.w > 0.0) {
      let earlier = was(k);
      set_was(k, p);
      put(k, moved_on(k, p, earlier));
    }
  }
  sync();
}

// One of eight colours.
fn stretch_all(job: Job, local: u32, direction: u32, parity: u32) {
  for (var g = job.grid; g < job.grid + job.grids; g++) {
    let size = vec2<u32>(grids[g].width, grids[g].height);
    let columns = select(size.x, size.x / 2u, direction == 0u);
    let rows = select(size.y / 2u, size.y, direction == 0u);
    // Cells by rows, a thread every `threads`-th.
    let stride = by_rows(threads, columns);
    var cell = by_rows(local, columns);
    while (cell.y < rows) {
      let ends = spring_ends(cell, grids[g].first, size, direction, parity);
      if (ends.inside) {
        relax(g, ends, direction);
      }
      cell = on_by_rows(cell, stride, columns);
    }
  }
  sync();
}

// Springs to the right and down.
fn structural_all(job: Job, local: u32) {
  if (right) {
    stretch_all(job, local, 0u, 0u);
    stretch_all(job, local, 0u, 1u);
  }
  if (down) {
    stretch_all(job, local, 1u, 0u);
    stretch_all(job, local, 1u, 1u);
  }
}

// Back to the last good frame where any particle is at fault; else this frame is the good one.
fn end_all(job: Job, local: u32) {
  for (var k = job.first + local; k < job.first + job.count; k += threads) {
    let p = place(k);
    now[k] = p;
    give_was(k, p.w);
    if (p.w >= 0.0 && !sane(p)) {
      atomicAdd(&faults[FAULT_STRIDE * row + FAULT_PARTICLES], 1u);
      atomicMax(&faults[FAULT_STRIDE * row + FAULT_LAST], k - job.first + 1u);
    }
  }
  storageBarrier();
  let faulty = atomicLoad(&faults[FAULT_STRIDE * row + FAULT_PARTICLES]) > 0u;
  for (var k = job.first + local; k < job.first + job.count; k += threads) {
    let p = now[k];
    if (faulty) {
      let at = vec4<f32>(good[k].xyz, p.w);
      now[k] = at;
      before[k] = at;
    } else {
      good[k] = p;
    }
  }
  if (local == 0u && faulty) {
    atomicAdd(&faults[FAULT_STRIDE * row + FAULT_FRAMES], 1u);
  }
  storageBarrier();
}

@compute @workgroup_size(threads)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) local: u32) {
  let job = jobs[workgroup.x];
  base = job.first;
  row = job.row;
  for (var k = job.first + local; k < job.first + job.count; k += threads) {
    take(k);
    take_was(k);
  }
  if (local == 0u) {
    atomicStore(&faults[FAULT_STRIDE * row + FAULT_PARTICLES], 0u);
    atomicStore(&faults[FAULT_STRIDE * row + FAULT_SPEED], 0u);
    atomicStore(&faults[FAULT_STRIDE * row + FAULT_STRAIN], 0u);
  }
  storageBarrier();
  sync();
  for (var n = 0u; n < frame.steps; n++) {
    begin(n, job);
    forget_all(job, local);
    integrate_all(job, local);
    bend_all(job, local);
    membrane_all(job, local);
    for (var r = 0u; r < frame.rounds; r++) {
      tether_all(job, local);
      // Diagonals first: what they disturb, the others put right.
      if (down_right) {
        stretch_all(job, local, 2u, 0u);
        stretch_all(job, local, 2u, 1u);
      }
      if (up_right) {
        stretch_all(job, local, 3u, 0u);
        stretch_all(job, local, 3u, 1u);
      }
      structural_all(job, local);
      for (var p = 0u; p < polish; p++) {
        seam_all(job, local);
        tether_all(job, local);
        structural_all(job, local);
      }
      seam_all(job, local);
      if (polish == 0u) {
        tether_all(job, local);
      }
      contact_all(job, local);
    }
  }
  end_all(job, local);
  strain_all(job, local);
  normal_all(job, local);
  speed_all(job, local);
}
