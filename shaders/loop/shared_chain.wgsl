// Seams, and rules of particles after them, for several cloths: a thread works for a particle, or for all duplicates of a seam point.
// `sew_program`, `touch_program` and `rest_program` are made from the list of passes: those before contact, contact, and what follows
// the last passes of a step.
@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  member(workgroup.z);
  let n = element(workgroup, rows, local);
  clear_faults(n == 0u);
  let own = cloth.first + n;
  var ring = NO_RING;
  var first = 0u;
  var end = u32(n < cloth.count);
  if (n < cloth.count) {
    ring = ring_of(own);
  }
  if (ring != NO_RING) {
    first = starts_at(ring);
    // The thread of the first duplicate works for all.
    end = select(first, starts_at(ring + 1u), members_at(first) == own);
  }
  begin_tail();
  if (sewing && ring != NO_RING && first < end) {
    each(ring);
  }
  for (var m = first; m < end; m++) {
    if (sewing) {
      sew_program(link(ring, m, own));
    }
  }
  find_near(ring, vec3<u32>(first, end, own), local);
  for (var m = first; m < end; m++) {
    if (sewing) {
      touch_program(link(ring, m, own));
    }
  }
  begin(part.x, cloth);
  for (var m = first; m < end; m++) {
    rest_program(link(ring, m, own));
  }
}

// The particle that is number m of those that a thread works for.
fn link(ring: u32, m: u32, own: u32) -> u32 {
  if (ring == NO_RING) {
    return own;
  }
  return members_at(m);
}
