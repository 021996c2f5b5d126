// A spring without compliance draws its ends together, or apart, farther than its length asks: a round of polish.
fn polish(grid: u32, ends: Ends, direction: u32) {
  let pull = pull_of(grid, ends, direction);
  if (pull.there) {
    let g = (pull.far - pull.rest) / max(pull.far * (pull.a.w + pull.b.w), 1e-30);
    draw_together(ends, pull, g * OVER);
  }
}
