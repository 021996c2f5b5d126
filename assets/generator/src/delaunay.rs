//! A plain incremental Delaunay triangulation, enough for the few hundred points of a panel.

use crate::math::{V2, cross2, noise};

/// The Delaunay triangles, counter-clockwise, of points about `h` apart.
///
/// The points are moved by a hundred-thousandth of `h` for the decisions only, so that rows of collinear or cocircular
/// samples, which panels are full of, leave no ties.
pub fn triangulate(points: &[V2], h: f64) -> Vec<[usize; 3]> {
    let n = points.len();
    let nudge = |i: usize, k: u64| noise(2 * i as u64 + k) * 1e-5 * h;
    let mut p: Vec<V2> = points.iter().enumerate().map(|(i, q)| [q[0] + nudge(i, 0), q[1] + nudge(i, 1)]).collect();
    p.extend([[-100.0, -100.0], [100.0, -100.0], [0.0, 150.0]]);
    let mut tris = vec![Circle::new(&p, [n, n + 1, n + 2])];
    let mut rim: Vec<[usize; 2]> = Vec::new();
    for i in 0..n {
        rim.clear();
        tris.retain(|t| {
            let hit = t.holds(p[i]);
            if hit {
                rim.extend([[t.v[0], t.v[1]], [t.v[1], t.v[2]], [t.v[2], t.v[0]]]);
            }
            !hit
        });
        for &[a, b] in &rim {
            if !rim.contains(&[b, a]) {
                tris.push(Circle::new(&p, [a, b, i]));
            }
        }
    }
    tris.into_iter().map(|t| t.v).filter(|v| v.iter().all(|&i| i < n)).collect()
}

/// A triangle with its circumcircle.
struct Circle {
    v: [usize; 3],
    centre: V2,
    radius2: f64,
}

impl Circle {
    fn new(p: &[V2], v: [usize; 3]) -> Self {
        let [a, b, c] = v.map(|i| p[i]);
        let (bx, by, cx, cy) = (b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]);
        let d = 2.0 * cross2(a, b, c);
        let (bb, cc) = (bx * bx + by * by, cx * cx + cy * cy);
        let (ux, uy) = ((cy * bb - by * cc) / d, (bx * cc - cx * bb) / d);
        Self { v, centre: [a[0] + ux, a[1] + uy], radius2: ux * ux + uy * uy }
    }

    fn holds(&self, q: V2) -> bool {
        let (x, y) = (q[0] - self.centre[0], q[1] - self.centre[1]);
        x * x + y * y < self.radius2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lattice_is_filled() {
        let points: Vec<V2> = (0..100).map(|i| [f64::from(i % 10) * 0.1, f64::from(i / 10) * 0.1]).collect();
        let tris = triangulate(&points, 0.1);
        let area: f64 = tris.iter().map(|t| cross2(points[t[0]], points[t[1]], points[t[2]]) / 2.0).sum();
        assert!((area - 0.81).abs() < 1e-3, "{area}");
    }
}
