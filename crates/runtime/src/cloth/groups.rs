//! Which anchors belong together, and which texels are one point: the input from which tethers are updated after a cut.

use super::{Cloth, Tethers};

/// For every tether (particle and slot, as in [`Tethers::anchors`]) the group of its anchor: anchors that are neighbours
/// in a grid, or duplicates of such, are a group, as a pinned row is. `u32::MAX` where there is no anchor.
pub(crate) fn groups(cloth: &Cloth, tethers: &Tethers) -> Vec<u32> {
    const NEW: u32 = u32::MAX - 1;
    let (points, mates) = (cloth.points(), mates(cloth));
    let mut group = vec![u32::MAX; cloth.len()];
    let anchors = || tethers.anchors.iter().filter(|a| a.exists()).map(|a| points[a.particle as usize] as usize);
    anchors().for_each(|point| group[point] = NEW);
    let mut count = 0;
    for first in 0..cloth.len() {
        let mut open = if group[first] == NEW { vec![first] } else { Vec::new() };
        while let Some(point) = open.pop() {
            group[point] = count;
            ring(&mates, point, |k| {
                open.extend(beside(cloth, k).map(|n| points[n] as usize).filter(|n| group[*n] == NEW));
            });
        }
        count += u32::from(group[first] == count);
    }
    let of = |a: &super::Anchor| if a.exists() { group[points[a.particle as usize] as usize] } else { u32::MAX };
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

/// The up to eight texels around one in its grid.
fn beside(cloth: &Cloth, k: usize) -> impl Iterator<Item = usize> {
    let at = cloth.grids().partition_point(|g| g.first as usize <= k) - 1;
    let (first, w, h) = {
        let g = &cloth.grids()[at];
        (g.first as usize, g.width as usize, g.height as usize)
    };
    let (i, j) = ((k - first) % w, (k - first) / w);
    let steps = (0..9usize).filter(|n| *n != 4).map(|n| (n % 3, n / 3));
    let inside = move |(x, y): &(usize, usize)| (1..=w).contains(&(i + x)) && (1..=h).contains(&(j + y));
    steps.filter(inside).map(move |(x, y)| first + (j + y - 1) * w + i + x - 1)
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
        assert_eq!(beside(&cloth, 12).collect::<Vec<_>>(), [6, 7, 8, 11, 13, 16, 17, 18]);
        assert_eq!(beside(&cloth, 20).collect::<Vec<_>>(), [15, 16, 21]);
    }
}
