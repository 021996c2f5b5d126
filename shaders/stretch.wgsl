// A spring with compliance draws its ends together, or apart.
fn stretch(grid: u32, ends: Ends, direction: u32) {
  let pull = pull_of(grid, ends, direction);
  if (pull.there) {
    let g = multiplier(grid, ends.k, direction, pull.far, pull.rest, pull.a.w + pull.b.w);
    draw_together(ends, pull, g);
  }
}
