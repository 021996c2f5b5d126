// The largest number of all threads of a workgroup, none of them below 0. Right in the first thread alone.
fn most_of_all(mine: f32, local: u32) -> f32 {
  workgroupBarrier();
  set_spare(local, mine);
  workgroupBarrier();
  for (var count = threads; count > 1u; count = (count + 1u) / 2u) {
    let half = (count + 1u) / 2u;
    if (local + half < count) {
      set_spare(local, larger(spare(local), spare(local + half)));
    }
    workgroupBarrier();
  }
  return spare(local);
}
