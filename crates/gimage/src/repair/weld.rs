//! Joins vertices at the same place.
//!
//! Equal positions are joined always: files store a vertex once for each normal or texture coordinate, and attributes
//! live on corners here, so nothing is lost. A weld within a distance changes the shape and, in thin double sheets, the
//! topology: it is done on request only.

use std::collections::HashMap;

use super::union_find::UnionFind;
use super::work::Work;
use crate::record::Severity;
use crate::vec3::distance;

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
    let message = format!("{gone} vertices joined to others at exactly the same position");
    work.report(Severity::Note, "welded-vertices", gone, examples, message);
}

/// Joins vertices that chains of steps no longer than `d` \[m\] connect; each cluster goes to the position that is
/// smallest in x, then y, then z. The clusters do not depend on the order of vertices. O(n) for vertices spread out.
pub(super) fn within(work: &mut Work, d: f64) {
    let before = components(work);
    let collapsed_before = collapsed(work);
    let used: Vec<u32> = work.used().iter().enumerate().filter(|x| *x.1).map(|x| x.0 as u32).collect();
    let mut sets = clusters(&work.mesh.positions, &used, d);

    let position = |v: u32| work.mesh.positions[v as usize];
    let mut best: HashMap<u32, u32> = HashMap::with_capacity(used.len());
    for &v in &used {
        let b = best.entry(sets.find(v)).or_insert(v);
        if position(v).partial_cmp(&position(*b)) == Some(std::cmp::Ordering::Less) {
            *b = v;
        }
    }
    let (mut moved, mut farthest, mut example, mut sizes) = (0, 0.0f64, Vec::new(), HashMap::new());
    for &v in &used {
        let root = sets.find(v);
        *sizes.entry(root).or_insert(0) += 1;
        if best[&root] != v {
            moved += 1;
            farthest = farthest.max(distance(position(v), position(best[&root])));
            if example.len() < 4 {
                example.push(work.vertex_words(v));
            }
        }
    }
    if moved == 0 {
        return;
    }
    let joined = sizes.values().filter(|&&s| s > 1).count();
    work.rename(|v| best[&sets.find(v)]);
    let message = format!(
        "vertices within {d} m joined: {joined} clusters, {moved} vertices moved by up to {farthest:.3e} m, {} triangles \
         collapsed, {before} connected components became {}",
        collapsed(work) - collapsed_before,
        components(work)
    );
    work.report(Severity::Repair, "tolerance-weld", joined, example, message);
}

/// Triangles that name a vertex twice.
fn collapsed(work: &Work) -> usize {
    work.mesh.triangles.iter().filter(|[a, b, c]| a == b || b == c || c == a).count()
}

/// Number of sets of triangles connected through vertices.
fn components(work: &Work) -> usize {
    let mut sets = UnionFind::new(work.mesh.positions.len());
    for &[a, b, c] in &work.mesh.triangles {
        sets.union(a, b);
        sets.union(b, c);
    }
    let used = work.used();
    (0..used.len() as u32).filter(|&v| used[v as usize] && sets.find(v) == v).count()
}

/// Single linkage over a grid whose cells have the diagonal `d`: what shares a cell is one cluster, and only pairs of
/// cells up to two apart need a look.
fn clusters(positions: &[[f64; 3]], used: &[u32], d: f64) -> UnionFind {
    let mut sets = UnionFind::new(positions.len());
    let cell = d / 3f64.sqrt() * (1.0 - 1e-12);
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for &v in used {
        for k in 0..3 {
            low[k] = low[k].min(positions[v as usize][k]);
            high[k] = high[k].max(positions[v as usize][k]);
        }
    }
    // Below the resolution of the numbers there is nothing to join that the exact weld has not.
    if !(0..3).all(|k| (high[k] - low[k]) / cell < 2f64.powi(50)) {
        return sets;
    }
    let key =
        |v: u32| std::array::from_fn::<i64, 3, _>(|k| ((positions[v as usize][k] - low[k]) / cell).floor() as i64);
    let mut grid: HashMap<[i64; 3], Vec<u32>> = HashMap::with_capacity(used.len());
    for &v in used {
        let members = grid.entry(key(v)).or_default();
        if let Some(&first) = members.first() {
            sets.union(first, v);
        }
        members.push(v);
    }
    let mut offsets = Vec::new();
    for x in -2..=2i64 {
        for y in -2..=2i64 {
            for z in -2..=2i64 {
                if [x, y, z] > [0, 0, 0] {
                    offsets.push([x, y, z]);
                }
            }
        }
    }
    // The order of cells is of no consequence: clusters are the connected sets, whichever pair joins them.
    for (at, members) in &grid {
        for o in &offsets {
            let Some(others) = grid.get(&[at[0] + o[0], at[1] + o[1], at[2] + o[2]]) else { continue };
            if sets.find(members[0]) == sets.find(others[0]) {
                continue;
            }
            let near = |&a: &u32| others.iter().any(|&b| distance(positions[a as usize], positions[b as usize]) <= d);
            if members.iter().any(near) {
                sets.union(members[0], others[0]);
            }
        }
    }
    sets
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

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
    fn a_chain_becomes_one_vertex_at_its_smallest_position() {
        let mut w = soup(vec![[0.2, 0., 0.], [0.1, 0., 0.], [0., 0., 0.], [5., 0., 0.], [5., 1., 0.], [6., 0., 0.]]);
        within(&mut w, 0.11);
        assert_eq!(w.mesh.triangles, [[2, 2, 2], [3, 4, 5]]);
        assert_eq!(w.findings[0].count, 1);
        assert!(w.findings[0].message.contains("1 triangles collapsed"), "{}", w.findings[0].message);
    }

    #[test]
    fn pairs_across_cells_agree_with_brute_force() {
        let mut s = 7u64;
        let mut random = || {
            s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (s >> 33) as f64 / (1u64 << 31) as f64
        };
        let p: Vec<[f64; 3]> = (0..300).map(|_| [random(), random(), random()]).collect();
        let all: Vec<u32> = (0..300).collect();
        let mut fast = clusters(&p, &all, 0.09);
        let mut slow = UnionFind::new(300);
        for a in 0..300 {
            for b in 0..a {
                if distance(p[a], p[b]) <= 0.09 {
                    slow.union(a as u32, b as u32);
                }
            }
        }
        assert!((0..300).all(|v| fast.find(v) == slow.find(v)));
    }
}
