// Draws triangles that the host moves in their paints, colour times texture times the colour of the corners per pixel, lit from both sides.

// Whether the target wants sRGB and does not convert by itself, and its samples per pixel.
override encode: bool = false;
override samples: u32 = 1u;

// Ten vectors per triangle: position and u, normal and v, colour of each corner, then the paint.
@group(0) @binding(2) var<storage, read> mesh: array<vec4<f32>>;

// Laid out as `PaintRow` in crates/runtime/src/draw/rows.rs. `alpha`: the alpha mode (0 opaque, 1 mask, 2 blend). `cutoff`: a mask discards
// alpha below it. `wrap`: the wrap mode along u, plus 4 times that along v (0 repeats, 1 clamps, 2 mirrors). `first`: the index in `texels`
// of the first level. `levels`: the number of levels, 0 without a texture.
struct Paint {
  color: vec4<f32>,
  alpha: u32,
  cutoff: f32,
  wrap: u32,
  first: u32,
  levels: u32,
  pad_a: u32,
  pad_b: u32,
  pad_c: u32,
}
@group(0) @binding(21) var<storage, read> paints: array<Paint>;

// Of each texture: three numbers per level, where its pixels begin, its width and its height; then the pixels, sRGB and alpha.
@group(0) @binding(22) var<storage, read> texels: array<u32>;

