//! Triangles that are seen together from far away: the solid angle of all of them by its expansion about their middle.

use super::{V3, cross, dot, sub};

/// Distance from which triangles count together, in radii of the ball around them.
const APART: f64 = 2.0;

/// The integrals over triangles that the expansion is made of, d being the way from their middle and n the normal.
#[derive(Clone, Debug)]
pub struct Cluster {
    middle: V3,
    /// The square of the distance from which the expansion holds.
    apart2: f64,
    /// Of n.
    area: V3,
    /// Of d n^T, symmetrised, as xx, yy, zz, xy, yz, zx. All terms that follow are symmetric too: nothing else is asked of them.
    first: [f64; 6],
    /// Of n (d . d) + 2 d (n . d).
    long: V3,
    /// Of the symmetric part of n d d: xxx, yyy, zzz, then each of xxy, xxz, yyx, yyz, zzx, zzy three times, and xyz six times.
    second: [f64; 10],
}

impl Cluster {
    /// Of triangles given by their corners.
    pub fn of(triangles: &[[V3; 3]]) -> Self {
        let normal = |[a, b, c]: &[V3; 3]| cross(sub(*b, *a), sub(*c, *a)).map(|x| 0.5 * x);
        let centre = |[a, b, c]: &[V3; 3]| [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
        let (mut whole, mut middle, mut mean) = (0.0, [0.0; 3], [0.0; 3]);
        for t in triangles {
            let (n, at) = (normal(t), centre(t));
            let area = dot(n, n).sqrt();
            whole += area;
            for k in 0..3 {
                middle[k] += area * at[k];
                mean[k] += at[k] / triangles.len() as f64;
            }
        }
        let middle = if whole > 0.0 { middle.map(|x| x / whole) } else { mean };
        let mut cluster =
            Cluster { middle, apart2: 0.0, area: [0.0; 3], first: [0.0; 6], long: [0.0; 3], second: [0.0; 10] };
        let mut radius2 = 0.0f64;
        for t in triangles {
            let (n, at) = (normal(t), sub(centre(t), middle));
            let d = t.map(|corner| sub(corner, middle));
            radius2 = d.iter().fold(radius2, |most, d| most.max(dot(*d, *d)));
            cluster.add(n, at, d);
        }
        cluster.apart2 = APART * APART * radius2;
        cluster
    }

    /// Adds a triangle of area vector n.
    fn add(&mut self, n: V3, at: V3, d: [V3; 3]) {
        // The mean of d d^T over a triangle.
        let square = |i: usize, j: usize| (d.iter().map(|d| d[i] * d[j]).sum::<f64>() + 9.0 * at[i] * at[j]) / 12.0;
        let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
        let s: [[f64; 3]; 3] = [0, 1, 2].map(|i| [0, 1, 2].map(|j| square(i, j)));
        let across = s[0][0] + s[1][1] + s[2][2];
        for k in 0..3 {
            self.area[k] += n[k];
            self.long[k] += n[k] * across + 2.0 * dot(s[k], n);
        }
        for (sum, (i, j)) in self.first.iter_mut().zip(pairs) {
            *sum += 0.5 * (at[i] * n[j] + at[j] * n[i]);
        }
        for k in 0..3 {
            self.second[k] += s[k][k] * n[k];
        }
        let twice = [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)];
        for (sum, (i, j)) in self.second[3..9].iter_mut().zip(twice) {
            *sum += s[i][i] * n[j] + 2.0 * s[i][j] * n[i];
        }
        self.second[9] += 2.0 * (s[0][1] * n[2] + s[1][2] * n[0] + s[2][0] * n[1]);
    }

    /// Half of their solid angle as seen from a point, if that is far enough from them.
    #[inline(always)]
    pub fn half_angle(&self, p: V3) -> Option<f64> {
        let q = sub(self.middle, p);
        let far2 = dot(q, q);
        if far2 <= self.apart2 {
            return None;
        }
        let [x, y, z] = q;
        let (f, s) = (&self.first, &self.second);
        let trace = f[0] + f[1] + f[2];
        let twice = x * x * f[0] + y * y * f[1] + z * z * f[2] + 2.0 * (x * y * f[3] + y * z * f[4] + z * x * f[5]);
        let thrice = x * x * (x * s[0] + y * s[3] + z * s[4])
            + y * y * (y * s[1] + x * s[5] + z * s[6])
            + z * z * (z * s[2] + x * s[7] + y * s[8])
            + x * y * z * s[9];
        let near2 = 1.0 / far2;
        let near3 = near2 * near2.sqrt();
        let first = trace - 3.0 * twice * near2;
        let second = 1.5 * near2 * (5.0 * thrice * near2 - dot(self.long, q));
        Some(0.5 * near3 * (dot(self.area, q) + first + second))
    }
}
