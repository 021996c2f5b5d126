//! Joins vertices at the same place.
//!
//! Equal positions are joined always: files store a vertex once for each normal or texture coordinate, and attributes
//! live on corners here, so nothing is lost. Borders whose vertices differ by no more than rounding are joined too (`rounding.rs`). A weld within a
//! larger distance changes the shape and, in thin double sheets, the topology: it is done on request only.

use std::cmp::Ordering;
use std::collections::HashMap;

use gimage_bundle::DisjointSets;

use super::rounding::Roundings;
use super::work::Work;
use crate::base::vec3::distance;
use crate::base::words;
use crate::record::Severity;

/// Joins vertices at equal positions (-0 equals 0); the smallest index stays. O(n).
pub(super) fn exact(work: &mut Work) {
    let used = work.used();
    let mut first: HashMap<[u64; 3], u32> = HashMap::with_capacity(used.len());
    let mut to: Vec<u32> = (0..used.len() as u32).collect();
    let (mut gone, mut examples) = (0, Vec::new());
    for v in (0..used.len()).filter(|&v| used[v]) {
        // Adding 0 turns -0 into 0.
        let key = work.mesh.positions[v].map(|x| (x + 0.0).to_bits());
        to[v] = *first.entry(key).or_insert(v as u32);
        if to[v] != v as u32 {
            gone += 1;
            if examples.len() < 4 {
                examples.push(work.vertex_words(v as u32));
            }
        }
    }
    if gone > 0 {
        work.rename(|v| to[v as usize]);
    }
    let message = format!("{} joined to others at exactly the same position", words::vertices(gone));
    work.report(Severity::Note, "welded-vertices", gone, examples, message);
}

/// Joins vertices within `d` \[m\] of each other; no vertex moves farther than `d`.
///
/// Two vertices are joined where both lie on open borders, or where an edge connects them: cracks close and short edges
/// collapse, but two layers of cloth that lie closer than `d` are not fused.
///
/// Vertices are taken in the order of x, then y, then z. A vertex that no centre found so far can take becomes a centre;
/// afterwards each other vertex moves to the nearest centre that can take it. Two vertices within `d` of each other stay
/// apart where they have different centres, which chains of close vertices need: joining along a chain moves its ends
/// without a bound. The result does not depend on the order of vertices in the file. O(n log n).
pub(super) fn within(work: &mut Work, d: f64) {
    let before = components(work);
    let collapsed_before = collapsed(work);
    let used: Vec<u32> = work.used().iter().enumerate().filter(|x| *x.1).map(|x| x.0 as u32).collect();
    let to = centres(&work.mesh.positions, &work.mesh.triangles, &used, &Reach::All(d));

    let position = |v: u32| work.mesh.positions[v as usize];
    let (mut moved, mut farthest, mut example) = (0, 0.0f64, Vec::new());
    let mut joined = vec![false; to.len()];
    for &v in used.iter().filter(|&&v| to[v as usize] != v) {
        moved += 1;
        farthest = farthest.max(distance(position(v), position(to[v as usize])));
        joined[to[v as usize] as usize] = true;
        if example.len() < 4 {
            example.push(work.vertex_words(v));
        }
    }
    if moved == 0 {
        return;
    }
    let clusters = joined.iter().filter(|&&j| j).count();
    work.rename(|v| to[v as usize]);
    let message = format!(
        "{} within {d} m of another on a border or an edge joined into {clusters}, largest move {farthest:.3e} m; {} \
         collapsed, {before} connected components became {}",
        words::vertices(moved),
        words::triangles(collapsed(work) - collapsed_before),
        components(work)
    );
    work.report(Severity::Repair, "tolerance-weld", moved, example, message);
}

/// Which vertices a weld may join.
pub(super) enum Reach {
    /// All on borders or beside each other within a distance \[m\].
    All(f64),
    /// Those on borders that are not beside each other and may be roundings of one point.
    Rounded(Roundings),
}

impl Reach {
    fn most(&self) -> f64 {
        match self {
            Reach::All(d) => *d,
            Reach::Rounded(all) => all.most(),
        }
    }

    fn of(&self, a: u32, b: u32) -> f64 {
        match self {
            Reach::All(d) => *d,
            Reach::Rounded(all) => all.reach(a, b),
        }
    }
}

/// Triangles that name a vertex twice.
fn collapsed(work: &Work) -> usize {
    work.mesh.triangles.iter().filter(|[a, b, c]| a == b || b == c || c == a).count()
}

/// Number of sets of triangles connected through vertices.
fn components(work: &Work) -> usize {
    let mut sets = DisjointSets::new(work.mesh.positions.len());
    for &[a, b, c] in &work.mesh.triangles {
        sets.union(a, b);
        sets.union(b, c);
    }
    let used = work.used();
    (0..used.len() as u32).filter(|&v| used[v as usize] && sets.find(v) == v).count()
}

