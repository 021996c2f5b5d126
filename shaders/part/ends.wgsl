// The particles that a spring of a colour joins. Directions: 0 right, 1 down, 2 down-right, 3 up-right; the parity is that
// of the column for "right", else of the upper row.
struct Ends {
  k: u32,
  other: u32,
  inside: bool,
}

// The spring of cell (i, j), where every other column (or row) counts, of a grid that begins at `first`. It is stored
// at k.
fn spring_ends(cell: vec2<u32>, first: u32, size: vec2<u32>, direction: u32, parity: u32) -> Ends {
  var i = cell.x;
  var j = cell.y;
  if (direction == 0u) {
    i = 2u * i + parity;
  } else {
    j = 2u * j + parity;
  }
  let right = u32(direction != 1u);
  let down = u32(direction != 0u);
  let inside = i + right < size.x && j + down < size.y;
  let k = first + j * size.x + i;
  if (direction == 3u) {
    return Ends(k + size.x, k + 1u, inside);
  }
  return Ends(k, k + down * size.x + right, inside);
}
