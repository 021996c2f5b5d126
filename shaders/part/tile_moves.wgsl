// A tile begins with the step itself: now becomes before, elsewhere.
@group(0) @binding(3) var<storage, read> before: array<vec4<f32>>;
@group(0) @binding(35) var<storage, read_write> passed: array<vec4<f32>>;

// Whether the tile owns the particle that moves.
var<private> own: bool;

fn arrive(k: u32, p: vec4<f32>, mine: bool) -> vec4<f32> {
  own = mine;
  let earlier = before[k];
  let free = p.w > 0.0;
  if (mine) {
    passed[k] = select(earlier, p, free);
  }
  if (free) {
    return moved_on(k, p, earlier.xyz);
  }
  stay(k);
  return p;
}

fn previous(k: u32) -> vec3<f32> {
  return now[k].xyz;
}
