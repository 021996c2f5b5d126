//! Joins borders that rounding has moved apart.
//!
//! Files whose coordinates are large beside the garment have cracks along its seams, as have meshes of several primitives that were
//! compressed: each is rounded to a grid of its own.

use std::collections::HashMap;

use super::weld::{Reach, centres};
use super::work::Work;
use crate::base::mesh::{NONE, Part};
use crate::base::stray::{Bounds, diagonal, widen};
use crate::base::vec3::distance;
use crate::base::words;
use crate::record::Severity;

/// Steps of the numbers of a file ([`Part::step`]) by which roundings of one point may differ. Of 800 vertices along the
/// cracks of a garment that several programs had scaled and moved, 760 were within two steps of another, and all within eight.
const STEPS: f64 = 8.0;
/// Largest share of the diagonal of a part that counts as rounding to such steps: numbers of which a step is more hold no shape.
const ROUNDING: f64 = 1e-4;
/// The same for the cells of a grid ([`Part::grid`]): those of 10 bits are less, those of 8 bits more.
const CELL: f64 = 1e-3;

/// How often joined vertices are looked at again once some were left apart.
const ROUNDS: usize = 4;

/// Joins vertices of open borders that differ by no more than the rounding of the numbers in the file. Vertices that an edge connects stay apart. O(n log n).
pub(super) fn join(work: &mut Work) {
    let all = Roundings::of(work);
    if all.most() <= 0.0 {
        return;
    }
    let used: Vec<u32> = work.used().iter().enumerate().filter(|x| *x.1).map(|x| x.0 as u32).collect();
    let reach = Reach::Rounded(all);
    let mut to = centres(&work.mesh.positions, &work.mesh.triangles, &used, &reach);
    if let Reach::Rounded(all) = &reach {
        leave_crowded(work, all, &used, &mut to);
        leave_loose(work, all, &mut to);
    }
    let gone: Vec<u32> = used.into_iter().filter(|v| to[*v as usize] != *v).collect();
    if gone.is_empty() {
        return;
    }
    let gap = |v: &u32| distance(work.mesh.positions[*v as usize], work.mesh.positions[to[*v as usize] as usize]);
    let farthest = gone.iter().map(gap).fold(0.0, f64::max);
    let examples = gone.iter().take(4).map(|v| work.vertex_words(*v)).collect();
    let message = format!(
        "{} on borders joined to others that differ by the rounding of the numbers in the file, at most {farthest:.3e} m",
        words::vertices(gone.len())
    );
    work.rename(|v| to[v as usize]);
    work.report(Severity::Repair, "rounded-borders", gone.len(), examples, message);
}

/// Leaves vertices apart that only grids allow to join, where a third vertex is as near: of sheets that lie as close as their grids are wide, nothing tells which
/// borders belong together. O(n).
fn leave_crowded(work: &Work, all: &Roundings, used: &[u32], to: &mut [u32]) {
    let place = |v: u32| work.mesh.positions[v as usize];
    let width = all.most();
    let cell = |v: u32| place(v).map(|x| (x / width).floor() as i64);
    let moved: Vec<u32> = used.iter().copied().filter(|v| all.by_grid(work, *v, to)).collect();
    if moved.is_empty() {
        return;
    }
    let mut near: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    used.iter().for_each(|v| near.entry(cell(*v)).or_default().push(*v));
    let around = |v: u32| {
        let [x, y, z] = cell(v);
        let cells = (0..27).map(move |k| [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1]);
        cells.filter_map(|cell| near.get(&cell)).flatten().copied()
    };
    let apart: Vec<u32> = {
        let centres = &*to;
        let is_near = |of: u32, v: u32| {
            let centre = centres[v as usize];
            let third = around(of).filter(|w| *w != v && *w != centre && centres[*w as usize] != centre);
            third.into_iter().any(|w| distance(place(of), place(w)) <= all.widest(of, w))
        };
        moved.into_iter().filter(|v| is_near(*v, *v) || is_near(centres[*v as usize], *v)).collect()
    };
    apart.into_iter().for_each(|v| to[v as usize] = v);
}

