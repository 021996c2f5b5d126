//! Which anchors belong together, and which texels are one point: the input from which tethers are updated after a cut.

use super::{Cloth, Tethers};

/// For every tether (particle and slot, as in [`Tethers::anchors`]) the group of its anchor: anchors that are neighbours
/// in a grid, or duplicates of such, are a group, as a pinned row is. `u32::MAX` where there is no anchor.
pub(crate) fn groups(cloth: &Cloth, tethers: &Tethers) -> Vec<u32> {
    let points = cloth.points();
    let mut anchored = vec![false; cloth.len()];
    let anchors = tethers.anchors.iter().filter(|a| a.exists());
    anchors.for_each(|a| anchored[points[a.particle as usize] as usize] = true);
    let anchored: Vec<bool> = points.iter().map(|point| anchored[*point as usize]).collect();
    let (group, _) = marked(cloth, &anchored);
    let of = |a: &super::Anchor| if a.exists() { group[a.particle as usize] } else { u32::MAX };
    tethers.anchors.iter().map(of).collect()
}

/// The group of every pinned particle, `u32::MAX` for others, and the number of groups: pins that are neighbours in a grid, or duplicates of such.
pub(crate) fn of_pins(cloth: &Cloth) -> (Vec<u32>, usize) {
    let pinned: Vec<bool> = cloth.particles().iter().map(|p| p.is_pinned()).collect();
    marked(cloth, &pinned)
}

/// The same of marked particles.
fn marked(cloth: &Cloth, marked: &[bool]) -> (Vec<u32>, usize) {
    let (starts, members) = cloth.rings();
    let rings = starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]);
    gimage_bundle::groups(cloth.grids().iter().map(|g| [g.width, g.height]), rings, marked)
}

/// For every texel the next duplicate of its point; itself off the seams.
pub(crate) fn mates(cloth: &Cloth) -> Vec<u32> {
    let mut next: Vec<u32> = (0..cloth.len() as u32).collect();
    let (starts, members) = cloth.rings();
    for ring in starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]) {
        for (n, k) in ring.iter().enumerate() {
            next[*k as usize] = ring[(n + 1) % ring.len()];
        }
    }
    next
}

/// Ends of stitches by texels, as tethers lead over them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Bridges {
    /// Offsets into `ends` per texel, one more than there are texels; empty without stitches.
    pub starts: Vec<u32>,
    /// The texel at the other end, the length of the path to it \[m\], and the first texel of the quad, without which the path is gone.
    pub ends: Vec<(u32, f32, u32)>,
}

impl Bridges {
    /// Those of a cloth, with lengths of its present rest lengths.
    pub fn of(cloth: &Cloth) -> Self {
        let mut all = Vec::new();
        for bridge in cloth.bridges() {
            for (n, corner) in bridge.corners.into_iter().enumerate() {
                let (length, quad) = (bridge.length(n) as f32, bridge.corners[0]);
                all.extend([(corner, (bridge.particle, length, quad)), (bridge.particle, (corner, length, quad))]);
            }
        }
        if all.is_empty() {
            return Bridges::default();
        }
        all.sort_by_key(|(k, end)| (*k, end.0, end.2));
        let starts = (0..=cloth.len() as u32).map(|k| all.partition_point(|(at, _)| *at < k) as u32).collect();
        Bridges { starts, ends: all.into_iter().map(|(_, end)| end).collect() }
    }

    /// The ends beside a texel.
    pub fn at(&self, k: usize) -> &[(u32, f32, u32)] {
        let range = self.starts.get(k).zip(self.starts.get(k + 1));
        range.map_or(&[], |(start, end)| &self.ends[*start as usize..*end as usize])
    }

    /// Most ends beside one texel.
    pub fn most(&self) -> u32 {
        self.starts.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0)
    }
}

/// Calls `each` with all duplicates of a texel, itself first.
pub(crate) fn ring(mates: &[u32], k: usize, mut each: impl FnMut(usize)) {
    let mut m = k;
    loop {
        each(m);
        m = mates[m] as usize;
        if m == k {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Anchor, Flat};
    use super::*;

    #[test]
    fn pins_beside_one_another_are_a_group() {
        let mut cloth = Flat::square("flat", 5).cloth().unwrap();
        // A row of two, one diagonally below it, and one apart.
        [0, 1, 7, 24].iter().for_each(|k| cloth.set_pinned(*k, true).unwrap());
        let found = cloth.tethers(2);
        let groups = groups(&cloth, &found);
        for (k, anchors) in found.anchors.chunks(2).enumerate() {
            let near = anchors.iter().position(|a| a.particle == 24).unwrap();
            assert_eq!((groups[2 * k + near], groups[2 * k + 1 - near]), (1, 0), "{k}");
        }
        let none = Tethers { per_particle: 1, anchors: vec![Anchor::NONE; 25] };
        assert!(super::groups(&cloth, &none).iter().all(|g| *g == u32::MAX));
    }
}
