//! The paths that parts share, and how many texel steps each of them has.
//!
//! A part's disk is bounded by stretches of the surface's own boundary, by its own cut, and by paths that it shares with
//! other parts. Both sides of a shared path must be sampled at the same points, so its ends are nodes in both disks, and its
//! number of steps is decided here, before either disk is laid out.

use std::collections::BTreeMap;

use gimage_bundle::DisjointSets;

use super::part::Part;
use crate::base::graph::EdgeGraph;
use crate::stage::border::Border;
use crate::stage::cut::CutRecord;
use crate::stage::cut::disk::Disk;

/// A part cut open to a disk.
#[derive(Clone, Debug)]
pub(super) struct Opened {
    pub part: Part,
    pub disk: Disk,
    pub cut: CutRecord,
}

impl Opened {
    /// The vertex of the whole that a vertex of the disk is.
    pub(super) fn global(&self, v: u32) -> u32 {
        self.part.vertex[self.disk.origin[v as usize] as usize]
    }
}

/// A disk with its border, of which shared paths have fixed counts.
pub(super) struct Bordered {
    pub opened: Opened,
    pub border: Border,
    /// For each group of the border the shared path that it is, and whether it runs against it.
    pub shared: BTreeMap<usize, (u32, bool)>,
    /// Texels that are the part's share of the budget.
    pub texels: f64,
}

impl Bordered {
    /// Border steps of an image of the part's share.
    pub(super) fn perimeter(&self) -> u32 {
        perimeter(self.texels)
    }

    /// The fewest border steps over what an image of the part's share has.
    pub(super) fn crowding(&self) -> f64 {
        f64::from(self.border.least_steps()) / f64::from(self.perimeter())
    }
}

fn perimeter(texels: f64) -> u32 {
    (2 * (2.0 * (texels.sqrt() - 1.0)).floor().max(0.0) as u32).max(8)
}

/// Properties of the whole surface that the network uses.
pub(super) struct Whole<'a> {
    pub graph: &'a EdgeGraph,
    /// Whether each vertex lies on the surface's own boundary.
    pub rim: &'a [bool],
}

/// Joins the disks of all parts: nodes that all of them have, least counts, and fixed counts for shared paths. `texels` has
/// the share of each part. O(n log n) in the borders, O(vertices).
pub(super) fn join(whole: &Whole<'_>, opened: Vec<Opened>, texels: &[f64]) -> Vec<Bordered> {
    let node = nodes(whole, &opened);
    let mut out: Vec<Bordered> = opened.into_iter().zip(texels).map(|(o, &t)| bordered(whole, o, &node, t)).collect();
    let mut paths: BTreeMap<Vec<u32>, Vec<(usize, usize, bool)>> = BTreeMap::new();
    // Ends of all paths, each once: (ends, what it is).
    let mut ends: BTreeMap<[u32; 2], Vec<(usize, usize)>> = BTreeMap::new();
    for (p, b) in out.iter().enumerate() {
        for path in b.border.paths(&b.opened.disk) {
            let mut way: Vec<u32> = path.vertices.iter().map(|&v| b.opened.global(v)).collect();
            let (first, last) = (way[0], way[way.len() - 1]);
            let mut backward = way.clone();
            backward.reverse();
            let against = backward < way;
            if against {
                way = backward;
            }
            let whose = if path.cut && b.shared.contains_key(&path.group) {
                let holders = paths.entry(way).or_default();
                holders.push((p, path.group, against));
                (holders[0].0, holders[0].1)
            } else {
                (p, path.group)
            };
            let list = ends.entry([first.min(last), first.max(last)]).or_default();
            if !list.contains(&whose) {
                list.push(whose);
            }
        }
    }
    let mut least: BTreeMap<(usize, usize), u32> = BTreeMap::new();
    for (e, list) in &ends {
        // A loop needs three steps and parallel paths two each, or welding would glue edges that are not mates.
        let need = if e[0] == e[1] { 3 } else { u32::from(list.len() > 1) + 1 };
        list.iter().for_each(|&whose| {
            least.insert(whose, need);
        });
    }
    for (&(p, group), &need) in &least {
        out[p].border.fix(group, need, None);
    }
    let wishes: Vec<Vec<u32>> = out
        .iter()
        .map(|b| {
            let steps = b.perimeter().max(b.border.least_steps());
            b.border.share(steps).or_else(|| b.border.share(steps + 2)).unwrap_or_default()
        })
        .collect();
    let single: Vec<bool> = out.iter().map(|b| b.border.paths(&b.opened.disk).iter().any(|p| !p.cut)).collect();
    let mut counts: Vec<u32> = Vec::with_capacity(paths.len());
    for (id, holders) in paths.values().enumerate() {
        let need = least.get(&(holders[0].0, holders[0].1)).copied().unwrap_or(1);
        let wish = |&(p, g, _): &(usize, usize, bool)| f64::from(wishes[p].get(g).copied().unwrap_or(1)).ln();
        let mean = (holders.iter().map(wish).sum::<f64>() / holders.len() as f64).exp();
        let mut count = (mean.round() as u32).max(need);
        // A disk without any boundary of its own cannot make up for an odd sum.
        if holders.iter().any(|h| !single[h.0]) {
            count = count.next_multiple_of(2);
        }
        counts.push(count);
        for &(p, g, against) in holders {
            out[p].shared.insert(g, (id as u32, against));
        }
    }
    let holders: Vec<&Vec<(usize, usize, bool)>> = paths.values().collect();
    lengthen(&mut counts, &holders, &out);
    for (count, holders) in counts.iter().zip(holders) {
        holders.iter().for_each(|&(p, g, _)| out[p].border.fix(g, *count, Some(*count)));
    }
    out
}

