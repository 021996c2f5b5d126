// Pushes by particles of other cloths, which go on as they moved when they were seen last, `since` steps ago.
@group(0) @binding(77) var<storage, read> shadows: array<vec4<f32>>;
@group(0) @binding(78) var<storage, read> others: array<vec4<u32>>;

override since: u32;

fn meet_others(k: u32, p: vec4<f32>, moved: vec3<f32>) {
  let elapsed = f32(since) * step.dt;
  for (var n = 0u; n < MAX_OTHERS; n++) {
    let other = others[k * MAX_OTHERS + n];
    let m = 2u * other.x;
    if (other.x < arrayLength(&shadows) / 2u) {
      let at = shadows[m];
      let velocity = shadows[m + 1u].xyz;
      let own = shadows[2u * other.w];
      // The velocity that both have after an inelastic impact.
      let mean = (shadows[2u * other.w + 1u].xyz * at.w + velocity * own.w) / (own.w + at.w);
      // The other cloth ends its part of the approach in its own steps.
      let stops = select(0.0, 1.0, p.w > 0.0);
      let share = p.w / max(p.w + at.w, 1e-12);
      let way = p.xyz - (at.xyz + velocity * elapsed);
      add(way, moved - mean * step.dt, bitcast<f32>(other.y), bitcast<f32>(other.z), vec2<f32>(share, stops));
    }
  }
}
