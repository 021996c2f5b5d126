// Where cloth is so even that no two of its features that are near on the surface can come into contact: crates/runtime/src/cpu/joint/even.rs.

// Whether the four cells around a texel cannot cross one another while their particles, row by row, stay in their balls, with a least gap.
fn is_even(given: array<vec4<f32>, 9>, gap: f32) -> bool {
  var balls = given;
  var reach = 0.0;
  var at = array<vec3<f32>, 9>();
  for (var n = 0u; n < 9u; n++) {
    at[n] = balls[n].xyz - balls[4].xyz;
    reach = max(reach, balls[n].w);
  }
  let right = (at[5] - at[3]) * 0.5;
  let down = (at[7] - at[1]) * 0.5;
  let rr = dot(right, right);
  let rd = dot(right, down);
  let dd = dot(down, down);
  let area2 = rr * dd - rd * rd;
  if (area2 <= rr * dd * EVEN_AREA2) {
    return false;
  }
  // Coordinates in the plane of the block that are 1 longer per column, and per row.
  let u = right * (dd / area2) - down * (rd / area2);
  let v = down * (rr / area2) - right * (rd / area2);
  let uu = dot(u, u);
  let uv = dot(u, v);
  let vv = dot(v, v);
  // The most that both together differ by, per distance.
  let most = sqrt(0.5 * (uu + vv) + sqrt(0.25 * (uu - vv) * (uu - vv) + uv * uv));
  let need = most * (EVEN_CHANGE * reach + gap * (1.0 / EVEN_APART)) + EVEN_ROOM;
  var flat = array<vec2<f32>, 9>();
  for (var n = 0u; n < 9u; n++) {
    flat[n] = vec2<f32>(dot(u, at[n]), dot(v, at[n]));
  }
  // Whichever way the diagonal of a cell goes.
  for (var n = 0u; n < 16u; n++) {
    let cell = n % 2u + 3u * (n / 2u % 2u);
    let p = cell + 3u * (n / 4u % 2u);
    let r = cell + n / 8u;
    let across = flat[p + 1u] - flat[p];
    let along = flat[r + 3u] - flat[r];
    let mean = 0.5 * (across.x + along.y) - need;
    let wide = across.x - along.y;
    let skew = across.y + along.x;
    if (mean <= 0.0 || mean * mean <= 0.25 * (wide * wide + skew * skew)) {
      return false;
    }
  }
  return true;
}
