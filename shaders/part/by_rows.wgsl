// Column and row of a thread; exact for the number of threads that a workgroup may have, and quicker than whole numbers.
fn by_rows(n: u32, columns: u32) -> vec2<u32> {
  let row = u32((f32(n) + 0.5) / f32(columns));
  return vec2<u32>(n - row * columns, row);
}

// The cell that is `by` cells on.
fn on_by_rows(cell: vec2<u32>, by: vec2<u32>, columns: u32) -> vec2<u32> {
  let on = cell + by;
  if (on.x >= columns) {
    return vec2<u32>(on.x - columns, on.y + 1u);
  }
  return on;
}
