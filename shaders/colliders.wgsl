// A particle inside a collider goes to its surface, collider by collider.
fn leave_solids(k: u32) {
  let p = place(k);
  if (p.w <= 0.0) {
    return;
  }
  var at = p.xyz;
  for (var c = 0u; c < solid_count(); c++) {
    let solid = solid_at(c);
    let out = leave(solid, at);
    if (out.inside) {
      at = rub(solid, out, moved_by(solid, was(k)));
    }
  }
  put(k, vec4<f32>(at, p.w));
}
