//! 4 x 4 matrices of f64, column by column.

/// A transform of positions.
pub(super) type Matrix = [f64; 16];

pub(super) const IDENTITY: Matrix = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// `a` after `b`.
pub(super) fn mul(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|n| (0..4).map(|k| a[4 * k + n % 4] * b[n / 4 * 4 + k]).sum())
}

/// From translation, rotation (a quaternion x, y, z, w) and scale.
pub(super) fn from_parts(t: [f64; 3], [x, y, z, w]: [f64; 4], s: [f64; 3]) -> Matrix {
    let columns = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
        [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
        [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
    ];
    let mut out = IDENTITY;
    for (k, column) in columns.iter().enumerate() {
        (0..3).for_each(|c| out[4 * k + c] = column[c] * s[k]);
    }
    out[12..15].copy_from_slice(&t);
    out
}
