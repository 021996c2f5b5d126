//! Where joints put points: linear blend skinning, or dual quaternions.

use super::skin::{Influence, Rows};
use crate::number::real::{Real, V3, add, cast, cross, dot, scale};
use crate::number::turn::quaternion;

/// How points that follow several joints move between them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Skinning {
    /// The weighed mean of the places where the joints put a point. The default of glTF; a limb that twists loses volume, all of it at 180 degrees.
    #[default]
    Linear,
    /// The weighed mean of the motions, as dual quaternions (L. Kavan et al., "Geometric Skinning with Approximate Dual Quaternion Blending", 2008): a
    /// limb that twists keeps its volume, and bulges slightly where it bends. Stretches of joints are blended apart from
    /// their motions, linearly.
    DualQuaternion,
}

/// The poses of joints, by which a host moves points as a cloth on these joints moves its own.
///
/// ```
/// use gimage_runtime::{JointPoses, Skinning};
///
/// let still = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
/// let mut raised = still;
/// raised[13] = 0.5;
/// let poses = JointPoses::new(Skinning::DualQuaternion, &[still, raised]);
/// assert!((poses.place(&[(0, 0.5), (1, 0.5)], [1.0, 1.0, 1.0])[1] - 1.25).abs() < 1e-6);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct JointPoses(Poses<f64>);

impl JointPoses {
    /// For matrices as [`crate::Stepper::set_joints`] takes them. 1 microsecond per joint for dual quaternions.
    pub fn new(skinning: Skinning, matrices: &[[f32; 16]]) -> Self {
        let rows = |m: &[f32; 16]| [0, 1, 2].map(|r| [m[r], m[4 + r], m[8 + r], m[12 + r]]);
        JointPoses(Poses::new(skinning, &matrices.iter().map(rows).collect::<Vec<_>>()))
    }

    /// Where a point at rest \[m\] is that follows some joints with these weights, of sum 1; itself where it follows none that exists.
    pub fn place(&self, shares: &[(u32, f64)], p: [f64; 3]) -> [f64; 3] {
        self.blend(shares).map_or(p, |blend| blend.place(p))
    }

    /// Where a vector at rest points, a normal for example; its length changes as joints stretch.
    pub fn turn(&self, shares: &[(u32, f64)], v: [f64; 3]) -> [f64; 3] {
        self.blend(shares).map_or(v, |blend| blend.turn(v))
    }

    fn blend(&self, shares: &[(u32, f64)]) -> Option<Blend<f64>> {
        let there =
            || shares.iter().copied().filter(|(joint, weight)| *weight > 0.0 && (*joint as usize) < self.0.len());
        there().next().map(|_| self.0.blend(there()))
    }
}

/// The poses of all joints.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Poses<T> {
    Linear(Vec<[[T; 4]; 3]>),
    Dual(Vec<Dual<T>>),
}

/// A joint as a stretch, then a rigid motion: four vectors of four, as shaders/part/pose_dual.wgsl reads them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dual<T> {
    /// The quaternion of the turn, x, y, z, w.
    real: [T; 4],
    /// Half the shift times it.
    dual: [T; 4],
    /// The symmetric matrix of the stretch: xx, yy, zz; then xy, yz, zx.
    stretch: [T; 4],
    shear: [T; 4],
}

/// The blend of the joints that a point follows.
pub(crate) enum Blend<T> {
    Linear([[T; 4]; 3]),
    Dual(Dual<T>),
}

impl<T: Real> Poses<T> {
    pub fn new(skinning: Skinning, matrices: &[Rows]) -> Self {
        match skinning {
            Skinning::Linear => Poses::Linear(matrices.iter().map(|r| r.map(cast)).collect()),
            Skinning::DualQuaternion => Poses::Dual(matrices.iter().map(|r| Dual::of(r).cast()).collect()),
        }
    }

    /// Those of no joints.
    pub fn none() -> Self {
        Poses::Linear(Vec::new())
    }

    /// The number of joints.
    pub fn len(&self) -> usize {
        match self {
            Poses::Linear(list) => list.len(),
            Poses::Dual(list) => list.len(),
        }
    }

    /// Whether there are no joints.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Where a point at rest is.
    #[inline]
    pub fn place(&self, own: &[Influence], p: V3<T>) -> V3<T> {
        let each = own.iter().flat_map(|i| i.joints.iter().zip(&i.weights)).filter(|(_, w)| **w > 0.0);
        self.blend(each.map(|(joint, weight)| (*joint, T::of(f64::from(*weight))))).place(p)
    }

