//! Turns in space.

use super::real::V3;

/// The unit quaternion of a turn, given where it takes the three axes, from the largest of its components (S. W. Shepperd, 1978).
pub(crate) fn quaternion([a, b, c]: &[V3<f64>; 3]) -> [f64; 4] {
    let squares =
        [1.0 + a[0] - b[1] - c[2], 1.0 - a[0] + b[1] - c[2], 1.0 - a[0] - b[1] + c[2], 1.0 + a[0] + b[1] + c[2]];
    let largest = (0..4).max_by(|i, j| squares[*i].total_cmp(&squares[*j])).unwrap_or(3);
    let s = 2.0 * squares[largest].max(1e-12).sqrt();
    let q = match largest {
        0 => [s / 4.0, (a[1] + b[0]) / s, (a[2] + c[0]) / s, (b[2] - c[1]) / s],
        1 => [(a[1] + b[0]) / s, s / 4.0, (b[2] + c[1]) / s, (c[0] - a[2]) / s],
        2 => [(a[2] + c[0]) / s, (b[2] + c[1]) / s, s / 4.0, (a[1] - b[0]) / s],
        _ => [(b[2] - c[1]) / s, (c[0] - a[2]) / s, (a[1] - b[0]) / s, s / 4.0],
    };
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.map(|x| x / length)
}