/// An image has at least eight border steps: disks that shared paths alone bound get as many.
fn lengthen(counts: &mut [u32], holders: &[&Vec<(usize, usize, bool)>], all: &[Bordered]) {
    for (p, b) in all.iter().enumerate() {
        let paths = b.border.paths(&b.opened.disk);
        if paths.iter().any(|x| !b.shared.contains_key(&x.group)) {
            continue;
        }
        let mine: Vec<usize> = (0..counts.len()).filter(|&id| holders[id].iter().any(|h| h.0 == p)).collect();
        while let Some(&id) = mine.iter().min_by_key(|&&id| (counts[id], id))
            && mine.iter().map(|&id| counts[id]).sum::<u32>() < 8
        {
            counts[id] += 2;
        }
    }
}

/// The kinds of edge in a disk's loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Rim,
    Cut,
    Shared,
}

/// The kind and the edge of the whole of every edge of a disk's loop.
fn kinds(whole: &Whole<'_>, o: &Opened) -> Vec<(Kind, usize)> {
    let n = o.disk.boundary.len();
    (0..n)
        .map(|i| {
            let (a, b) = (o.global(o.disk.boundary[i]), o.global(o.disk.boundary[(i + 1) % n]));
            let edge = whole.graph.neighbours(a).iter().find(|x| x.0 == b).map_or(0, |x| x.1 as usize);
            let kind = match (whole.graph.is_boundary(edge), o.disk.on_cut[i]) {
                (true, _) => Kind::Rim,
                (false, true) => Kind::Cut,
                (false, false) => Kind::Shared,
            };
            (kind, edge)
        })
        .collect()
}

/// The vertices of the whole where paths of the cuts and between the parts end or meet.
fn nodes(whole: &Whole<'_>, opened: &[Opened]) -> Vec<bool> {
    let n = whole.graph.vertices();
    let mut edges: Vec<usize> =
        opened.iter().flat_map(|o| kinds(whole, o)).filter(|x| x.0 != Kind::Rim).map(|x| x.1).collect();
    edges.sort_unstable();
    edges.dedup();
    let mut valence = vec![0u32; n];
    let mut sets = DisjointSets::new(n);
    for &e in &edges {
        let [a, b] = whole.graph.ends[e];
        sets.union(a, b);
        valence[a as usize] += 1;
        valence[b as usize] += 1;
    }
    let mut node: Vec<bool> = (0..n).map(|v| valence[v] != 0 && (valence[v] != 2 || whole.rim[v])).collect();
    // A loop between two parts that nothing else meets starts at its first vertex.
    let set = sets.into_representatives();
    let mut has = vec![false; n];
    (0..n).filter(|&v| node[v]).for_each(|v| has[set[v] as usize] = true);
    (0..n).filter(|&v| valence[v] != 0 && set[v] as usize == v && !has[v]).for_each(|v| node[v] = true);
    node
}

/// The border of a disk between nodes of all disks.
fn bordered(whole: &Whole<'_>, mut opened: Opened, node: &[bool], texels: f64) -> Bordered {
    let kinds = kinds(whole, &opened);
    let n = kinds.len();
    let at = |i: usize| {
        let (before, after) = (kinds[(i + n - 1) % n].0, kinds[i].0);
        let v = opened.global(opened.disk.boundary[i]) as usize;
        (before == Kind::Rim) != (after == Kind::Rim) || (after != Kind::Rim && node[v])
    };
    let mask = (0..n).map(at).collect();
    let mut edge_kind: BTreeMap<[u32; 2], Kind> = BTreeMap::new();
    for (i, k) in kinds.iter().enumerate() {
        let (a, b) = (opened.disk.boundary[i], opened.disk.boundary[(i + 1) % n]);
        edge_kind.insert([a, b], k.0);
        // Corners of the boundary are looked for on the surface's own alone, and mates among paths that are not.
        opened.disk.on_cut[i] = k.0 != Kind::Rim;
    }
    let border = Border::between(&mut opened.disk, mask);
    let shared = border
        .paths(&opened.disk)
        .iter()
        .filter(|p| edge_kind.get(&[p.vertices[0], p.vertices[1]]) == Some(&Kind::Shared))
        .map(|p| (p.group, (0, false)))
        .collect();
    Bordered { opened, border, shared, texels }
}