    /// The blend of joints by weights above 0.
    #[inline]
    pub fn blend(&self, shares: impl Iterator<Item = (u32, T)>) -> Blend<T> {
        let zero = T::of(0.0);
        match self {
            Poses::Linear(list) => {
                let mut sum = [[zero; 4]; 3];
                for (joint, weight) in shares {
                    for (row, other) in sum.iter_mut().zip(&list[joint as usize]) {
                        row.iter_mut().zip(other).for_each(|(sum, x)| *sum = *sum + *x * weight);
                    }
                }
                Blend::Linear(sum)
            }
            Poses::Dual(list) => {
                let none = [zero; 4];
                let mut sum = Dual { real: none, dual: none, stretch: none, shear: none };
                for (joint, weight) in shares {
                    let pose = &list[joint as usize];
                    // A quaternion and its opposite are one turn: the one on the side of those before is the shorter way.
                    let along = (0..4).fold(zero, |along, c| along + sum.real[c] * pose.real[c]);
                    let signed = if along < zero { zero - weight } else { weight };
                    let add = |to: &mut [T; 4], from: &[T; 4], by: T| {
                        to.iter_mut().zip(from).for_each(|(sum, x)| *sum = *sum + *x * by);
                    };
                    add(&mut sum.real, &pose.real, signed);
                    add(&mut sum.dual, &pose.dual, signed);
                    add(&mut sum.stretch, &pose.stretch, weight);
                    add(&mut sum.shear, &pose.shear, weight);
                }
                Blend::Dual(sum)
            }
        }
    }
}

#[cfg(feature = "gpu")]
impl Poses<f32> {
    /// The vectors of all joints, as shaders read them: three rows of a matrix each, or the four of a [`Dual`].
    pub fn list(&self) -> Vec<[f32; 4]> {
        match self {
            Poses::Linear(list) => list.as_flattened().to_vec(),
            Poses::Dual(list) => list.iter().flat_map(|d| [d.real, d.dual, d.stretch, d.shear]).collect(),
        }
    }
}

impl<T: Real> Blend<T> {
    /// Where a point at rest is.
    #[inline]
    pub fn place(&self, p: V3<T>) -> V3<T> {
        match self {
            Blend::Linear(rows) => rows.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]),
            Blend::Dual(pose) => pose.place(p),
        }
    }

    /// Where a vector at rest points.
    #[inline]
    pub fn turn(&self, v: V3<T>) -> V3<T> {
        match self {
            Blend::Linear(rows) => rows.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]),
            Blend::Dual(pose) => pose.turn(v),
        }
    }
}

impl<T: Real> Dual<T> {
    fn cast<U: Real>(self) -> Dual<U> {
        let Dual { real, dual, stretch, shear } = self;
        Dual { real: cast(real), dual: cast(dual), stretch: cast(stretch), shear: cast(shear) }
    }

    fn stretched(&self, [x, y, z]: V3<T>) -> V3<T> {
        let ([xx, yy, zz, _], [xy, yz, zx, _]) = (self.stretch, self.shear);
        [xx * x + xy * y + zx * z, xy * x + yy * y + yz * z, zx * x + yz * y + zz * z]
    }

    /// The quaternions at length 1.
    fn unit(&self) -> ([T; 4], [T; 4]) {
        let r = self.real;
        let length = (r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]).sqrt();
        let by = if length > T::of(0.0) { T::of(1.0) / length } else { T::of(0.0) };
        (r.map(|x| x * by), self.dual.map(|x| x * by))
    }

    fn turn(&self, v: V3<T>) -> V3<T> {
        rotated(self.unit().0, self.stretched(v))
    }

    fn place(&self, p: V3<T>) -> V3<T> {
        let (real, dual) = self.unit();
        let (r, d) = ([real[0], real[1], real[2]], [dual[0], dual[1], dual[2]]);
        let way = cross(r, d);
        let shift = [0, 1, 2].map(|c| T::of(2.0) * (real[3] * d[c] - dual[3] * r[c] + way[c]));
        add(rotated(real, self.stretched(p)), shift)
    }
}

/// A vector turned by a unit quaternion.
fn rotated<T: Real>([x, y, z, w]: [T; 4], v: V3<T>) -> V3<T> {
    let r = [x, y, z];
    add(v, scale(cross(r, add(cross(r, v), scale(v, w))), T::of(2.0)))
}

