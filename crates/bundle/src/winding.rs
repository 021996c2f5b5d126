//! Whether a point is inside of triangles that may have holes, several parts and parts within parts.

mod cluster;

use cluster::Cluster;

/// Tangent of the half angle below which a triangle is far away, as nearly all are.
const FAR: f64 = 0.125;
/// Triangles that are not divided further; if there are no more, each counts by itself.
const FEW: usize = 8;

type V3 = [f64; 3];

/// Triangles, and how often they wind around a point.
#[derive(Clone, Debug)]
pub struct Winding {
    /// Those of each node of the tree one after the other.
    corners: Vec<[V3; 3]>,
    /// A binary tree, parents before children, the first child next to its parent.
    nodes: Vec<Node>,
}

#[derive(Clone, Debug)]
struct Node {
    cluster: Cluster,
    triangles: std::ops::Range<u32>,
    /// The node after all that are below this one.
    next: u32,
}

impl Winding {
    /// That of triangles given by their corners, counter-clockwise as seen from outside. O(n log n).
    pub fn new(corners: impl Iterator<Item = [[f64; 3]; 3]>) -> Self {
        let mut winding = Winding { corners: corners.collect(), nodes: Vec::new() };
        winding.divide(0, winding.corners.len());
        winding
    }

    /// Adds the nodes of some triangles, halved along their longest side.
    fn divide(&mut self, first: usize, end: usize) {
        let (own, at) = (&mut self.corners[first..end], self.nodes.len());
        self.nodes.push(Node { cluster: Cluster::of(own), triangles: first as u32..end as u32, next: 0 });
        if own.len() > FEW {
            let side = |axis: usize| {
                let of = |t: &[V3; 3]| t[0][axis] + t[1][axis] + t[2][axis];
                let (least, most) = own.iter().map(of).fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
                most - least
            };
            let axis = (0..3).max_by(|a, b| side(*a).total_cmp(&side(*b))).unwrap_or(0);
            let key = |t: &[V3; 3]| t[0][axis] + t[1][axis] + t[2][axis];
            own.sort_by(|a, b| key(a).total_cmp(&key(b)));
            let middle = first + own.len() / 2;
            self.divide(first, middle);
            self.divide(middle, end);
        }
        self.nodes[at].next = self.nodes.len() as u32;
    }

    /// The generalised winding number (Jacobson, Kavan and Sorkine-Hornung 2013): 1 inside a closed surface, 0 outside, between them
    /// near holes. Triangles that are far from the point count together, by their expansion to second order (Barill et al. 2018), so that it
    /// is within 0.01 of the exact one. About O(log triangles).
    pub fn number(&self, p: [f64; 3]) -> f64 {
        let (mut at, mut sum) = (0, 0.0);
        let together = self.corners.len() > FEW;
        while let Some(node) = self.nodes.get(at) {
            if let Some(angle) = node.cluster.half_angle(p).filter(|_| together) {
                sum += angle;
                at = node.next as usize;
                continue;
            }
            if node.triangles.len() <= FEW {
                let own = &self.corners[node.triangles.start as usize..node.triangles.end as usize];
                sum += own.iter().map(|t| half_angle(t, p)).sum::<f64>();
            }
            at += 1;
        }
        sum / (2.0 * std::f64::consts::PI)
    }
}

/// Half of the solid angle of a triangle (Van Oosterom and Strackee 1983).
#[inline(always)]
fn half_angle([a, b, c]: &[V3; 3], p: V3) -> f64 {
    let (a, b, c) = (sub(*a, p), sub(*b, p), sub(*c, p));
    let (la, lb, lc) = (dot(a, a).sqrt(), dot(b, b).sqrt(), dot(c, c).sqrt());
    let across = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    let volume = dot(a, cross(b, c));
    if volume.abs() < FAR * across { small_angle(volume / across) } else { volume.atan2(across) }
}

/// The arc tangent of a number below [`FAR`], to 1e-11.
#[inline(always)]
fn small_angle(x: f64) -> f64 {
    let s = x * x;
    x * (1.0 - s * (1.0 / 3.0 - s * (0.2 - s * (1.0 / 7.0 - s / 9.0))))
}

#[inline(always)]
fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
#[path = "winding/tests.rs"]
mod tests;
