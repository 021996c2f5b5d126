//! Transforms as 4 x 4 matrices, column-major as in glTF.

use nalgebra::Matrix4;

pub(crate) type Matrix = [f64; 16];

pub(crate) const IDENTITY: Matrix = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// a b
pub(crate) fn mul(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| (0..4).map(|k| a[4 * k + i % 4] * b[i - i % 4 + k]).sum())
}

/// Translation, rotation as a quaternion (x, y, z, w; normalised here), scale.
pub(crate) fn from_trs(t: [f64; 3], q: [f64; 4], s: [f64; 3]) -> Matrix {
    let n = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    let [x, y, z, w] = if n > 0.0 { q.map(|c| c / n) } else { [0.0, 0.0, 0.0, 1.0] };
    let c = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
        [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
        [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
    ];
    let mut m = IDENTITY;
    for j in 0..3 {
        for i in 0..3 {
            m[4 * j + i] = c[j][i] * s[j];
        }
    }
    m[12..15].copy_from_slice(&t);
    m
}

/// Where a point goes.
pub(crate) fn point(m: &Matrix, p: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i])
}

/// The linear part as columns.
fn columns(m: &Matrix) -> [[f64; 3]; 3] {
    [[m[0], m[1], m[2]], [m[4], m[5], m[6]], [m[8], m[9], m[10]]]
}

/// Determinant of the linear part; negative if the transform mirrors.
pub(crate) fn determinant(m: &Matrix) -> f64 {
    let [a, b, c] = columns(m);
    crate::base::vec3::dot(a, crate::base::vec3::cross(b, c))
}

/// The matrix for normals, up to a positive factor, as columns: the inverse transpose, written as cofactors so that
/// a transform that flattens still has one.
pub(crate) fn normal_columns(m: &Matrix) -> [[f64; 3]; 3] {
    let [a, b, c] = columns(m);
    let sign = if determinant(m) < 0.0 { -1.0 } else { 1.0 };
    use crate::base::vec3::{cross, scale};
    [scale(cross(b, c), sign), scale(cross(c, a), sign), scale(cross(a, b), sign)]
}

/// The inverse, if there is one.
pub fn inverse(m: &[f64; 16]) -> Option<[f64; 16]> {
    let inverse = Matrix4::from_column_slice(m).try_inverse()?;
    let out: Matrix = inverse.as_slice().try_into().ok()?;
    out.iter().all(|x| x.is_finite()).then_some(out)
}

/// The same transform with lengths in another unit, on both sides: S m S^-1 with S a uniform scale.
pub(crate) fn in_unit(m: &Matrix, unit: f64) -> Matrix {
    let mut out = *m;
    for i in 0..3 {
        out[12 + i] *= unit;
        out[4 * i + 3] /= unit;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_z() {
        let h = 0.5f64.sqrt();
        let m = from_trs([1.0, 0.0, 0.0], [0.0, 0.0, h, h], [2.0, 3.0, 4.0]);
        let p = point(&m, [1.0, 1.0, 1.0]);
        for (a, b) in p.iter().zip([-2.0, 2.0, 4.0]) {
            assert!((a - b).abs() < 1e-12, "{p:?}");
        }
        let back = point(&inverse(&m).unwrap(), p);
        assert!(back.iter().all(|x| (x - 1.0).abs() < 1e-12));
        let id = mul(&m, &inverse(&m).unwrap());
        assert!(id.iter().zip(IDENTITY).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!((determinant(&m) - 24.0).abs() < 1e-12);
    }
}
