// Colliders that the particles of a workgroup cannot touch in this step are left out: those that the box around where
// its particles are and were does not reach. A collider that is left out would have moved none of them.
const MOST_NEAR: u32 = 1024u;

// Notes: bits of the box's least and largest numbers, in an order that is that of the numbers, then a bit a collider. From
// MOST_NEAR on all colliders are near.
const LOW: u32 = 0u;
const HIGH: u32 = 3u;
const BITS: u32 = 6u;

fn ordered(x: f32) -> u32 {
  let bits = bitcast<u32>(x);
  return select(bits | 0x80000000u, ~bits, bits >= 0x80000000u);
}

fn number(bits: u32) -> f32 {
  return bitcast<f32>(select(~bits, bits & 0x7fffffffu, bits >= 0x80000000u));
}

// Whether a particle in the box can meet the solid. Above all rounding, by a share of what is rounded.
fn reaches(solid: Solid, low: vec3<f32>, high: vec3<f32>) -> bool {
  let below = low - solid.center;
  let above = high - solid.center;
  let far = max(abs(below), abs(above));
  if (half_spaces && solid.kind == 0u) {
    let n = turned(solid.rotation, vec3<f32>(0.0, 1.0, 0.0));
    return dot(select(above, below, n > vec3<f32>(0.0)), n) <= 1e-4 * (far.x + far.y + far.z);
  }
  var r = length(solid.size);
  if (solid.kind == 1u) {
    r = solid.size.x;
  } else if (solid.kind == 2u) {
    r = solid.size.x + solid.size.y;
  } else if (tapered_capsules && solid.kind == 6u) {
    r = solid.size.y + max(solid.size.x, solid.size.z);
  } else if (solid.kind >= 4u) {
    r = max(solid.size.x, max(solid.size.y, solid.size.z));
  }
  r = (r + (length(solid.velocity) + length(solid.spin) * length(far)) * step.dt) * 1.001;
  let d = max(max(below, -above), vec3<f32>(0.0));
  return dot(d, d) <= r * r;
}

// The box of a thread's particles; a low above its high is none. For all threads of the workgroup.
fn gather(low: vec3<f32>, high: vec3<f32>, local: u32, threads: u32) {
  if (local < 38u) {
    note(local, select(0u, 0xffffffffu, local < HIGH));
  }
  noted_all();
  if (low.x <= high.x) {
    for (var d = 0u; d < 3u; d++) {
      note_least(LOW + d, ordered(low[d]));
      note_most(HIGH + d, ordered(high[d]));
    }
  }
  noted_all();
  let least = vec3<f32>(number(noted(LOW)), number(noted(LOW + 1u)), number(noted(LOW + 2u)));
  let most = vec3<f32>(number(noted(HIGH)), number(noted(HIGH + 1u)), number(noted(HIGH + 2u)));
  if (least.x <= most.x) {
    for (var c = local; c < min(solid_count(), MOST_NEAR); c += threads) {
      if (reaches(posed(solid_at(c)), least, most)) {
        note_bits(BITS + c / 32u, 1u << (c % 32u));
      }
    }
  }
  noted_all();
}

// The next collider from c on that is near.
fn near_from(c: u32) -> u32 {
  let end = min(solid_count(), MOST_NEAR);
  var at = c;
  while (at < end) {
    let bits = noted(BITS + at / 32u) >> (at % 32u);
    if (bits != 0u) {
      return at + countTrailingZeros(bits);
    }
    at = (at / 32u + 1u) * 32u;
  }
  return max(at, c);
}

// The next collider from c on that a particle alone can meet.
fn near_to(c: u32, at: vec3<f32>, was: vec3<f32>) -> u32 {
  var next = c;
  var found = false;
  while (next < solid_count() && !found) {
    found = reaches(posed(solid_at(next)), min(at, was), max(at, was));
    next += u32(!found);
  }
  return next;
}
