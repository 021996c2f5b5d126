// How far contact with cloth moves each particle: two vectors, for its position and its previous one. All read the same positions, so
// their order does not matter. Contact is inelastic: previous positions follow a push as far as it would begin a flight.
@group(0) @binding(2) var<storage, read> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> before: array<vec4<f32>>;
@group(0) @binding(67) var<storage, read> kin: array<u32>;
@group(0) @binding(70) var<storage, read> partners: array<vec2<u32>>;
@group(0) @binding(71) var<storage, read_write> pushes: array<vec4<f32>>;

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
  let step = p.xyz - before[k].xyz;
  let friction = bitcast<f32>(kin[1]);
  var push = vec3<f32>(0.0);
  var back = vec3<f32>(0.0);
  var rubs = vec3<f32>(0.0);
  // The largest of one pair: the length of a push, of what ends an approach, and of friction.
  var long_push = 0.0;
  var long_stop = 0.0;
  var long_rub = 0.0;
  // Partners come first, then there are none.
  for (var n = 0u; n < MAX_PARTNERS; n++) {
    let partner = partners[k * MAX_PARTNERS + n];
    if (partner.x < arrayLength(&now)) {
      let q = now[partner.x];
      let way = p.xyz - q.xyz;
      let far2 = dot(way, way);
      let least = bitcast<f32>(partner.y);
      if (least * least > far2 && far2 > 1e-12) {
        let far = sqrt(far2);
        let normal = way * (1.0 / far);
        let own = p.w / max(p.w + q.w, 1e-12);
        let apart = (least - far) * TOUCH_SHARE;
        let slide = step - (q.xyz - before[partner.x].xyz);
        let away = dot(slide, normal);
        let flight = min(max(away + apart, 0.0), apart);
        let along = slide - normal * away;
        let long = sqrt(dot(along, along));
        let rub = min(friction * apart, TOUCH_SHARE * long) * own;
        push += normal * (apart * own);
        back += normal * (flight * own);
        rubs += along * (rub / max(long, 1e-12));
        long_push = max(long_push, apart * own);
        long_stop = max(long_stop, apart * own - flight * own);
        long_rub = max(long_rub, rub);
      }
    }
  }
  let longest = bitcast<f32>(kin[0]) * MAX_PUSH;
  // Several partners ask for the same motion: together they get what one of them asks for, or a little more.
  let stop = within(push - back, long_stop);
  push = within(push, min(long_push / TOUCH_SHARE, longest));
  pushes[2u * k] = vec4<f32>(push - within(rubs, long_rub + long_rub), 0.0);
  pushes[2u * k + 1u] = vec4<f32>(push - stop, 0.0);
}
