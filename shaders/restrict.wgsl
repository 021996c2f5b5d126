// The motion of a coarser image, from that of the finer one: near its surface in least squares, and springs that are too short are
// drawn apart. One workgroup for a cloth.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;
// Where particles were when a stage began, and behind that the other list of the fit.
@group(0) @binding(61) var<storage, read_write> spare: array<vec4<f32>>;
// Two rows for each pin between coarse texels: its fine particle and its coarse one, and the way from the latter.
@group(0) @binding(62) var<storage, read_write> beside: array<vec4<u32>>;

const GROUP: u32 = 256u;

// Where the row of a coarse particle begins: its sample, where its entries begin and end, how far springs may move it, its share of the
// inverse mass of its point, and its point.
fn row(k: u32) -> u32 {
  return table[3] + 6u * k;
}

fn place(k: u32, other: bool) -> vec3<f32> {
  if (other) {
    return spare[table[1] + k].xyz;
  }
  return now[k].xyz;
}

// A round of the fit for a particle: it follows the surface beside it from one list to the other.
fn fit(k: u32, other: bool) {
  let at = row(k);
  let ends = table[at + 2u];
  var sum = vec4<f32>(0.0);
  for (var e = table[at + 1u]; e < ends; e += 2u) {
    let n = table[e];
    let w = bitcast<f32>(table[e + 1u]);
    let corners = stencil_ends(n);
    let parts = stencil_weights(n);
    let on = place(corners.x, other) * parts.x + place(corners.y, other) * parts.y + place(corners.z, other) * parts.z;
    sum += vec4<f32>((origin[n].xyz - on) * w, w);
  }
  let w = now[k].w;
  var p = place(k, other);
  if (w > 0.0) {
    p += sum.xyz * (1.0 / max(sum.w, 1e-9));
  }
  if (other) {
    now[k] = vec4<f32>(p, w);
  } else {
    spare[table[1] + k] = vec4<f32>(p, w);
  }
}

// Draws the ends of a spring apart that is too short.
fn part_ends(spring: u32) {
  let a = table[spring];
  let b = table[spring + 1u];
  let rest = bitcast<f32>(table[spring + 2u]);
  let p = now[a];
  let q = now[b];
  let way = q.xyz - p.xyz;
  let long = sqrt(dot(way, way));
  let u = max(p.w, 0.0) * bitcast<f32>(table[row(a) + 4u]);
  let v = max(q.w, 0.0) * bitcast<f32>(table[row(b) + 4u]);
  if (u + v > 0.0 && long > 1e-6 * rest && long < rest) {
    let by = (rest - long) / (long * (u + v));
    now[a] = vec4<f32>(p.xyz - way * (by * u), p.w);
    now[b] = vec4<f32>(q.xyz + way * (by * v), q.w);
  }
}

// No particle is farther from where the stage began than springs may move it.
fn hold(k: u32) {
  let p = now[k];
  let start = spare[k].xyz;
  let way = p.xyz - start;
  let far = sqrt(dot(way, way));
  let most = bitcast<f32>(table[row(k) + 3u]);
  if (far > most) {
    now[k] = vec4<f32>(start + way * (most / far), p.w);
  }
}

@compute @workgroup_size(256)
fn main(@builtin(local_invocation_index) local: u32) {
  let count = table[1];
  let colours = table[4];
  for (var k = local; k < count; k += GROUP) {
    let sample = table[row(k)];
    let w = now[k].w;
    let p = vec4<f32>(origin[sample].xyz, w);
    now[k] = p;
    before[k] = vec4<f32>(origin_before[sample].xyz, w);
    spare[k] = p;
  }
  for (var n = local; n < arrayLength(&beside) / 2u; n += GROUP) {
    let pin = beside[2u * n];
    if (pin.x < table[0]) {
      beside[2u * n + 1u] = bitcast<vec4<u32>>(origin[pin.x] - origin[table[row(pin.y)]]);
    }
  }
  storageBarrier();
  for (var n = 0u; n < FITS; n++) {
    for (var k = local; k < count; k += GROUP) {
      fit(k, n % 2u == 1u);
    }
    storageBarrier();
  }
  for (var k = local; k < count; k += GROUP) {
    let p = now[k];
    let b = before[k];
    before[k] = vec4<f32>(b.xyz + (p.xyz - spare[k].xyz), b.w);
    spare[k] = p;
  }
  storageBarrier();
  for (var n = 0u; n < ROUNDS; n++) {
    for (var c = 0u; c < colours; c++) {
      let colour = table[5] + select(colours - 1u - c, c, n % 2u == 0u);
      let ends = table[colour + 1u];
      for (var spring = table[colour] + 3u * local; spring < ends; spring += 3u * GROUP) {
        part_ends(spring);
      }
      storageBarrier();
    }
    for (var k = local; k < count; k += GROUP) {
      hold(k);
    }
    storageBarrier();
  }
  for (var k = local; k < count; k += GROUP) {
    let point = table[row(k) + 5u];
    let p = now[point].xyz;
    let b = before[k];
    before[k] = vec4<f32>(b.xyz + (p - spare[point].xyz), b.w);
    // Nothing else writes the point itself.
    if (point != k) {
      now[k] = vec4<f32>(p, now[k].w);
    }
  }
}
