// A tether of a particle, from the list.
fn tether_pair(k: u32, s: u32) -> vec2<u32> {
  return tethers_at(k * slots + s);
}
