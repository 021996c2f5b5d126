// Whether a thread may have more particles of a cloth with `count` of them: loops over many are not unrolled.
fn has_more(count: u32) -> bool {
  return mine * threads < count;
}
