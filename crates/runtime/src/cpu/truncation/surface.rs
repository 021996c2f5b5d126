//! The drawn surface of the cloths whose contact is safe: points, and the vertices, edges and triangles of each cell.

use std::collections::HashSet;

use crate::cloth::Cloth;
use crate::memory::Tally;

/// A cloth of the surface.
pub struct Source<'a> {
    /// Its index among the cloths of the scene.
    pub index: usize,
    pub cloth: &'a Cloth,
    /// Triangles that are cut away, by texel; empty for cloth that is whole.
    pub holes: &'a [u32],
}

/// A particle of a point; the duplicates of a seam are one point.
#[derive(Clone, Copy, Debug)]
pub struct Texel {
    /// Index of the cloth among the cloths of the scene.
    pub cloth: u32,
    /// The particle.
    pub particle: u32,
}

/// The cells of one grid: one per texel, the quad right and below of it.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Its number among all.
    pub index: usize,
    /// The first cell.
    pub first: usize,
    pub width: usize,
    pub height: usize,
}

impl Patch {
    /// The column and the row of one of its cells.
    pub fn spot(&self, cell: usize) -> [usize; 2] {
        [(cell - self.first) % self.width, (cell - self.first) / self.width]
    }
}

/// The features of a cell: ranges of the lists of a [`Surface`].
#[derive(Clone, Copy, Debug, Default)]
struct Ends {
    vertex: u32,
    edge: u32,
    triangle: u32,
}

/// Points, and features by cells. Each feature belongs to one cell, whose quad has all its corners.
#[derive(Default)]
pub struct Surface {
    /// Particles of all points, one point after the other.
    pub texels: Vec<Texel>,
    /// The first of each point, and one past the last.
    pub starts: Vec<u32>,
    pub patches: Vec<Patch>,
    /// The point of each cell's texel, `u32::MAX` for none.
    pub corners: Vec<u32>,
    /// For each point the cells that have a corner there.
    pub cells: Vec<u32>,
    pub cell_starts: Vec<u32>,
    ends: Vec<Ends>,
    vertices: Vec<u32>,
    edges: Vec<[u32; 2]>,
    triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Follows the cloths as another one, which is not among them, leaves the scene: indices behind it fall by one.
    pub fn leave(&mut self, gone: usize) {
        self.texels.iter_mut().for_each(|texel| texel.cloth -= u32::from(texel.cloth as usize > gone));
    }

    /// That of some cloths. Takes time linear in their particles.
    pub fn new(sources: &[Source]) -> Self {
        let mut surface = Surface { starts: vec![0], ends: vec![Ends::default()], ..Surface::default() };
        for source in sources {
            surface.add(source);
        }
        surface.find_cells();
        surface
    }

    /// Counts its lists.
    pub fn tally(&self, tally: &mut Tally) {
        tally.state(&self.texels);
        let lists = [&self.starts, &self.corners, &self.vertices, &self.cells, &self.cell_starts];
        lists.into_iter().for_each(|list| tally.state(list));
        tally.state(&self.ends);
        tally.state(&self.edges);
        tally.state(&self.triangles);
    }

    /// Number of points.
    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// The particles of a point.
    pub fn of_point(&self, point: usize) -> &[Texel] {
        &self.texels[self.starts[point] as usize..self.starts[point + 1] as usize]
    }

    /// The patch that a cell belongs to.
    pub fn patch_of(&self, cell: usize) -> Patch {
        self.patches[self.patches.partition_point(|patch| patch.first <= cell) - 1]
    }

    /// The cells around a point: they have all features that the point belongs to.
    pub fn cells_of(&self, point: usize) -> &[u32] {
        &self.cells[self.cell_starts[point] as usize..self.cell_starts[point + 1] as usize]
    }

    pub fn vertices(&self, cell: usize) -> &[u32] {
        &self.vertices[self.ends[cell].vertex as usize..self.ends[cell + 1].vertex as usize]
    }

    pub fn edges(&self, cell: usize) -> &[[u32; 2]] {
        &self.edges[self.ends[cell].edge as usize..self.ends[cell + 1].edge as usize]
    }

    pub fn triangles(&self, cell: usize) -> &[[u32; 3]] {
        &self.triangles[self.ends[cell].triangle as usize..self.ends[cell + 1].triangle as usize]
    }

    fn add(&mut self, source: &Source) {
        let Source { index, cloth, holes } = *source;
        let points = self.add_points(index, cloth);
        let indices = cloth.all_indices(holes);
        let (mut known, mut drawn) = (HashSet::new(), HashSet::new());
        for grid in cloth.grids() {
            let (first, width, height) = (self.corners.len(), grid.width as usize, grid.height as usize);
            self.patches.push(Patch { index: self.patches.len(), first, width, height });
            for k in grid.range() {
                self.corners.push(points[k]);
                for triangle in indices[6 * k..6 * k + 6].chunks_exact(3) {
                    let [a, b, c] = [0, 1, 2].map(|n| points[triangle[n] as usize]);
                    // A triangle with two corners at one point has no area; its edges are those of neighbours.
                    if a == b || b == c || a == c || a == u32::MAX {
                        continue;
                    }
                    self.triangles.push([a, b, c]);
                    let edges = [[a, b], [b, c], [a, c]].map(|[p, q]| [p.min(q), p.max(q)]);
                    self.edges.extend(edges.into_iter().filter(|edge| known.insert(*edge)));
                    self.vertices.extend([a, b, c].into_iter().filter(|point| drawn.insert(*point)));
                }
                let [vertex, edge, triangle] =
                    [self.vertices.len(), self.edges.len(), self.triangles.len()].map(|n| n as u32);
                self.ends.push(Ends { vertex, edge, triangle });
            }
        }
    }

    fn find_cells(&mut self) {
        let mut pairs = Vec::with_capacity(4 * self.corners.len());
        for patch in &self.patches {
            for (j, i) in (1..patch.height).flat_map(|j| (1..patch.width).map(move |i| (j - 1, i - 1))) {
                let cell = patch.first + j * patch.width + i;
                let corners = [cell, cell + 1, cell + patch.width, cell + patch.width + 1].map(|n| self.corners[n]);
                pairs.extend(corners.iter().filter(|point| **point != u32::MAX).map(|point| [*point, cell as u32]));
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        self.cell_starts = vec![0; self.count() + 1];
        pairs.iter().for_each(|[point, _]| self.cell_starts[*point as usize + 1] += 1);
        (1..self.cell_starts.len()).for_each(|n| self.cell_starts[n] += self.cell_starts[n - 1]);
        self.cells = pairs.into_iter().map(|[_, cell]| cell).collect();
    }

    /// Adds the points of a cloth; returns that of each particle, `u32::MAX` for none.
    fn add_points(&mut self, index: usize, cloth: &Cloth) -> Vec<u32> {
        let firsts = cloth.points();
        let mut points = vec![u32::MAX; cloth.len()];
        let mut members: Vec<[u32; 2]> = (0..cloth.len() as u32)
            .filter(|k| cloth.particles()[*k as usize].exists())
            .map(|k| [firsts[k as usize], k])
            .collect();
        members.sort_unstable();
        for same in members.chunk_by(|a, b| a[0] == b[0]) {
            let point = self.count() as u32;
            for [_, particle] in same {
                points[*particle as usize] = point;
                self.texels.push(Texel { cloth: index as u32, particle: *particle });
            }
            self.starts.push(self.texels.len() as u32);
        }
        points
    }
}