/// Surroundings of the vertices of a mesh, for a weld.
struct Surroundings {
    /// Vertices that an edge connects to each vertex, at `first[v]..first[v + 1]`.
    first: Vec<u32>,
    beside: Vec<u32>,
    /// Vertices of edges that do not have two triangles.
    border: Vec<bool>,
}

impl Surroundings {
    fn of(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let mut edges: Vec<[u32; 2]> = sides.filter(|[a, b]| a != b).map(|[a, b]| [a.min(b), a.max(b)]).collect();
        edges.sort_unstable();
        let mut border = vec![false; vertices];
        for run in edges.chunk_by(|x, y| x == y).filter(|run| run.len() != 2) {
            run[0].iter().for_each(|&v| border[v as usize] = true);
        }
        edges.dedup();
        let mut first = vec![0u32; vertices + 1];
        edges.iter().flatten().for_each(|&v| first[v as usize + 1] += 1);
        (0..vertices).for_each(|v| first[v + 1] += first[v]);
        let mut next = first.clone();
        let mut beside = vec![0; 2 * edges.len()];
        for [a, b] in edges {
            for (from, to) in [(a, b), (b, a)] {
                beside[next[from as usize] as usize] = to;
                next[from as usize] += 1;
            }
        }
        Self { first, beside, border }
    }

    fn beside(&self, v: u32) -> &[u32] {
        &self.beside[self.first[v as usize] as usize..self.first[v as usize + 1] as usize]
    }
}

/// For each vertex the centre that it moves to: itself for a centre and for a vertex that is not used.
///
/// A grid of cells `d` wide holds the centres on borders. As these are more than `d` apart, a cell holds few, and a query
/// looks at 27 cells.
pub(super) fn centres(positions: &[[f64; 3]], triangles: &[[u32; 3]], used: &[u32], reach: &Reach) -> Vec<u32> {
    let d = reach.most();
    let mut to: Vec<u32> = (0..positions.len() as u32).collect();
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for &v in used {
        for k in 0..3 {
            low[k] = low[k].min(positions[v as usize][k]);
            high[k] = high[k].max(positions[v as usize][k]);
        }
    }
    // Below the resolution of the numbers there is nothing to join that the exact weld has not.
    if !(0..3).all(|k| (high[k] - low[k]) / d < 2f64.powi(50)) {
        return to;
    }
    let mesh = Surroundings::of(positions.len(), triangles);
    let cell = |p: [f64; 3]| [0, 1, 2].map(|k| ((p[k] - low[k]) / d).floor() as i64);
    let mut grid: HashMap<[i64; 3], Vec<u32>> = HashMap::with_capacity(used.len());
    let mut is_centre = vec![false; positions.len()];
    // Nearest first; equally near centres by position, so that the order of the file does not decide.
    let nearest = |grid: &HashMap<[i64; 3], Vec<u32>>, is_centre: &[bool], v: u32| -> Option<u32> {
        let p = positions[v as usize];
        let mut best: Option<(f64, u32)> = None;
        let mut offer = |c: u32| {
            let q = positions[c as usize];
            let gap = distance(p, q);
            let closer =
                |(g, b): (f64, u32)| gap.total_cmp(&g).then(in_order(q, positions[b as usize])).then(c.cmp(&b)).is_lt();
            if gap <= reach.of(v, c) && best.is_none_or(closer) {
                best = Some((gap, c));
            }
        };
        let edges = matches!(reach, Reach::All(_));
        mesh.beside(v).iter().filter(|&&c| edges && is_centre[c as usize]).for_each(|&c| offer(c));
        if mesh.border[v as usize] {
            let at = cell(p);
            for k in 0..27 {
                let near = [at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1];
                let here = grid.get(&near).into_iter().flatten();
                here.filter(|&&c| edges || !mesh.beside(v).contains(&c)).for_each(|&c| offer(c));
            }
        }
        best.map(|b| b.1)
    };
    let mut sorted = used.to_vec();
    sorted.sort_unstable_by(|&a, &b| in_order(positions[a as usize], positions[b as usize]).then(a.cmp(&b)));
    for &v in &sorted {
        if nearest(&grid, &is_centre, v).is_none() {
            is_centre[v as usize] = true;
            if mesh.border[v as usize] {
                grid.entry(cell(positions[v as usize])).or_default().push(v);
            }
        }
    }
    for &v in used.iter().filter(|&&v| !is_centre[v as usize]) {
        to[v as usize] = nearest(&grid, &is_centre, v).unwrap_or(v);
    }
    to
}

