// The cell of a membrane with its upper left corner at (i, j): two triangles, each of which resists to stretch along weft
// and warp, and to shear between them.
// `cells` are inverses of the triangles' rest shapes by columns, two a texel; 0 means no triangle. `yielding` is one over the stiffness
// along the weft, along the warp, and in shear.

// Moves three corners.
fn relax_triangle(corners: vec3<u32>, q: vec4<f32>, det: f32, yields: vec3<f32>) {
  let size = 2.0 * abs(det);
  if (size <= 0.0) {
    return;
  }
  let a = place(corners.x);
  let b = place(corners.y);
  let c = place(corners.z);
  let w = max(vec3<f32>(a.w, b.w, c.w), vec3<f32>(0.0));
  let e = b.xyz - a.xyz;
  let h = c.xyz - a.xyz;
  // Weft and warp as they lie now, and what each corner does to them.
  var weft = e * q.x + h * q.z;
  var warp = e * q.y + h * q.w;
  let n = vec3<f32>(-(q.x + q.z), q.x, q.z);
  let m = vec3<f32>(-(q.y + q.w), q.y, q.w);
  let nn = w.x * n.x * n.x + w.y * n.y * n.y + w.z * n.z * n.z;
  let nm = w.x * n.x * m.x + w.y * n.y * m.y + w.z * n.z * m.z;
  let mm = w.x * m.x * m.x + w.y * m.y * m.y + w.z * m.z * m.z;
  let soft = yields * size / (step.dt * step.dt);
  var far = max(sqrt(dot(weft, weft)), 1e-9);
  var by = weft * ((far - 1.0) / (far * (nn + soft.x)));
  var u = by;
  weft -= by * nn;
  warp -= by * nm;
  far = max(sqrt(dot(warp, warp)), 1e-9);
  by = warp * ((far - 1.0) / (far * (mm + soft.y)));
  var v = by;
  warp -= by * mm;
  weft -= by * nm;
  let both = dot(weft, warp);
  let s = both / (nn * dot(warp, warp) + 2.0 * nm * both + mm * dot(weft, weft) + soft.z);
  u += warp * s;
  v += weft * s;
  put(corners.x, vec4<f32>(a.xyz - (u * n.x + v * m.x) * w.x, a.w));
  put(corners.y, vec4<f32>(b.xyz - (u * n.y + v * m.y) * w.y, b.w));
  put(corners.z, vec4<f32>(c.xyz - (u * n.z + v * m.z) * w.z, c.w));
}

fn relax_cell(grid: Grid, i: u32, j: u32) {
  let yields = yielding_at(row).xyz;
  let k = grid.first + j * grid.width + i;
  var first = cells_at(2u * k);
  var second = cells_at(2u * k + 1u);
  var det = vec2<f32>(first.x * first.w - first.y * first.z, second.x * second.w - second.y * second.z);
  // The sign says which diagonal divides the cell: down-right, or up-right where it is negative.
  let up = det.x + det.y < 0.0;
  let gone = removed(k);
  if (gone != 0u) {
    // Triangles are cut by the other rule: of a cell divided up-right both go.
    det = select(vec2<f32>(0.0), select(det, vec2<f32>(0.0), vec2<bool>((gone & 2u) != 0u, (gone & 1u) != 0u)), !up);
  }
  let low = k + grid.width;
  let ring = select(vec4<u32>(k, k + 1u, low + 1u, low), vec4<u32>(k + 1u, low + 1u, low, k), up);
  relax_triangle(vec3<u32>(ring.x, ring.y, ring.z), first, det.x, yields);
  relax_triangle(vec3<u32>(ring.x, ring.z, ring.w), second, det.y, yields);
}
