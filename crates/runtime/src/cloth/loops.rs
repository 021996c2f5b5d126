//! The boundary loops of a cloth: open borders such as a hem or a neckline.

use gimage_bundle::DisjointSets;

use super::Cloth;

impl Cloth {
    /// The particles of each boundary loop at the start, in ascending order, seam duplicates included; the longest loop
    /// \[m\] first, as `gimage build --pin loop:K` numbers them. Borders that meet at a particle are one loop. A closed
    /// surface has none. Time n log n in the texels.
    pub fn loops(&self) -> Vec<Vec<u32>> {
        let points = self.points();
        let border = self.border(&points);
        let (mut joined, mut on_border) = (DisjointSets::new(self.len()), vec![false; self.len()]);
        for &[a, b] in &border {
            joined.union(a, b);
            (on_border[a as usize], on_border[b as usize]) = (true, true);
        }
        let mut lengths = vec![0.0; self.len()];
        let at = |k: u32| self.positions()[k as usize].map(f64::from);
        for &[a, b] in &border {
            let (p, q) = (at(a), at(b));
            lengths[joined.find(a) as usize] += (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f64>().sqrt();
        }
        let mut loops: Vec<(f64, u32, Vec<u32>)> = Vec::new();
        let mut place = vec![usize::MAX; self.len()];
        for k in (0..self.len() as u32).filter(|k| on_border[points[*k as usize] as usize]) {
            let root = joined.find(points[k as usize]);
            if place[root as usize] == usize::MAX {
                place[root as usize] = loops.len();
                loops.push((lengths[root as usize], root, Vec::new()));
            }
            loops[place[root as usize]].2.push(k);
        }
        loops.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        loops.into_iter().map(|l| l.2).collect()
    }

    /// Edges with one triangle of the surface in which each point of a seam is one vertex.
    fn border(&self, points: &[u32]) -> Vec<[u32; 2]> {
        let mut edges: Vec<[u32; 2]> = Vec::new();
        for grid in self.grids() {
            let there = |k: &u32| self.particles()[*k as usize].exists();
            for (j, i) in (1..grid.height).flat_map(|j| (1..grid.width).map(move |i| (j, i))) {
                let last = grid.first + j * grid.width + i;
                let quad = [last - grid.width - 1, last - grid.width, last, last - 1];
                let corners: Vec<u32> = quad.into_iter().filter(there).map(|k| points[k as usize]).collect();
                let triangles = match corners[..] {
                    [p, q, r, s] => vec![[p, q, r], [p, r, s]],
                    [a, b, c] => vec![[a, b, c]],
                    _ => continue,
                };
                for [a, b, c] in triangles.into_iter().filter(|[a, b, c]| a != b && b != c && c != a) {
                    edges.extend([[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]));
                }
            }
        }
        edges.sort_unstable();
        edges.chunk_by(|a, b| a == b).filter(|run| run.len() == 1).map(|run| run[0]).collect()
    }
}