/// By x, then y, then z.
fn in_order(a: [f64; 3], b: [f64; 3]) -> Ordering {
    (0..3).fold(Ordering::Equal, |order, k| order.then(a[k].total_cmp(&b[k])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::mesh::Mesh;

    fn soup(positions: Vec<[f64; 3]>) -> Work {
        let triangles = (0..positions.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        Work::new(Mesh { positions, triangles, ..Default::default() })
    }

    #[test]
    fn minus_zero_is_zero() {
        let mut w = soup(vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., -0., 0.], [-0., 0., -0.], [0.5, -1., 0.]]);
        exact(&mut w);
        assert_eq!(w.mesh.triangles, [[0, 1, 2], [1, 0, 5]]);
        assert_eq!((w.findings[0].count, w.findings[0].severity), (2, Severity::Note));
    }

    #[test]
    fn a_chain_moves_no_vertex_beyond_the_tolerance() {
        let chain: Vec<[f64; 3]> = (0..30).map(|k| [0.1 * f64::from(k), 0.0, 0.0]).collect();
        let mut w = soup(chain.clone());
        within(&mut w, 0.11);
        let moves = chain.iter().zip(w.mesh.triangles.iter().flatten()).map(|(&p, &v)| distance(p, chain[v as usize]));
        let farthest = moves.fold(0.0, f64::max);
        assert!(farthest > 0.0 && farthest <= 0.11, "{farthest}");
        let message = &w.findings[0].message;
        assert!(message.starts_with("15 vertices") && message.contains("largest move 1.000e-1 m"), "{message}");
        assert_eq!(w.findings[0].count, 15);
    }

    #[test]
    fn a_crack_narrower_than_the_tolerance_closes() {
        let mut w = soup(vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 0.01, 0.], [1., 1.01, 0.], [0., 1., 0.]]);
        within(&mut w, 0.02);
        assert_eq!(w.mesh.triangles, [[0, 1, 2], [0, 2, 5]]);
        assert!(w.findings[0].message.contains("0 triangles collapsed, 2 connected components became 1"));
    }

    fn cloud(n: usize) -> Vec<[f64; 3]> {
        let mut s = 7u64;
        let mut random = || {
            s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (s >> 33) as f64 / (1u64 << 31) as f64
        };
        (0..n).map(|_| [random(), random(), random()]).collect()
    }

    /// Loose triangles: every vertex is on a border.
    fn loose(n: u32) -> (Vec<[u32; 3]>, Vec<u32>) {
        ((0..n / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(), (0..n).collect())
    }

    #[test]
    fn clusters_agree_with_brute_force_and_leave_centres_apart() {
        let p = cloud(402);
        let (triangles, all) = loose(402);
        for d in [0.03, 0.09, 0.4, 2.0] {
            let to = centres(&p, &triangles, &all, &Reach::All(d));
            let centre = |v: usize| to[v] as usize == v;
            for v in 0..402 {
                assert!(centre(to[v] as usize));
                let gap = |c: usize| distance(p[v], p[c]);
                let least = (0..402).filter(|&c| centre(c)).map(gap).fold(f64::INFINITY, f64::min);
                assert!(gap(to[v] as usize) == least && least <= d);
                assert!((0..v).all(|c| !centre(v) || !centre(c) || gap(c) > d));
            }
        }
    }

    #[test]
    fn clusters_do_not_depend_on_the_order_of_vertices() {
        let p = cloud(300);
        let turned: Vec<[f64; 3]> = p.iter().rev().copied().collect();
        let (triangles, all) = loose(300);
        let (a, b) =
            (centres(&p, &triangles, &all, &Reach::All(0.1)), centres(&turned, &triangles, &all, &Reach::All(0.1)));
        assert!((0..300).all(|v| p[a[v] as usize] == turned[b[299 - v] as usize]));
        assert!((0..300).any(|v| a[v] as usize != v));
    }

    #[test]
    fn two_layers_closer_than_the_tolerance_are_not_fused() {
        // A pillow: two sheets 0.01 apart, joined all round, whose cells are 1 wide.
        let sheet = |z: f64| move |k: u32| [f64::from(k % 5), f64::from(k / 5), z];
        let positions: Vec<[f64; 3]> = (0..25).map(sheet(0.0)).chain((0..25).map(sheet(0.01))).collect();
        let rim = |k: u32| k.is_multiple_of(5) || k % 5 == 4 || k / 5 == 0 || k / 5 == 4;
        let upper = |k: u32| if rim(k) { k } else { k + 25 };
        let mut triangles = Vec::new();
        for k in (0..20).filter(|k| k % 5 != 4) {
            for t in [[k, k + 1, k + 6], [k, k + 6, k + 5]] {
                triangles.push(t);
                let [a, b, c] = t.map(upper);
                triangles.push([a, c, b]);
            }
        }
        let mut w = Work::new(Mesh { positions, triangles: triangles.clone(), ..Default::default() });
        within(&mut w, 0.05);
        assert!(w.mesh.triangles == triangles && w.findings.is_empty());
        // Edges shorter than the tolerance collapse all the same.
        w.mesh.positions[12] = [2.02, 1.0, 0.0];
        within(&mut w, 0.05);
        assert!(w.findings[0].message.starts_with("1 vertex "), "{}", w.findings[0].message);
        assert!(w.findings[0].message.contains("2 triangles collapsed"), "{}", w.findings[0].message);
    }
}