impl Dual<f64> {
    /// A joint matrix, parted into a stretch and the rigid motion after it. A mirrored joint has a stretch that mirrors, a flat one any turn that
    /// has it where it is.
    fn of(rows: &Rows) -> Self {
        let rows: [[f64; 4]; 3] = rows.map(cast);
        let column = |c: usize| rows.map(|row| row[c]);
        let columns = [column(0), column(1), column(2)];
        // The stretch is the root of the square of the matrix; its axes are the axes of that.
        let square: [V3<f64>; 3] = [0, 1, 2].map(|i| [0, 1, 2].map(|j| dot(columns[i], columns[j])));
        let (axes, squares) = axes(square);
        let sizes = squares.map(|s| s.max(0.0).sqrt());
        let image = |v: V3<f64>| [0, 1, 2].map(|r| (0..3).map(|c| rows[r][c] * v[c]).sum::<f64>());
        // From the longest to the shortest: two that have a direction give the third one.
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| sizes[*b].total_cmp(&sizes[*a]));
        let [a, b, c] = order;
        let first = unit_or(image(axes[a]), sizes[a], axes[a]);
        let second = {
            let v = image(axes[b]);
            let rest = [0, 1, 2].map(|k| v[k] - first[k] * dot(first, v));
            unit_or(rest, sizes[b], across(first))
        };
        // The axes may be left-handed.
        let hand = if dot(cross(axes[a], axes[b]), axes[c]) < 0.0 { -1.0 } else { 1.0 };
        let third = scale(cross(first, second), hand);
        let mut images = [[0.0; 3]; 3];
        (images[a], images[b], images[c]) = (first, second, third);
        let mut stretches = sizes;
        if dot(third, image(axes[c])) < 0.0 {
            stretches[c] = -stretches[c];
        }
        let sum = |f: &dyn Fn(usize) -> f64| (0..3).map(f).sum::<f64>();
        // The columns of the turn.
        let turn = [0, 1, 2].map(|k| [0, 1, 2].map(|r| sum(&|n| images[n][r] * axes[n][k])));
        let stretch = |i: usize, j: usize| sum(&|n| stretches[n] * axes[n][i] * axes[n][j]);
        let real = quaternion(&turn);
        let ([x, y, z], [qx, qy, qz, qw]) = (column(3), real);
        let dual = [
            0.5 * (x * qw + y * qz - z * qy),
            0.5 * (y * qw + z * qx - x * qz),
            0.5 * (z * qw + x * qy - y * qx),
            -0.5 * (x * qx + y * qy + z * qz),
        ];
        Dual {
            real,
            dual,
            stretch: [stretch(0, 0), stretch(1, 1), stretch(2, 2), 0.0],
            shear: [stretch(0, 1), stretch(1, 2), stretch(2, 0), 0.0],
        }
    }
}

/// A vector at length 1; another one if it is shorter than rounding of `size`.
fn unit_or(v: V3<f64>, size: f64, other: V3<f64>) -> V3<f64> {
    let length = dot(v, v).sqrt();
    if length > 1e-12 * size.max(1e-300) && length > 1e-150 { scale(v, 1.0 / length) } else { other }
}

/// A unit vector across another one.
fn across(v: V3<f64>) -> V3<f64> {
    let least = (0..3).min_by(|a, b| v[*a].abs().total_cmp(&v[*b].abs())).unwrap_or(0);
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let way = cross(v, axis);
    scale(way, 1.0 / dot(way, way).sqrt().max(1e-300))
}

/// The axes of a symmetric matrix and its size along each, by Jacobi's method.
fn axes(mut m: [V3<f64>; 3]) -> ([V3<f64>; 3], [f64; 3]) {
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Convergence is quadratic: five sweeps are enough for 3 x 3.
    for (i, j) in [(0, 1), (1, 2), (0, 2)].into_iter().cycle().take(18) {
        if m[i][j].abs() <= 1e-18 * (m[i][i] * m[j][j]).abs().sqrt() {
            continue;
        }
        let theta = (m[j][j] - m[i][i]) / (2.0 * m[i][j]);
        let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
        let cos = 1.0 / (t * t + 1.0).sqrt();
        let sin = t * cos;
        for row in &mut m {
            (row[i], row[j]) = (cos * row[i] - sin * row[j], sin * row[i] + cos * row[j]);
        }
        let (a, b) = (m[i], m[j]);
        m[i] = [0, 1, 2].map(|k| cos * a[k] - sin * b[k]);
        m[j] = [0, 1, 2].map(|k| sin * a[k] + cos * b[k]);
        let (a, b) = (axes[i], axes[j]);
        axes[i] = [0, 1, 2].map(|k| cos * a[k] - sin * b[k]);
        axes[j] = [0, 1, 2].map(|k| sin * a[k] + cos * b[k]);
    }
    (axes, [m[0][0], m[1][1], m[2][2]])
}

#[cfg(test)]
#[path = "poses_tests.rs"]
mod tests;
