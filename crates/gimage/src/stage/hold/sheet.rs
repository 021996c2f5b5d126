//! A garment as one surface: the images of its pieces, welded.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use gimage_bundle::DisjointSets;

use crate::base::mesh::NONE;
use crate::base::vec3::{add, cross, distance, norm, normalize, sub};
use crate::stage::assemble::Piece;
use crate::stage::split::PartTexel;

/// Points of a garment, which its texels stand for.
pub(crate) struct Sheet {
    /// The point of each texel, by pieces.
    pub points: Vec<Vec<u32>>,
    /// Positions \[m\].
    pub positions: Vec<[f64; 3]>,
    /// Unit normals, zero where the surface has none.
    pub normals: Vec<[f64; 3]>,
    /// Area of each point \[m2\].
    pub areas: Vec<f64>,
    /// Points of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// The points of each border, by its number.
    pub borders: Vec<Vec<u32>>,
    /// For each point the first of its neighbours; one more at the end.
    first: Vec<u32>,
    /// Neighbours and the distances to them \[m\].
    around: Vec<(u32, f64)>,
}

impl Sheet {
    /// Welds the pieces of a garment along their own rings and along `rings` across them.
    pub fn new(pieces: &[Piece<'_>], rings: &[Vec<PartTexel>]) -> Self {
        let mut starts = vec![0u32];
        for Piece { image, .. } in pieces {
            starts.push(starts.last().copied().unwrap_or(0) + image.grid.positions.len() as u32);
        }
        let points = weld(pieces, rings, &starts);
        let count = points.iter().flatten().max().map_or(0, |p| *p as usize + 1);
        let mut sheet = Sheet {
            points,
            positions: vec![[0.0; 3]; count],
            normals: vec![[0.0; 3]; count],
            areas: vec![0.0; count],
            triangles: Vec::new(),
            borders: Vec::new(),
            first: Vec::new(),
            around: Vec::new(),
        };
        let mut borders: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (Piece { image, .. }, points) in pieces.iter().zip(&sheet.points) {
            for (at, &p) in points.iter().enumerate() {
                sheet.positions[p as usize] = image.grid.positions[at];
                if image.loop_of[at] != NONE {
                    borders.entry(image.loop_of[at]).or_default().push(p);
                }
            }
        }
        borders.values_mut().for_each(|border| {
            border.sort_unstable();
            border.dedup();
        });
        sheet.borders = borders.into_values().collect();
        sheet.measure(pieces);
        sheet.connect(pieces);
        sheet
    }

    /// Normals and areas.
    fn measure(&mut self, pieces: &[Piece<'_>]) {
        for (Piece { image, .. }, points) in pieces.iter().zip(&self.points) {
            for corners in image.grid.triangulate() {
                let corners = corners.map(|k| points[k as usize]);
                self.triangles.push(corners);
                let corners = corners.map(|p| p as usize);
                let [a, b, c] = corners.map(|p| self.positions[p]);
                let n = cross(sub(b, a), sub(c, a));
                for p in corners {
                    self.normals[p] = add(self.normals[p], n);
                    self.areas[p] += norm(n) / 6.0;
                }
            }
        }
        self.normals.iter_mut().for_each(|n| *n = if norm(*n) > 0.0 { normalize(*n) } else { *n });
    }

    /// Neighbours along the rows, the columns and the diagonals of the images.
    fn connect(&mut self, pieces: &[Piece<'_>]) {
        let mut edges: Vec<[u32; 2]> = Vec::new();
        for (Piece { image, .. }, points) in pieces.iter().zip(&self.points) {
            let (w, h) = (image.grid.width, image.grid.height);
            for k in 0..w * h {
                let (i, j) = (k % w, k / w);
                let ends = [
                    (i + 1 < w, k + 1),
                    (j + 1 < h, k + w),
                    (i + 1 < w && j + 1 < h, k + w + 1),
                    (i > 0 && j + 1 < h, k + w - 1),
                ];
                let inside = ends.iter().filter(|(inside, _)| *inside);
                edges.extend(inside.map(|(_, end)| [points[k], points[*end]]).filter(|[a, b]| a != b));
            }
        }
        let mut both: Vec<[u32; 2]> = edges.iter().flat_map(|&[a, b]| [[a, b], [b, a]]).collect();
        both.sort_unstable();
        both.dedup();
        self.first = vec![0; self.positions.len() + 1];
        both.iter().for_each(|[a, _]| self.first[*a as usize + 1] += 1);
        (0..self.positions.len()).for_each(|p| self.first[p + 1] += self.first[p]);
        let far = |a: u32, b: u32| distance(self.positions[a as usize], self.positions[b as usize]);
        self.around = both.iter().map(|&[a, b]| (b, far(a, b))).collect();
    }

    /// The points beside a point.
    pub fn neighbours(&self, point: u32) -> impl Iterator<Item = u32> + '_ {
        let [first, end] = [0, 1].map(|k| self.first[point as usize + k] as usize);
        self.around[first..end].iter().map(|(p, _)| *p)
    }

    /// Distance \[m\] of a point from the nearest one beside it, 0 for a point without any.
    pub fn spacing(&self, point: u32) -> f64 {
        let [first, end] = [0, 1].map(|k| self.first[point as usize + k] as usize);
        self.around[first..end].iter().map(|(_, far)| *far).reduce(f64::min).unwrap_or(0.0)
    }

    /// Lowest and highest point \[m\].
    pub fn span(&self) -> [f64; 2] {
        self.positions.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], p| [lo.min(p[1]), hi.max(p[1])])
    }

