// All that is bound is one cloth's.
const base: u32 = 0u;
const row: u32 = 0u;

fn fault(n: u32) -> u32 {
  return n;
}
