//! Single vertices far off the others, as a damaged file has them: the triangles around one are spikes.

use super::vec3::{distance, norm, sub};

/// A spike is longer than this share of the diagonal of the box around all other vertices, and this many times as long as the box around its base is wide.
const LONG: f64 = 0.5;
const SLENDER: f64 = 4.0;
/// More spikes than this share of the vertices, and than one, are the shape of a garment, such as a fringe.
const MOST: f64 = 0.01;

/// The lowest and the highest corner of a box.
pub(crate) type Bounds = ([f64; 3], [f64; 3]);

/// The tips of spikes in ascending order, and the box around all other vertices that triangles use, where that is not empty. A tip has no other tip beside it. O(n log n).
pub(crate) fn strays(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> (Vec<u32>, Option<Bounds>) {
    // For each vertex the box around the vertices that it shares triangles with, and the distance to the nearest one.
    let mut around: Vec<(Option<Bounds>, f64)> = vec![(None, f64::INFINITY); positions.len()];
    for t in triangles {
        for (v, n) in (0..3).flat_map(|c| [(t[c], t[(c + 1) % 3]), (t[c], t[(c + 2) % 3])]).filter(|(v, n)| v != n) {
            let (all, near) = &mut around[v as usize];
            widen(all, positions[n as usize]);
            *near = near.min(distance(positions[v as usize], positions[n as usize]));
        }
    }
    let is_spike: Vec<bool> = around
        .iter()
        .map(|(all, near)| all.is_some_and(|all| near.is_finite() && *near > SLENDER * diagonal(all)))
        .collect();
    let used = |v: &u32| around[*v as usize].0.is_some();
    let mut others = None;
    let all = || (0..positions.len() as u32).filter(used);
    all().filter(|v| !is_spike[*v as usize]).for_each(|v| widen(&mut others, positions[v as usize]));
    let Some(size) = others.map(diagonal) else { return (Vec::new(), None) };
    let mut tips: Vec<u32> = all().filter(|v| is_spike[*v as usize] && around[*v as usize].1 > LONG * size).collect();
    let mut is_beside = vec![false; positions.len()];
    for t in triangles.iter().filter(|t| t.iter().filter(|v| tips.binary_search(v).is_ok()).count() > 1) {
        t.iter().for_each(|v| is_beside[*v as usize] = true);
    }
    tips.retain(|v| !is_beside[*v as usize]);
    if tips.len() as f64 > (MOST * all().count() as f64).max(1.0) {
        tips.clear();
    }
    let mut rest = None;
    all().filter(|v| tips.binary_search(v).is_err()).for_each(|v| widen(&mut rest, positions[v as usize]));
    (tips, rest)
}

/// Widens a box to a point.
pub(crate) fn widen(bounds: &mut Option<Bounds>, p: [f64; 3]) {
    let (lo, hi) = bounds.get_or_insert((p, p));
    for k in 0..3 {
        lo[k] = lo[k].min(p[k]);
        hi[k] = hi[k].max(p[k]);
    }
}

/// The diagonal of a box.
pub(crate) fn diagonal((lo, hi): Bounds) -> f64 {
    norm(sub(hi, lo))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::shapes::rectangle;

    #[test]
    fn single_vertices_far_off_are_strays_and_shapes_are_not() {
        let mesh = rectangle(20, 20, 1.0, 1.0);
        let size = 2f64.sqrt();
        let found = |positions: &[[f64; 3]]| strays(positions, &mesh.triangles).0;
        let (tips, bounds) = strays(&mesh.positions, &mesh.triangles);
        assert_eq!((tips, bounds.map(diagonal)), (vec![], Some(size)));
        // One inside, and one at a corner.
        let mut far = mesh.positions.clone();
        far[210] = [0.3, 90.0, 0.0];
        assert_eq!(found(&far), [210]);
        far[0][2] -= 100.0;
        assert_eq!(found(&far), [0, 210]);
        let (_, bounds) = strays(&far, &mesh.triangles);
        assert!(bounds.is_some_and(|b| diagonal(b) <= size), "{bounds:?}");
        // A tip that a garment can have.
        let mut tip = mesh.positions.clone();
        tip[210][2] += 0.3;
        assert_eq!(found(&tip), [0u32; 0]);
        // A tassel at every second place of a border.
        let mut fringed = mesh.clone();
        for k in (0..18u32).step_by(2) {
            fringed.positions.push([mesh.positions[k as usize][0], -2.0, 0.0]);
            fringed.triangles.push([k, k + 1, fringed.positions.len() as u32 - 1]);
        }
        assert_eq!(strays(&fringed.positions, &fringed.triangles).0, [0u32; 0]);
        // A quad alone, and nothing.
        let quad = [[0.0; 3], [9.0, 0.0, 0.0], [9.0, 0.0, 9.0], [0.0, 0.0, 9.0]];
        assert_eq!(strays(&quad, &[[0, 1, 2], [0, 2, 3]]).0, [0u32; 0]);
        assert_eq!(strays(&[], &[]), (vec![], None));
    }
}