/// Leaves vertices apart that only grids allow to join, where borders do not close: where no edge meets one of the other primitive, and where two triangles
/// meet in an edge that both run the same way, while most of what meets there of the two primitives does not. A point may have been taken for its neighbour.
fn leave_loose(work: &Work, all: &Roundings, to: &mut [u32]) {
    for _ in 0..ROUNDS {
        let mut joined = vec![false; to.len()];
        (0..to.len()).filter(|v| to[*v] as usize != *v).for_each(|v| joined[to[v] as usize] = true);
        let mut edges: Vec<([u32; 2], Flank)> = Vec::new();
        for (corners, part) in work.mesh.triangles.iter().zip(&work.mesh.triangle_part) {
            let source = all.source.get(*part as usize).copied().unwrap_or(NONE);
            for own in [0, 1, 2].map(|c| [corners[c], corners[(c + 1) % 3]]) {
                let [a, b] = own.map(|v| to[v as usize]);
                if a != b && (joined[a as usize] || joined[b as usize]) {
                    edges.push(([a.min(b), a.max(b)], Flank { forward: a < b, source, own }));
                }
            }
        }
        edges.sort_by_key(|(edge, _)| *edge);
        let pairs: Vec<[&Flank; 2]> = (edges.chunk_by(|x, y| x.0 == y.0))
            .filter_map(|run| if let [(_, x), (_, y)] = run { Some([x, y]) } else { None })
            .filter(|[x, y]| x.source != y.source)
            .collect();
        let is_twisted = |[x, y]: &[&Flank; 2]| x.forward == y.forward;
        let of = |[x, y]: &[&Flank; 2]| [x.source.min(y.source), x.source.max(y.source)];
        let mut counts: HashMap<[u32; 2], [usize; 2]> = HashMap::new();
        for pair in &pairs {
            counts.entry(of(pair)).or_default()[usize::from(is_twisted(pair))] += 1;
        }
        let is_wrong = |pair: &[&Flank; 2]| is_twisted(pair) && counts[&of(pair)][1] < counts[&of(pair)][0];
        let (mut closes, mut wrong) = (vec![false; to.len()], vec![false; to.len()]);
        for pair in &pairs {
            let list = if is_wrong(pair) { &mut wrong } else { &mut closes };
            pair.iter().flat_map(|flank| flank.own).for_each(|v| list[v as usize] = true);
        }
        let leaves = |v: &u32| all.by_grid(work, *v, to) && (wrong[*v as usize] || !closes[*v as usize]);
        let apart: Vec<u32> = (0..to.len() as u32).filter(leaves).collect();
        if apart.is_empty() {
            return;
        }
        apart.into_iter().for_each(|v| to[v as usize] = v);
    }
}

/// A triangle at an edge: which way it runs there, its primitive, and the ends of the edge before they are joined to others.
struct Flank {
    forward: bool,
    source: u32,
    own: [u32; 2],
}

/// How far vertices may be from the points whose roundings they are.
pub(super) struct Roundings {
    /// By the numbers, and by the grid of the part that a vertex belongs to \[m\].
    each: Vec<[f64; 2]>,
    /// Which grid that is; `NONE` of a vertex of several.
    grid: Vec<u32>,
    /// The shortest edge at each vertex \[m\].
    shortest: Vec<f64>,
    /// For each part the first one of the same primitive.
    source: Vec<u32>,
}

