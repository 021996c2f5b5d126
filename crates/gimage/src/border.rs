//! The boundary of a disk -> whole texels along the border of the image.
//!
//! Gu, Gortler, Hoppe 2002: both sides of a cut path get the same whole number of texel steps, and the nodes where
//! paths end or meet fall on texels, so that the two sides are sampled at the same points and the rebuilt surface has no
//! crack. Texels are spread over the paths by length.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use crate::disk::{Disk, NONE};
use crate::surface::Surface;
use crate::vec3::{distance, lerp};

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
    /// A vertex of the boundary loop it lies on; none for a cut path.
    rim: Option<u32>,
}

/// The structure of a disk's boundary. Independent of the size of the image.
#[derive(Clone, Debug)]
pub(crate) struct Border {
    segments: Vec<Segment>,
    groups: Vec<Group>,
    /// There is no cut: the boundary may start anywhere.
    free: bool,
    /// The loop vertices that are nodes.
    pub(crate) nodes: Vec<bool>,
}

/// Which surface point a border texel is: texels with equal keys are duplicates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Key {
    /// A vertex of the surface.
    Node(u32),
    /// Step `.1` of the path `.0`.
    Inner(u32, u32),
    /// Some point of the boundary of a disk that needed no cut.
    Free(u32),
}

/// One texel on the border of the image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BorderTexel {
    /// What it is.
    pub key: Key,
    /// Where it is \[m\]; bit-identical for equal keys.
    pub position: [f64; 3],
    /// The disk triangle it lies on the edge of.
    pub triangle: u32,
    /// Barycentric coordinates in that triangle.
    pub bary: [f64; 3],
    /// A vertex of the surface's boundary loop that it lies on, if it lies on one.
    pub rim: Option<u32>,
}

/// A disk whose boundary has been laid on the border of a `w` x `h` cell rectangle.
pub(crate) struct Placed {
    /// The disk, with a vertex on each corner and no inner edge between boundary vertices.
    pub disk: Disk,
    /// Places of the boundary vertices, in cells; zero elsewhere.
    pub uv: Vec<[f64; 2]>,
    /// The border texels counter-clockwise from (0, 0).
    pub texels: Vec<BorderTexel>,
}

/// Where step `p` of the perimeter of a `w` x `h` rectangle is, counter-clockwise from (0, 0).
pub(crate) fn on_rectangle(p: f64, w: u32, h: u32) -> [f64; 2] {
    let (w, h) = (f64::from(w), f64::from(h));
    let p = p.rem_euclid(2.0 * (w + h));
    if p <= w {
        [p, 0.0]
    } else if p <= w + h {
        [w, p - w]
    } else if p <= 2.0 * w + h {
        [2.0 * w + h - p, h]
    } else {
        [0.0, 2.0 * (w + h) - p]
    }
}

