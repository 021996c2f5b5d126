// Several relaxations per step: multipliers are summed, in memory too; a tile writes those of its own elsewhere.
@group(0) @binding(37) var<storage, read_write> summing: array<vec4<f32>>;

// Whether the multipliers of the last step end with it.
override forgets: bool = false;

var<workgroup> held_sums: array<vec4<f32>, places>;

fn take_sums(k: u32, at: u32) {
  if (forgets) {
    held_sums[at] = vec4<f32>(0.0);
  } else {
    held_sums[at] = sums_at(k);
  }
}

fn give_sums(k: u32, at: u32) {
  summing[k] = held_sums[at];
}

fn summed(k: u32, direction: u32) -> f32 {
  return held_sums[place_of(k)][direction];
}

fn sum_up(k: u32, direction: u32, sum: f32) {
  held_sums[place_of(k)][direction] = sum;
}

fn end_sums(k: u32) {
  held_sums[place_of(k)] = vec4<f32>(0.0);
}
