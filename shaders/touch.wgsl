// How far contact with cloth moves each particle: two vectors, for its position and its previous one. All read the same positions, so
// their order does not matter. Contact is inelastic: previous positions follow a push as far as it would begin a flight.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> before: array<vec4<f32>>;
@group(0) @binding(67) var<storage, read> kin: array<u32>;
@group(0) @binding(70) var<storage, read> partners: array<vec2<u32>>;
@group(0) @binding(71) var<storage, read_write> pushes: array<vec4<f32>>;

// The sum of what pairs ask for: pushes, what ends approaches, and friction.
var<private> push: vec3<f32>;
var<private> stop: vec3<f32>;
var<private> rubs: vec3<f32>;
// The largest of one pair of each.
var<private> long_push: f32;
var<private> long_stop: f32;
var<private> long_rub: f32;

// Adds a pair that is nearer than `least`: the way from the other particle, the motion beside that of the other one, and the shares of the
// push and of what ends the approach.
fn add(way: vec3<f32>, slide: vec3<f32>, least: f32, friction: f32, shares: vec2<f32>) {
  let far2 = dot(way, way);
  if (least * least > far2 && far2 > 1e-12) {
    let far = sqrt(far2);
    let normal = way * (1.0 / far);
    let apart = (least - far) * TOUCH_SHARE;
    let away = dot(slide, normal);
    let ends = (apart - min(max(away + apart, 0.0), apart)) * shares.y;
    let along = slide - normal * away;
    let long = sqrt(dot(along, along));
    let rub = min(friction * apart, TOUCH_SHARE * long) * shares.x;
    push += normal * (apart * shares.x);
    stop += normal * ends;
    rubs += along * (rub / max(long, 1e-12));
    long_push = max(long_push, apart * shares.x);
    long_stop = max(long_stop, ends);
    long_rub = max(long_rub, rub);
  }
}

// A vector that is shortened to a length.
fn within(v: vec3<f32>, most: f32) -> vec3<f32> {
  return v * min(most / max(sqrt(dot(v, v)), 1e-12), 1.0);
}

@compute @workgroup_size(64)
fn main(
  @builtin(workgroup_id) workgroup: vec3<u32>,
  @builtin(num_workgroups) rows: vec3<u32>,
  @builtin(local_invocation_index) local: u32,
) {
  let k = element(workgroup, rows, local);
  if (k >= arrayLength(&now)) {
    return;
  }
  let p = now[k];
  let moved = p.xyz - before[k].xyz;
  let friction = bitcast<f32>(kin[1]);
  // Partners come first, then there are none.
  for (var n = 0u; n < MAX_PARTNERS; n++) {
    let partner = partners[k * MAX_PARTNERS + n];
    if (partner.x < arrayLength(&now)) {
      let q = now[partner.x];
      let share = p.w / max(p.w + q.w, 1e-12);
      let slide = moved - (q.xyz - before[partner.x].xyz);
      add(p.xyz - q.xyz, slide, bitcast<f32>(partner.y), friction, vec2<f32>(share));
    }
  }
  meet_others(k, p, moved);
  let longest = bitcast<f32>(kin[0]) * MAX_PUSH;
  // Several partners ask for the same motion: together they get what one of them asks for, or a little more.
  let gone = within(push, min(long_push / TOUCH_SHARE, longest));
  let rubbed = within(rubs, long_rub + long_rub);
  pushes[2u * k] = vec4<f32>(gone - rubbed, 0.0);
  pushes[2u * k + 1u] = vec4<f32>(gone - within(stop, long_stop), 0.0);
}