impl Roundings {
    /// Those of all vertices: the largest of the parts that they belong to.
    fn of(work: &Work) -> Self {
        let mesh = &work.mesh;
        let mut boxes: Vec<Option<Bounds>> = vec![None; mesh.parts.len()];
        let all = || mesh.triangles.iter().zip(&mesh.triangle_part);
        for (triangle, part) in all() {
            if let Some(around) = boxes.get_mut(*part as usize) {
                triangle.iter().for_each(|v| widen(around, mesh.positions[*v as usize]));
            }
        }
        let of = |(part, around): (&Part, &Option<Bounds>)| {
            let size = around.map_or(0.0, diagonal);
            let grid = if part.grid <= CELL * size { part.grid } else { 0.0 };
            [(STEPS * part.step).min(ROUNDING * size), grid].map(|side| side * 3f64.sqrt() / 2.0)
        };
        let parts: Vec<[f64; 2]> = mesh.parts.iter().zip(&boxes).map(of).collect();
        // Components of a primitive may be parts of their own.
        let mut sources = HashMap::new();
        let mut first = |(n, part): (usize, &Part)| {
            let source = (part.node.clone(), part.mesh.clone(), part.primitive, part.grid.to_bits());
            *sources.entry(source).or_insert(n as u32)
        };
        let grids: Vec<u32> = mesh.parts.iter().enumerate().map(&mut first).collect();
        let mut each = vec![[0.0f64; 2]; mesh.positions.len()];
        let mut grid: Vec<Option<u32>> = vec![None; mesh.positions.len()];
        let mut shortest = vec![f64::INFINITY; mesh.positions.len()];
        for (triangle, part) in all() {
            let [numbers, cells] = parts.get(*part as usize).copied().unwrap_or_default();
            let own = grids.get(*part as usize).copied().unwrap_or(NONE);
            for [a, b] in [0, 1, 2]
                .map(|c| [triangle[c] as usize, triangle[(c + 1) % 3] as usize])
                .into_iter()
                .filter(|[a, b]| a != b)
            {
                let length = distance(mesh.positions[a], mesh.positions[b]);
                [a, b].into_iter().for_each(|v| shortest[v] = shortest[v].min(length));
            }
            for v in triangle.map(|v| v as usize) {
                each[v] = [each[v][0].max(numbers), each[v][1].max(cells)];
                grid[v] = Some(if grid[v].is_none_or(|other| other == own) { own } else { NONE });
            }
        }
        let grid = grid.into_iter().map(|grid| grid.unwrap_or(NONE)).collect();
        Roundings { each, grid, shortest, source: grids }
    }

    /// The farthest that two may be apart.
    pub fn most(&self) -> f64 {
        2.0 * self.each.iter().map(|[numbers, cells]| numbers + cells).fold(0.0, f64::max)
    }

    /// Whether a vertex moves farther than the numbers of the primitives explain.
    fn by_grid(&self, work: &Work, v: u32, to: &[u32]) -> bool {
        let [from, into] = [v, to[v as usize]].map(|v| work.mesh.positions[v as usize]);
        to[v as usize] != v && distance(from, into) > self.numbers(v, to[v as usize])
    }

    /// How far roundings of two points may be from one another that no grid tells apart.
    fn widest(&self, a: u32, b: u32) -> f64 {
        self.numbers(a, b) + self.each[a as usize][1] + self.each[b as usize][1]
    }

    /// How far these two may be apart by the numbers of their primitives.
    fn numbers(&self, a: u32, b: u32) -> f64 {
        self.each[a as usize][0] + self.each[b as usize][0]
    }