impl Border {
    /// Finds the nodes and paths of a disk, turning its loop so that it starts at a node.
    pub(crate) fn new(disk: &mut Disk, surface_boundary: impl Fn(u32) -> bool) -> Self {
        let n = disk.boundary.len();
        let free = disk.on_cut.iter().all(|c| !c);
        let mut node = vec![false; n];
        if !free {
            let mut ends: BTreeSet<[u32; 2]> = BTreeSet::new();
            for i in (0..n).filter(|&i| disk.on_cut[i]) {
                let (a, b) = (disk.origin[disk.boundary[i] as usize], disk.origin[disk.boundary[(i + 1) % n] as usize]);
                ends.insert([a.min(b), a.max(b)]);
            }
            let mut valence: HashMap<u32, u32> = HashMap::new();
            ends.iter().flatten().for_each(|&v| *valence.entry(v).or_default() += 1);
            for i in 0..n {
                let (before, after) = (disk.on_cut[(i + n - 1) % n], disk.on_cut[i]);
                let v = disk.origin[disk.boundary[i] as usize];
                node[i] = before != after || (after && (valence.get(&v) != Some(&2) || surface_boundary(v)));
            }
            if !node.contains(&true) {
                // A one-sided loop alone (the projective plane): any of its points will do.
                let v = disk.origin[disk.boundary[0] as usize];
                (0..n).for_each(|i| node[i] = disk.origin[disk.boundary[i] as usize] == v);
            }
            let shift = node.iter().position(|&x| x).unwrap_or(0);
            disk.boundary.rotate_left(shift);
            disk.on_cut.rotate_left(shift);
            node.rotate_left(shift);
        }
        let starts: Vec<usize> = if free { vec![0] } else { (0..n).filter(|&i| node[i]).collect() };
        let mut segments = Vec::with_capacity(starts.len());
        let mut groups: Vec<Group> = Vec::new();
        let mut by_path: BTreeMap<Vec<u32>, usize> = BTreeMap::new();
        let mut by_ends: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
        for (k, &first) in starts.iter().enumerate() {
            let end = starts.get(k + 1).copied().unwrap_or(n);
            let at = |i: usize| disk.boundary[i % n];
            let path: Vec<u32> = (first..=end).map(|i| disk.origin[at(i) as usize]).collect();
            let length = (first..end)
                .map(|i| distance(disk.positions[at(i) as usize], disk.positions[at(i + 1) as usize]))
                .sum();
            let mut backward = path.clone();
            backward.reverse();
            let cut = disk.on_cut[first];
            let mate = if cut {
                by_path.get(&path).map(|&g| (g, false)).or(by_path.get(&backward).map(|&g| (g, true)))
            } else {
                None
            };
            let (group, reversed) = mate.unwrap_or_else(|| {
                groups.push(Group { members: 0, length, least: 1, rim: (!cut).then_some(path[0]) });
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

    /// The fewest border steps that can hold this boundary: even, at least 8.
    pub(crate) fn least_steps(&self) -> u32 {
        let sum: u32 = self.groups.iter().map(|g| g.members * g.least).sum();
        sum.max(8).next_multiple_of(2)
    }

    /// The boundary has no cut on it.
    pub(crate) fn is_free(&self) -> bool {
        self.free
    }

    /// Steps for each group, `steps` (even) in all. `None` if they cannot be shared out.
    fn share(&self, steps: u32) -> Option<Vec<u32>> {
        if self.free {
            return Some(vec![steps]);
        }
        let total: f64 = self.groups.iter().map(|g| g.length * f64::from(g.members)).sum();
        let want: Vec<f64> = self.groups.iter().map(|g| g.length / total.max(1e-300) * f64::from(steps)).collect();
        let mut count: Vec<u32> = self.groups.iter().zip(&want).map(|(g, w)| (w.floor() as u32).max(g.least)).collect();
        let mut rest =
            i64::from(steps) - self.groups.iter().zip(&count).map(|(g, c)| i64::from(g.members * c)).sum::<i64>();
        let mut budget = 4 * steps as usize + 16;
        while rest != 0 {
            budget = budget.checked_sub(1)?;
            let mut best: Option<(f64, usize, i64)> = None;
            for (i, g) in self.groups.iter().enumerate() {
                for step in [rest.signum(), -rest.signum()] {
                    let m = i64::from(g.members) * step;
                    let new = i64::from(count[i]) + step;
                    // A step the other way is only for parity: it must not take us farther off than one.
                    let ok = if step == rest.signum() {
                        m.abs() <= rest.abs() || (rest.abs() == 1 && m.abs() == 2)
                    } else {
                        false
                    };
                    if !ok || new < i64::from(g.least) {
                        continue;
                    }
                    let penalty = if m.abs() > rest.abs() { 1e6 } else { 0.0 };
                    // Relative change of density, so that short paths are not squeezed first.
                    let cost = ((want[i] - new as f64).abs() - (want[i] - f64::from(count[i])).abs()) + penalty;
                    if best.is_none_or(|b| cost < b.0) {
                        best = Some((cost, i, step));
                    }
                }
            }
            let (_, i, step) = best?;
            count[i] = (i64::from(count[i]) + step) as u32;
            rest -= step * i64::from(self.groups[i].members);
        }
        Some(count)
    }

    /// For each loop vertex, its place along the border in steps from the start of the loop.
    pub(crate) fn along(&self, disk: &Disk, steps: u32) -> Option<Vec<f64>> {
        let count = self.share(steps)?;
        let n = disk.boundary.len();
        let mut along = vec![0.0; n];
        let mut base = 0.0;
        for s in &self.segments {
            let edge: Vec<f64> = (s.first..s.first + s.edges)
                .map(|i| {
                    let (a, b) = (disk.boundary[i % n] as usize, disk.boundary[(i + 1) % n] as usize);
                    distance(disk.positions[a], disk.positions[b])
                })
                .collect();
            // Keep very short edges from falling into one point.
            let floor = 1e-7 * edge.iter().sum::<f64>() / edge.len() as f64;
            let total: f64 = edge.iter().map(|l| l.max(floor)).sum();
            let (steps, mut done) = (f64::from(count[s.group]), 0.0);
            for (k, l) in edge.iter().enumerate() {
                along[s.first + k] = base + steps * done / total.max(1e-300);
                done += l.max(floor);
            }
            base += steps;
        }
        Some(along)
    }

    /// Steps at which the two sides of a dead end of the cut meet; an image corner there would be a folded quad.
    pub(crate) fn dead_ends(&self, steps: u32) -> Vec<u32> {
        let Some(count) = self.share(steps) else { return Vec::new() };
        let mut out = Vec::new();
        let mut base = 0;
        for (k, s) in self.segments.iter().enumerate() {
            let before = &self.segments[(k + self.segments.len() - 1) % self.segments.len()];
            if self.groups[s.group].members == 2 && before.group == s.group && before.reversed != s.reversed {
                out.push(base);
            }
            base += count[s.group];
        }
        out
    }

    /// Lays the boundary on a `w` x `h` cell rectangle, its start `shift` steps from (0, 0).
    pub(crate) fn place(
        &self,
        disk: &Disk,
        surface: &Surface,
        surface_boundary: &dyn Fn(u32) -> bool,
        w: u32,
        h: u32,
        shift: f64,
    ) -> Option<Placed> {
        let steps = 2 * (w + h);
        let perimeter = f64::from(steps);
        let count = self.share(steps)?;
        let mut along = self.along(disk, steps)?;
        let mut disk = disk.clone();
        let mut splits = Vec::new();
        let mut extra = Vec::new();
        for corner in [0, w, w + h, 2 * w + h] {
            let at = (f64::from(corner) - shift).rem_euclid(perimeter);
            let i = along.partition_point(|&x| x <= at).saturating_sub(1);
            let next = along.get(i + 1).copied().unwrap_or(perimeter);
            if at - along[i] < 1e-6 {
                along[i] = at;
            } else if next - at < 1e-6 && i + 1 < along.len() {
                along[i + 1] = at;
            } else {
                splits.push((i, (at - along[i]) / (next - along[i])));
                extra.push(at);
            }
        }
        // Node places are whole numbers: a corner within rounding of one is that one.
        disk.split_boundary(&splits);
        along.extend(extra);
        along.sort_by(f64::total_cmp);
        disk.split_chords();
        let mut uv = vec![[0.0; 2]; disk.positions.len()];
        for (v, a) in disk.boundary.iter().zip(&along) {
            uv[*v as usize] = on_rectangle(a + shift, w, h);
        }
        let texels = self.texels(&disk, surface, surface_boundary, &along, &count, perimeter, shift)?;
        Some(Placed { disk, uv, texels })
    }

    fn texels(
        &self,
        disk: &Disk,
        surface: &Surface,
        surface_boundary: &dyn Fn(u32) -> bool,
        along: &[f64],
        count: &[u32],
        perimeter: f64,
        shift: f64,
    ) -> Option<Vec<BorderTexel>> {
        let mut face_of: HashMap<[u32; 2], (u32, usize)> = HashMap::new();
        let n = disk.boundary.len();
        let wanted: HashSet<[u32; 2]> = (0..n).map(|i| [disk.boundary[i], disk.boundary[(i + 1) % n]]).collect();
        for (f, t) in disk.triangles.iter().enumerate() {
            for k in 0..3 {
                let e = [t[k], t[(k + 1) % 3]];
                if wanted.contains(&e) {
                    face_of.insert(e, (f as u32, k));
                }
            }
        }
        let steps = perimeter as u32;
        let mut keys = Vec::with_capacity(steps as usize);
        if self.free {
            keys.extend((0..steps).map(|p| (Key::Free(p), (f64::from(p) - shift).rem_euclid(perimeter))));
        } else {
            let mut base = 0u32;
            for s in &self.segments {
                let n = count[s.group];
                for k in 0..n {
                    let key = if k == 0 {
                        // Splits only append: the loop still has the node at its whole step.
                        let i = along.partition_point(|&x| x < f64::from(base) - 1e-9);
                        Key::Node(disk.origin[disk.boundary[i] as usize])
                    } else {
                        Key::Inner(s.group as u32, if s.reversed { n - k } else { k })
                    };
                    keys.push((key, f64::from(base + k)));
                }
                base += n;
            }
        }
        let mut texels = Vec::with_capacity(keys.len());
        let mut known: HashMap<Key, [f64; 3]> = HashMap::new();
        for (key, at) in keys {
            let mut i = along.partition_point(|&x| x <= at + 1e-9).saturating_sub(1);
            let next = along.get(i + 1).copied().unwrap_or(perimeter);
            let mut t = if next > along[i] { ((at - along[i]) / (next - along[i])).clamp(0.0, 1.0) } else { 0.0 };
            if t > 1.0 - 1e-12 {
                (i, t) = ((i + 1) % n, 0.0);
            }
            let (a, b) = (disk.boundary[i], disk.boundary[(i + 1) % n]);
            let &(triangle, corner) = face_of.get(&[a, b])?;
            let mut bary = [0.0; 3];
            bary[corner] = 1.0 - t;
            bary[(corner + 1) % 3] = t;
            let here = lerp(disk.positions[a as usize], disk.positions[b as usize], t);
            let position = match key {
                Key::Node(v) if v != NONE => surface.positions[v as usize],
                _ => *known.entry(key).or_insert(here),
            };
            let rim = match key {
                Key::Node(v) => surface_boundary(v).then_some(v),
                Key::Inner(g, _) => self.groups[g as usize].rim,
                Key::Free(_) => self.groups[0].rim,
            };
            texels.push(BorderTexel { key, position, triangle, bary, rim });
        }
        if !self.free {
            // Texel p of the image is step p - shift of the loop.
            texels.rotate_right(shift as usize % steps as usize);
        }
        Some(texels)
    }
}
