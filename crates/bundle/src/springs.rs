//! The springs of a grid: each texel stores the four that lead right, down, down-right and up-right.

/// The steps (columns, rows) of the four springs stored at a texel: right, down, down-right, up-right.
pub const SPRING_STEPS: [(i64, i64); 4] = [(1, 0), (0, 1), (1, 1), (1, -1)];

/// The texel at the other end of spring `kind` (an index into [`SPRING_STEPS`]) of texel `k` in a grid of `width` x
/// `height` texels; `None` if the spring leaves the grid.
///
/// ```
/// use gimage_bundle::other_end;
/// // Down-right from the first texel of a grid of 3 x 2, and up-right, which leaves it.
/// assert_eq!((other_end(3, 2, 0, 2), other_end(3, 2, 0, 3)), (Some(4), None));
/// ```
#[inline]
pub fn other_end(width: usize, height: usize, k: usize, kind: usize) -> Option<usize> {
    let (columns, rows) = SPRING_STEPS[kind];
    let (i, j) = ((k % width).checked_add_signed(columns as isize)?, (k / width).checked_add_signed(rows as isize)?);
    (i < width && j < height).then_some(j * width + i)
}
