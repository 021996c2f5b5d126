//! Which anchors belong together, and which texels are one point: the input from which tethers are updated after a cut.

use super::{Cloth, Tethers};

/// For every tether (particle and slot, as in [`Tethers::anchors`]) the group of its anchor: anchors that are neighbours
/// in a grid, or duplicates of such, are a group, as a pinned row is. `u32::MAX` where there is no anchor.
pub(crate) fn groups(cloth: &Cloth, tethers: &Tethers) -> Vec<u32> {
    let points = cloth.points();
    let mut anchored = vec![false; cloth.len()];
    let anchors = tethers.anchors.iter().filter(|a| a.exists());
    anchors.for_each(|a| anchored[points[a.particle as usize] as usize] = true);
    let marked: Vec<bool> = points.iter().map(|point| anchored[*point as usize]).collect();
    let (starts, members) = cloth.rings();
    let rings = starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]);
    let sizes = cloth.grids().iter().map(|g| [g.width, g.height]);
    let (group, _) = gimage_bundle::groups(sizes, rings, &marked);
    let of = |a: &super::Anchor| if a.exists() { group[a.particle as usize] } else { u32::MAX };
    tethers.anchors.iter().map(of).collect()
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