struct Point {
  @builtin(position) clip: vec4<f32>,
  @location(0) at: vec3<f32>,
  @location(1) normal: vec3<f32>,
  @location(2) uv: vec2<f32>,
  @location(3) color: vec4<f32>,
  @location(4) @interpolate(flat) paint: u32,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Point {
  let first = 10u * (index / 3u);
  let p = mesh[first + 3u * (index % 3u)];
  let n = mesh[first + 3u * (index % 3u) + 1u];
  let color = mesh[first + 3u * (index % 3u) + 2u];
  let paint = u32(mesh[first + 9u].x);
  return Point(view.clip * vec4<f32>(p.xyz, 1.0), p.xyz, n.xyz, vec2<f32>(p.w, n.w), color, paint);
}

// The two pixels beside a coordinate, and as z the share of the second.
fn beside(u: f32, size: u32, wrap: u32) -> vec3<f32> {
  let last = f32(size) - 1.0;
  if (wrap == 0u) {
    let x = (u - floor(u)) * f32(size) - 0.5;
    let low = floor(x);
    let first = select(min(low, last), last, low < 0.0);
    return vec3<f32>(first, select(first + 1.0, 0.0, first == last), x - low);
  }
  let turned = u - 2.0 * floor(u * 0.5);
  let inside = select(clamp(u, 0.0, 1.0), select(turned, 2.0 - turned, turned > 1.0), wrap == 2u);
  let x = inside * f32(size) - 0.5;
  let low = floor(x);
  return vec3<f32>(clamp(low, 0.0, last), clamp(low + 1.0, 0.0, last), x - low);
}

fn texel(n: u32) -> vec4<f32> {
  let srgb = unpack4x8unorm(texels[n]);
  let curved = pow((srgb.xyz + 0.055) * (1.0 / 1.055), vec3<f32>(2.4));
  return vec4<f32>(select(curved, srgb.xyz * (1.0 / 12.92), srgb.xyz <= vec3<f32>(0.04045)), srgb.w);
}

// Between four pixels of the level whose pixels are nearest to one per sample; `area` is that of a sample in texture coordinates.
fn sampled(paint: Paint, uv: vec2<f32>, area: f32) -> vec4<f32> {
  let pixels = area * f32(texels[paint.first + 1u]) * f32(texels[paint.first + 2u]);
  let level = min(u32(round(0.5 * log2(max(pixels, 1.0)))), paint.levels - 1u);
  let head = paint.first + 3u * level;
  let width = texels[head + 1u];
  let x = beside(uv.x, width, paint.wrap % 4u);
  let y = beside(uv.y, texels[head + 2u], paint.wrap / 4u);
  let upper = texels[head] + u32(y.x) * width;
  let lower = texels[head] + u32(y.y) * width;
  let a = mix(texel(upper + u32(x.x)), texel(upper + u32(x.y)), x.z);
  let b = mix(texel(lower + u32(x.x)), texel(lower + u32(x.y)), x.z);
  return mix(a, b, y.z);
}

// The order in which the samples of 4 x 4 pixels are filled as alpha rises (B. E. Bayer, 1973).
const DITHER: array<vec4<u32>, 4> =
  array<vec4<u32>, 4>(vec4<u32>(0u, 8u, 2u, 10u), vec4<u32>(12u, 4u, 14u, 6u), vec4<u32>(3u, 11u, 1u, 9u), vec4<u32>(15u, 7u, 13u, 5u));

// Whether a sample of a pixel is drawn where a paint has an alpha.
fn is_drawn(paint: Paint, alpha: f32, pixel: vec2<u32>, s: u32) -> bool {
  if (paint.alpha == 1u) {
    return alpha >= paint.cutoff;
  }
  var dither = DITHER;
  let place = f32(dither[pixel.y % 4u][pixel.x % 4u]);
  return paint.alpha == 0u || alpha > (place + 16.0 * f32(s)) / (16.0 * f32(samples));
}

// Whether all of a pixel is drawn, where a shader cannot say which samples are; `alpha` is the mean of its samples.
fn is_whole(paint: Paint, mask: u32, alpha: f32, pixel: vec2<u32>) -> bool {
  var dither = DITHER;
  let place = f32(dither[pixel.y % 4u][pixel.x % 4u]);
  let blended = alpha > place / 16.0;
  return select(2u * countOneBits(mask) >= samples, blended, paint.alpha == 2u);
}

struct Shaded {
  color: vec4<f32>,
  mask: u32,
  whole: bool,
}

struct Drawn {
  @location(0) color: vec4<f32>,
  @builtin(sample_mask) mask: u32,
}

@fragment
fn fragment(p: Point, @builtin(front_facing) front: bool) -> Drawn {
  let shaded = shade(p, front);
  return Drawn(shaded.color, shaded.mask);
}

@fragment
fn fragment_whole(p: Point, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
  let shaded = shade(p, front);
  if (!shaded.whole) {
    discard;
  }
  return shaded.color;
}

fn shade(p: Point, front: bool) -> Shaded {
  let right = dpdx(p.uv);
  let down = dpdy(p.uv);
  let paint = paints[p.paint];
  let area = abs(right.x * down.y - right.y * down.x) / f32(samples);
  // The texture and alpha at each sample, whatever the order in which the device has them.
  var sum = vec3<f32>(0.0);
  var mask = 0u;
  var alpha = 0.0;
  for (var s = 0u; s < samples; s++) {
    let off = select(vec2<f32>(0.0), vec2<f32>(0.5 * f32(s % 2u) - 0.25, 0.5 * f32(s / 2u) - 0.25), samples > 1u);
    var color = paint.color * p.color;
    if (paint.levels > 0u) {
      color *= sampled(paint, p.uv + right * off.x + down * off.y, area);
    }
    alpha += color.w / f32(samples);
    if (is_drawn(paint, color.w, vec2<u32>(p.clip.xy), s)) {
      sum += color.xyz;
      mask |= 1u << s;
    }
  }
  if (mask == 0u) {
    discard;
  }
  let base = sum * (1.0 / f32(max(countOneBits(mask), 1u)));
  let side = select(-1.0, 1.0, front);
  let n = p.normal * (side / max(sqrt(dot(p.normal, p.normal)), 1e-9));
  let light = lit(base, n, p.at);
  let whole = is_whole(paint, mask, alpha, vec2<u32>(p.clip.xy));
  return Shaded(vec4<f32>(select(light, encoded(light), encode), 1.0), mask, whole);
}
