// Pairs of columns or rows, all of which are in memory: the first, and the one after the last.
fn pairs(begin: u32, end: u32, parity: u32) -> vec2<u32> {
  return vec2<u32>((begin + 1u - parity) / 2u, (max(end, parity) - parity) / 2u);
}

// The part of a row that is still right: its ends are not where their other ends are missing. Where a tile has nothing,
// that ends no later than it begins, but never before 0, so that loops over it have nothing to do.
fn within(begin: u32, end: u32, whole: u32, parity: u32) -> vec2<u32> {
  let less = select(0u, (begin ^ parity) & 1u, begin > 0u);
  let more = select(0u, (end ^ parity) & 1u, end < whole);
  return vec2<u32>(begin + less, max(end, more) - more);
}