    /// Distance \[m\] of each point along edges of the images from the nearest of some, infinite beyond `most` \[m\].
    pub fn distances(&self, from: impl Iterator<Item = u32>, most: f64) -> Vec<f64> {
        let mut best = vec![f64::INFINITY; self.positions.len()];
        let mut queue: BinaryHeap<Reverse<(u64, u32)>> = BinaryHeap::new();
        // The bits of positive numbers have their order.
        from.for_each(|p| {
            best[p as usize] = 0.0;
            queue.push(Reverse((0, p)));
        });
        while let Some(Reverse((bits, p))) = queue.pop() {
            let far = f64::from_bits(bits);
            if far > best[p as usize] {
                continue;
            }
            for &(q, length) in &self.around[self.first[p as usize] as usize..self.first[p as usize + 1] as usize] {
                let next = far + length;
                if next <= most && next < best[q as usize] {
                    best[q as usize] = next;
                    queue.push(Reverse((next.to_bits(), q)));
                }
            }
        }
        best
    }
}

/// The point of each texel, by pieces, numbered in the order of their first texels.
fn weld(pieces: &[Piece<'_>], rings: &[Vec<PartTexel>], starts: &[u32]) -> Vec<Vec<u32>> {
    let total = starts.last().copied().unwrap_or(0);
    let mut sets = DisjointSets::new(total as usize);
    for (Piece { image, .. }, &start) in pieces.iter().zip(starts) {
        for (k, &link) in image.grid.links.iter().enumerate().filter(|x| *x.1 != NONE) {
            sets.union(start + k as u32, start + link);
        }
    }
    for ring in rings {
        for pair in ring.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|(p, at)| starts[p as usize] + at);
            sets.union(a, b);
        }
    }
    let mut number = vec![NONE; total as usize];
    let mut next = 0;
    let of_point: Vec<u32> = sets
        .into_representatives()
        .into_iter()
        .map(|root| {
            let point = &mut number[root as usize];
            if *point == NONE {
                *point = next;
                next += 1;
            }
            *point
        })
        .collect();
    starts.windows(2).map(|pair| of_point[pair[0] as usize..pair[1] as usize].to_vec()).collect()
}
