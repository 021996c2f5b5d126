// Seams that a dispatch begins with: those of the step whose last passes are still due, if there is one.

// A particle without a seam.
const NO_RING: u32 = 0xffffffffu;

var<private> sewing: bool;

// The seam ring of a particle, as all cloths are counted.
fn ring_of(k: u32) -> u32 {
  let ring = rings_at(k);
  return select(cloth.ring + ring, NO_RING, ring == NO_RING);
}

// From here on the numbers are those of that step.
fn begin_tail() {
  sewing = part.y > 0u;
  if (sewing) {
    begin(part.y - 1u, cloth);
  }
}

// Where a particle is once the seams are closed.
fn sewn(k: u32) -> vec4<f32> {
  let p = loose(k);
  let ring = ring_of(k);
  if (sewing && ring != NO_RING) {
    return vec4<f32>(meeting(ring), p.w);
  }
  return p;
}