    /// How far these two may be apart. On one grid a point has one rounding, and beside shorter edges a grid tells no points apart.
    pub fn reach(&self, a: u32, b: u32) -> f64 {
        let (a, b) = (a as usize, b as usize);
        let cells = self.each[a][1] + self.each[b][1];
        let numbers = self.each[a][0] + self.each[b][0];
        let is_one = self.grid[a] == self.grid[b] && self.grid[a] != NONE;
        if is_one || self.shortest[a].min(self.shortest[b]) <= numbers + cells { numbers } else { numbers + cells }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::mesh::Mesh;

    #[test]
    fn borders_that_rounding_moved_apart_are_joined_and_others_stay() {
        // Two squares side by side, of numbers near 120, and a third one farther off than rounding.
        let square = |x: f64, y: f64| [[x, y, 0.0], [x + 0.5, y, 0.0], [x, y + 0.5, 0.0], [x + 0.5, y + 0.5, 0.0]];
        let positions: Vec<[f64; 3]> = [square(120.0, 0.0), square(120.500_008, 3e-5), square(120.0, 0.501)].concat();
        let triangles = [0, 4, 8].map(|k| [[k, k + 1, k + 3], [k, k + 3, k + 2]]).concat();
        let mesh = |step| {
            let parts = vec![Part { step, ..Part::default() }];
            let mut work = Work::new(Mesh {
                positions: positions.clone(),
                triangles: triangles.clone(),
                parts,
                ..Default::default()
            });
            join(&mut work);
            work
        };
        let joined = mesh(f64::from(120f32.next_up()) - 120.0);
        assert_eq!(joined.mesh.triangles[2..], [[1, 5, 7], [1, 7, 3], [8, 9, 11], [8, 11, 10]]);
        assert_eq!((joined.findings[0].kind, joined.findings[0].count), ("rounded-borders", 2));
        // Text may have any number of digits, and steps larger than a part say nothing.
        assert!(mesh(0.0).findings.is_empty() && mesh(0.0).mesh.triangles == triangles);
        assert_eq!(mesh(100.0).findings[0].count, 2);
    }

    #[test]
    fn an_edge_shorter_than_rounding_stays() {
        let positions = vec![[100.0, 0.0, 0.0], [100.000_001, 0.0, 0.0], [100.0, 1.0, 0.0]];
        let parts = vec![Part { step: 8e-6, ..Part::default() }];
        let mut w = Work::new(Mesh { positions, triangles: vec![[0, 1, 2]], parts, ..Default::default() });
        join(&mut w);
        assert!(w.findings.is_empty() && w.mesh.triangles == [[0, 1, 2]]);
    }

    /// Two sheets of one primitive, one `over` the other, and a sheet of another primitive beside the upper one, up to `apart` farther up.
    fn on_grids(grid: f64, over: f64, apart: f64) -> Work {
        let sheet = |x: f64, z: f64| [[x, 0.0, z], [x + 1.0, 0.0, z], [x, 1.0, z], [x + 1.0, 1.0, z]];
        let positions = [sheet(0.0, 0.0), sheet(0.0, over), sheet(1.0, over + apart)].concat();
        let triangles = [0, 4, 8].map(|k| [[k, k + 1, k + 3], [k, k + 3, k + 2]]).concat();
        let parts = [0, 1].map(|primitive| Part { primitive, grid, ..Part::default() }).to_vec();
        let mut work = Work::new(Mesh {
            positions,
            triangles,
            parts,
            triangle_part: vec![0, 0, 0, 0, 1, 1],
            ..Default::default()
        });
        join(&mut work);
        work
    }

    #[test]
    fn borders_of_primitives_on_other_grids_are_joined_and_those_on_one_grid_stay() {
        let work = on_grids(5e-4, 3e-3, 4e-4);
        assert_eq!(work.mesh.triangles[2..], [[4, 5, 7], [4, 7, 6], [5, 9, 11], [5, 11, 7]]);
        assert_eq!((work.findings[0].kind, work.findings[0].count), ("rounded-borders", 2));
        // Sheets closer than the cells, of which either could go on.
        assert!(on_grids(5e-4, 6e-4, 4e-4).findings.is_empty());
        // Cells as wide as of 8 bits hold no shape.
        assert!(on_grids(4e-3, 1e-2, 1e-3).findings.is_empty() && on_grids(0.0, 3e-3, 4e-4).findings.is_empty());
    }

    #[test]
    fn points_where_no_edge_closes_or_edges_are_short_stay_apart() {
        // Two triangles that touch in a point, and two along an edge as short as a cell.
        let corner =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0003, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, -1.0, 0.0]];
        let short = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 0.0006, 0.0],
            [1.0003, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [1.0003, 0.0006, 0.0],
        ];
        for positions in [corner, short] {
            let parts = [0, 1].map(|primitive| Part { primitive, grid: 5e-4, ..Part::default() }).to_vec();
            let triangles = vec![[0, 1, 2], [3, 4, 5]];
            let mesh = Mesh {
                positions: positions.to_vec(),
                triangles,
                parts,
                triangle_part: vec![0, 1],
                ..Default::default()
            };
            let mut work = Work::new(mesh);
            join(&mut work);
            assert!(work.findings.is_empty(), "{:?}", work.findings);
        }
    }
}
