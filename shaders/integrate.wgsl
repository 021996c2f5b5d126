// One Verlet step of a free particle: now becomes before.
fn integrate(k: u32) {
  let p = place(k);
  if (p.w > 0.0) {
    let earlier = was(k);
    set_was(k, p);
    put(k, moved_on(k, p, earlier));
  }
}
