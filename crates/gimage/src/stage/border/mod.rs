//! The boundary of a disk -> whole texels along the border of the image.
//!
//! Gu, Gortler, Hoppe 2002: both sides of a cut path get the same whole number of texel steps, and the nodes where
//! paths end or meet fall on texels, so that the two sides are sampled at the same points and the rebuilt surface has no
//! crack. Texels are spread over the paths by length.

mod corner;
mod place;
mod share;

use std::collections::{BTreeMap, BTreeSet, HashMap};

use crate::stage::cut::disk::Disk;

#[cfg(test)]
pub(crate) use place::Placed;
pub(crate) use place::on_rectangle;
pub use place::{BorderTexel, Key};

/// A stretch of the boundary loop between two nodes.
#[derive(Clone, Debug)]
struct Segment {
    /// Where it starts in the loop.
    first: usize,
    /// How many edges it has.
    edges: usize,
    /// Its group.
    group: usize,
    /// It runs against the group's first member.
    reversed: bool,
}

/// One cut path (two segments) or one stretch of a boundary loop (one segment): members get equal counts.
#[derive(Clone, Debug)]
struct Group {
    members: u32,
    length: f64,
    least: u32,
    /// The count is decided already: another disk has the same path.
    fixed: Option<u32>,
    /// A vertex of the boundary loop it lies on; none for a cut path.
    rim: Option<u32>,
}

/// The structure of a disk's boundary. Independent of the size of the image.
#[derive(Clone, Debug)]
pub struct Border {
    segments: Vec<Segment>,
    groups: Vec<Group>,
    /// There is neither cut nor corner: the boundary may start anywhere.
    free: bool,
    /// The loop vertices that are nodes.
    pub(crate) nodes: Vec<bool>,
}

/// The nodes of a disk's loop that its cut makes: where cut and boundary, or several cut paths, meet.
fn cut_nodes(disk: &Disk, surface_boundary: impl Fn(u32) -> bool) -> Vec<bool> {
    let n = disk.boundary.len();
    let mut node = vec![false; n];
    if disk.on_cut.contains(&true) {
        let mut ends: BTreeSet<[u32; 2]> = BTreeSet::new();
        for i in (0..n).filter(|&i| disk.on_cut[i]) {
            let (a, b) = (disk.origin[disk.boundary[i] as usize], disk.origin[disk.boundary[(i + 1) % n] as usize]);
            ends.insert([a.min(b), a.max(b)]);
        }
        let mut valence: HashMap<u32, u32> = HashMap::new();
        ends.iter().flatten().for_each(|&v| *valence.entry(v).or_default() += 1);
        for (i, node) in node.iter_mut().enumerate() {
            let (before, after) = (disk.on_cut[(i + n - 1) % n], disk.on_cut[i]);
            let v = disk.origin[disk.boundary[i] as usize];
            *node = before != after || (after && (valence.get(&v) != Some(&2) || surface_boundary(v)));
        }
        if !node.contains(&true) {
            // A one-sided loop alone (the projective plane): any of its points will do.
            let v = disk.origin[disk.boundary[0] as usize];
            (0..n).for_each(|i| node[i] = disk.origin[disk.boundary[i] as usize] == v);
        }
    }
    node
}

impl Border {
    /// Finds the nodes and paths of a disk, turning its loop so that it starts at a node.
    pub(crate) fn new(disk: &mut Disk, surface_boundary: impl Fn(u32) -> bool) -> Self {
        let node = cut_nodes(disk, surface_boundary);
        Self::between(disk, node)
    }

    /// The paths of a disk between these nodes of its loop and its corners, turning the loop so that it starts at a node.
    pub(crate) fn between(disk: &mut Disk, mut node: Vec<bool>) -> Self {
        let n = disk.boundary.len();
        corner::mark(disk, &mut node);
        let shift = node.iter().position(|&x| x).unwrap_or(0);
        disk.boundary.rotate_left(shift);
        disk.on_cut.rotate_left(shift);
        node.rotate_left(shift);
        let free = !node.contains(&true);
        let starts: Vec<usize> = if free { vec![0] } else { (0..n).filter(|&i| node[i]).collect() };
        let mut segments = Vec::with_capacity(starts.len());
        let mut groups: Vec<Group> = Vec::new();
        let mut by_path: BTreeMap<Vec<u32>, usize> = BTreeMap::new();
        let mut by_ends: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
        for (k, &first) in starts.iter().enumerate() {
            let end = starts.get(k + 1).copied().unwrap_or(n);
            let at = |i: usize| disk.boundary[i % n];
            let path: Vec<u32> = (first..=end).map(|i| disk.origin[at(i) as usize]).collect();
            let length = (first..end).map(|i| disk.length(at(i), at(i + 1))).sum();
            let mut backward = path.clone();
            backward.reverse();
            let cut = disk.on_cut[first];
            let mate = if cut {
                by_path.get(&path).map(|&g| (g, false)).or(by_path.get(&backward).map(|&g| (g, true)))
            } else {
                None
            };
            let (group, reversed) = mate.unwrap_or_else(|| {
                groups.push(Group { members: 0, length, least: 1, fixed: None, rim: (!cut).then_some(path[0]) });
                let g = groups.len() - 1;
                let (a, b) = (path[0].min(path[path.len() - 1]), path[0].max(path[path.len() - 1]));
                by_ends.entry([a, b]).or_default().push(g);
                if cut {
                    by_path.insert(path, g);
                }
                (g, false)
            });
            groups[group].members += 1;
            segments.push(Segment { first, edges: end - first, group, reversed });
        }
        // A loop needs three steps and parallel paths two each, or welding would glue edges that are not mates.
        for (ends, list) in by_ends {
            for &g in &list {
                groups[g].least = if free {
                    8
                } else if ends[0] == ends[1] {
                    3
                } else if list.len() > 1 {
                    2
                } else {
                    1
                };
            }
        }
        Self { segments, groups, free, nodes: node }
    }
}

#[cfg(test)]
mod tests;
