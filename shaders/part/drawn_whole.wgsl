// Nothing was cut out.
fn hole(k: u32, bit: u32) -> bool {
  return false;
}
