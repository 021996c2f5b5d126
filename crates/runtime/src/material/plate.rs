//! The Laplacian of bilinear elements on the cells of a cloth, and where it measures bending.

use super::cell::{Cell, P2, cross, sub};
use crate::cloth::Bending;

/// Sums to which cells add.
pub struct Plate {
    weights: Vec<[f64; 4]>,
    /// By the first of the duplicates \[m^2\].
    pub area: Vec<f64>,
    fans: Fans,
    cells: Vec<([usize; 4], [f64; 4])>,
}

/// Around an inner point every edge is the end of one cell and the beginning of the next. Sums of hashes tell.
struct Fans(Vec<u64>);

impl Plate {
    /// Nothing yet; `count` particles.
    pub fn new(count: usize) -> Self {
        Plate { weights: vec![[0.0; 4]; count], area: vec![0.0; count], fans: Fans(vec![0; count]), cells: Vec::new() }
    }

    /// Adds a cell; `same` names the first duplicate of every particle.
    pub fn add(&mut self, cell: &Cell, same: &[u32]) {
        let point = |k: usize| same[cell.corners[k]] as usize;
        let (mut areas, bent) = match element(cell) {
            Some(Element { stiffness, areas }) => {
                for ([a, b], stored, direction) in cell.springs() {
                    self.weights[stored][direction] -= stiffness[a][b];
                }
                (areas, true)
            }
            // Folded over itself: it has a mass, but no moment can be told.
            None => ([0.25 * super::membrane::area(cell); 4], false),
        };
        (0..4).filter(|k| !cell.there[*k]).for_each(|k| areas[k] = 0.0);
        (0..4).filter(|k| cell.there[*k]).for_each(|k| self.area[point(k)] += areas[k]);
        let around: Vec<usize> = cell.around().collect();
        for (n, k) in around.iter().enumerate() {
            let next = point(around[(n + 1) % around.len()]);
            let last = point(around[(n + around.len() - 1) % around.len()]);
            self.fans.add(point(*k), if bent { next } else { usize::MAX }, last);
        }
        self.cells.push((cell.corners, areas));
    }

    /// Bending of a cloth for a stiffness \[N m\] above 0. The weight of a cell at points without a moment counts at its
    /// other ones, so that the energy of a curved sheet is the same on every grid.
    pub fn bending(&self, same: &[u32], stiffness: f64) -> Bending {
        let inner = |k: usize| self.fans.0[same[k] as usize] == 0;
        let mut area = vec![0.0; same.len()];
        for (corners, areas) in &self.cells {
            let here = |k: &usize| areas[*k] > 0.0 && inner(corners[*k]);
            let count = (0..4).filter(here).count() as f64;
            let rest: f64 = (0..4).filter(|k| !here(k)).map(|k| areas[k]).sum();
            (0..4).filter(here).for_each(|k| area[same[corners[k]] as usize] += areas[k] + rest / count);
        }
        // The curvature is the moment over a point's own area, and counts for all of the area that it stands for.
        let soft = |k: usize| if area[k] > 0.0 { self.area[k] * self.area[k] / (area[k] * stiffness) } else { 0.0 };
        Bending {
            weights: self.weights.iter().map(|w| w.map(|x| x as f32)).collect(),
            compliance: same.iter().map(|k| soft(*k as usize) as f32).collect(),
        }
    }
}

impl Fans {
    fn add(&mut self, point: usize, next: usize, last: usize) {
        self.0[point] = self.0[point].wrapping_add(hash(next)).wrapping_sub(hash(last));
    }
}

/// SplitMix64 (G. Steele, D. Lea, C. Flood, OOPSLA 2014).
fn hash(k: usize) -> u64 {
    let mut z = (k as u64).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

struct Element {
    /// Integrals of the products of gradients.
    stiffness: [[f64; 4]; 4],
    /// Integrals of the functions \[m^2\].
    areas: [f64; 4],
}

/// A bilinear element over four corners, a linear one over three; none where it is folded.
fn element(cell: &Cell) -> Option<Element> {
    let mut out = Element { stiffness: [[0.0; 4]; 4], areas: [0.0; 4] };
    let g = 0.5 / 3f64.sqrt();
    let four = [(0.5 - g, 0.5 - g), (0.5 + g, 0.5 - g), (0.5 - g, 0.5 + g), (0.5 + g, 0.5 + g)].map(|p| (p, 0.25));
    let whole = cell.there == [true; 4];
    let points = if whole { &four[..] } else { &[((0.0, 0.0), 0.5)] };
    for &((u, v), share) in points {
        let (gradients, values) = if whole { bilinear(u, v) } else { linear(cell) };
        let column = |c: usize| -> P2 { [0, 1].map(|d| (0..4).map(|k| cell.at[k][d] * gradients[k][c]).sum()) };
        let (a, b) = (column(0), column(1));
        let det = cross(a, b);
        if det <= 0.0 {
            return None;
        }
        // Gradients in the plane.
        let plane = gradients.map(|g| [(g[0] * b[1] - g[1] * a[1]) / det, (g[1] * a[0] - g[0] * b[0]) / det]);
        for (r, p) in plane.iter().enumerate() {
            out.areas[r] += share * det * values[r];
            (0..4).for_each(|c| out.stiffness[r][c] += share * det * (p[0] * plane[c][0] + p[1] * plane[c][1]));
        }
    }
    Some(out)
}

fn bilinear(u: f64, v: f64) -> ([P2; 4], [f64; 4]) {
    let gradients = [[v - 1.0, u - 1.0], [1.0 - v, -u], [-v, 1.0 - u], [v, u]];
    (gradients, [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v])
}

/// On the triangle of three corners, the first two sides of which are the axes, turned the way of the grid.
fn linear(cell: &Cell) -> ([P2; 4], [f64; 4]) {
    let mut k: Vec<usize> = (0..4).filter(|k| cell.there[*k]).collect();
    if k.len() == 3 && cross(sub(cell.at[k[1]], cell.at[k[0]]), sub(cell.at[k[2]], cell.at[k[0]])) < 0.0 {
        k.swap(1, 2);
    }
    let (mut gradients, mut values) = ([[0.0; 2]; 4], [0.0; 4]);
    for (k, g) in k.into_iter().zip([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]]) {
        (gradients[k], values[k]) = (g, 1.0 / 3.0);
    }
    (gradients, values)
}
