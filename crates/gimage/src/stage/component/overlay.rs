//! Components that lie on a larger one all over, such as a print, a logo or a reinforcement that was modelled as a copy of faces. As cloth of
//! their own they would pass through what they lie on; they ride on it.

use super::{ALWAYS_PIECE, Component};
use crate::base::closest::Closest;
use crate::base::mesh::Mesh;
use crate::base::vec3::{add, cross, dot, normalize, scale, sub};

/// Largest distance from the larger component, as a share of the diagonal of the mesh. In the files tried such copies are 1e-5 away, or half the thickness of a
/// shell, and other parts of a garment 3e-3 and more.
const REACH: f64 = 1e-3;
/// Share of the area that lies on the larger component.
const SHARE: f64 = 0.95;
/// Least cosine between the normals of both: a lining that faces the other way is the second sheet of a shell.
const PARALLEL: f64 = 0.7;
/// Triangles, spread over a component, of which half have to lie on the other one before all are looked at.
const PROBES: usize = 64;

/// Takes the components that lie on a larger one out of `pieces`, and names that in each. `share` is the share of a component of the area of the
/// mesh. O(n log n) in the triangles, nothing if all pieces are large.
pub(super) fn take(mesh: &Mesh, pieces: &mut Vec<Component>, share: impl Fn(&Component) -> f64) -> Vec<Component> {
    let is_large: Vec<bool> = pieces.iter().map(|c| share(c) >= ALWAYS_PIECE).collect();
    let Some((low, high)) = mesh.bounds().filter(|_| is_large.contains(&true) && is_large.contains(&false)) else {
        return Vec::new();
    };
    let reach = REACH * dot(sub(high, low), sub(high, low)).sqrt();
    let mut owner = Vec::new();
    for (k, piece) in pieces.iter().enumerate().filter(|(k, _)| is_large[*k]) {
        owner.extend(piece.triangles.iter().map(|t| (k, *t)));
    }
    let corners: Vec<[[f64; 3]; 3]> = owner.iter().map(|(_, t)| mesh.corners(*t as usize)).collect();
    let large = Closest::of(&corners);
    // The large component that a triangle lies on.
    let under = |t: u32| {
        let own = mesh.corners(t as usize);
        let normal = normal(own);
        let middle = scale(add(own[0], add(own[1], own[2])), 1.0 / 3.0);
        let mut found = None;
        for p in [middle, own[0], own[1], own[2]] {
            let near = large.project(p).filter(|near| near.distance <= reach)?;
            found = found
                .or((dot(self::normal(corners[near.triangle as usize]), normal) >= PARALLEL).then_some(near.triangle));
            found?;
        }
        Some(owner[found? as usize].0)
    };
    let lies_on = |c: &Component| -> Option<usize> {
        let step = c.triangles.len().div_ceil(PROBES);
        let probes: Vec<u32> = c.triangles.iter().copied().step_by(step).collect();
        if 2 * probes.iter().filter(|t| under(**t).is_some()).count() < probes.len() {
            return None;
        }
        let mut areas = vec![0.0; is_large.len()];
        for &t in &c.triangles {
            if let Some(k) = under(t) {
                areas[k] += mesh.triangle_area(t as usize);
            }
        }
        // It may lie on several.
        let most = (0..areas.len()).fold(0, |most, k| if areas[k] > areas[most] { k } else { most });
        (areas.iter().sum::<f64>() >= SHARE * c.area).then_some(most)
    };
    let on: Vec<Option<usize>> =
        pieces.iter().zip(&is_large).map(|(c, large)| if *large { None } else { lies_on(c) }).collect();
    let names: Vec<String> = pieces.iter().map(|c| c.name.clone()).collect();
    let mut taken = Vec::new();
    for (k, component) in std::mem::take(pieces).into_iter().enumerate() {
        match on[k] {
            Some(larger) => taken.push(Component { lies_on: Some(names[larger].clone()), ..component }),
            None => pieces.push(component),
        }
    }
    taken
}

fn normal([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    normalize(cross(sub(b, a), sub(c, a)))
}

#[cfg(test)]
mod tests {
    use super::super::{ComponentOptions, split};
    use super::*;

    /// A bent sheet of `n` x `n` quads of a unit square; its part from `from` to `to` along both sides.
    fn sheet(mesh: &mut Mesh, n: u32, (from, to): (f64, f64), height: f64, turned: bool) {
        let first = mesh.positions.len() as u32;
        for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
            let [x, y] = [i, j].map(|k| from + (to - from) * f64::from(k) / f64::from(n));
            mesh.positions.push([x, y, 0.1 * (3.0 * x).sin() + height]);
        }
        for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
            let k = first + j * (n + 1) + i;
            for t in [[k, k + 1, k + n + 2], [k, k + n + 2, k + n + 1]] {
                mesh.triangles.push(if turned { [t[0], t[2], t[1]] } else { t });
                mesh.triangle_part.push(0);
            }
        }
    }

    fn found(height: f64, turned: bool, part: (f64, f64)) -> (usize, Vec<Option<String>>) {
        let mut mesh = Mesh { parts: vec![Default::default()], ..Mesh::default() };
        sheet(&mut mesh, 40, (0.0, 1.0), 0.0, false);
        sheet(&mut mesh, 9, part, height, turned);
        let split = split(&mesh, &ComponentOptions::default());
        (split.pieces.len(), split.accessories.iter().map(|c| c.lies_on.clone()).collect())
    }

    #[test]
    fn a_print_rides_on_the_sheet_and_what_is_near_by_does_not() {
        let (pieces, riders) = found(3e-4, false, (0.3, 0.5));
        assert_eq!((pieces, riders.len()), (1, 1));
        assert!(riders[0].as_deref().is_some_and(|name| !name.is_empty()));
        // A pocket 1 cm in front, a sheet that faces the other way, one that reaches beyond the border, and a large one.
        for (height, turned, part) in
            [(0.01, false, (0.3, 0.5)), (3e-4, true, (0.3, 0.5)), (3e-4, false, (0.9, 1.1)), (3e-4, false, (0.3, 0.8))]
        {
            assert_eq!(found(height, turned, part), (2, Vec::new()), "{height} {turned} {part:?}");
        }
    }
}
