//! Cleans the labels of triangles: large connected sheets stay, the band between them is rim.

use gimage_bundle::DisjointSets;

use super::sides::Sides;
use super::zone::Zone;
use crate::base::vec3::distance;

/// Share of a group's area from which a connected set of triangles that are faced is a sheet of its own right.
const CORE: f64 = 0.01;
/// A set of other triangles belongs to a sheet if its border with it is this many times as long as with the other sheet.
const MOSTLY: f64 = 4.0;

/// The place of a triangle in a shell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layer {
    /// On the sheet of the triangle that stands for the group.
    First,
    /// On the sheet that faces that one.
    Second,
    /// On neither.
    Rim,
}

impl Layer {
    fn of(is_other: bool) -> Self {
        if is_other { Layer::Second } else { Layer::First }
    }

    /// The other sheet.
    pub fn facing(self) -> Self {
        match self {
            Layer::First => Layer::Second,
            Layer::Second => Layer::First,
            Layer::Rim => Layer::Rim,
        }
    }

    fn bit(self) -> u8 {
        match self {
            Layer::First => 1,
            Layer::Second => 2,
            Layer::Rim => 0,
        }
    }
}

/// The layer of each triangle of a zone; `positions` are those of the mesh. O(n log n).
pub(super) fn layers(zone: &Zone, sides: &Sides, positions: &[[f64; 3]]) -> Vec<Layer> {
    let n = zone.triangles.len();
    let faced = |t: u32| zone.gap[t as usize].is_finite();
    let label = |t: u32| Layer::of(sides.is_other[t as usize]);
    let mut islands = DisjointSets::new(n);
    for e in &sides.edges {
        let [a, b] = e.triangles;
        if faced(a) && faced(b) && label(a) == label(b) {
            islands.union(a, b);
        }
    }
    let (mut whole, mut of_island) = (vec![0.0; n], vec![0.0; n]);
    for t in 0..n as u32 {
        whole[sides.group[t as usize] as usize] += zone.area[t as usize];
        of_island[islands.find(t) as usize] += zone.area[t as usize];
    }
    let mut core =
        |t: u32| faced(t) && of_island[islands.find(t) as usize] >= CORE * whole[sides.group[t as usize] as usize];
    let mut out: Vec<Option<Layer>> = (0..n as u32).map(|t| core(t).then(|| label(t))).collect();
    // A triangle that touches both sheets is a part of the rim.
    let mut touched = vec![0u8; positions.len()];
    for (layer, triangle) in out.iter().zip(&zone.triangles) {
        let bit = layer.map_or(0, Layer::bit);
        triangle.iter().for_each(|&v| touched[v as usize] |= bit);
    }
    for (layer, triangle) in out.iter_mut().zip(&zone.triangles).filter(|x| x.0.is_none()) {
        if triangle.iter().fold(0, |bits, &v| bits | touched[v as usize]) == 3 {
            *layer = Some(Layer::Rim);
        }
    }
    patch(&mut out, sides, positions);
    out.into_iter().map(|layer| layer.unwrap_or(Layer::Rim)).collect()
}

/// Gives connected sets of triangles without a layer that of the sheet that surrounds them.
fn patch(layers: &mut [Option<Layer>], sides: &Sides, positions: &[[f64; 3]]) {
    let mut patches = DisjointSets::new(layers.len());
    for e in &sides.edges {
        let [a, b] = e.triangles;
        if layers[a as usize].is_none() && layers[b as usize].is_none() {
            patches.union(a, b);
        }
    }
    let mut borders = vec![[0.0; 2]; layers.len()];
    for e in &sides.edges {
        for [t, u] in [e.triangles, [e.triangles[1], e.triangles[0]]] {
            let (None, Some(layer)) = (layers[t as usize], layers[u as usize]) else { continue };
            let [a, b] = e.vertices.map(|v| positions[v as usize]);
            let at = patches.find(t) as usize;
            match layer {
                Layer::First => borders[at][0] += distance(a, b),
                Layer::Second => borders[at][1] += distance(a, b),
                Layer::Rim => {}
            }
        }
    }
    for t in 0..layers.len() as u32 {
        let [first, second] = borders[patches.find(t) as usize];
        let layer = &mut layers[t as usize];
        if layer.is_none() && first > MOSTLY * second {
            *layer = Some(Layer::First);
        } else if layer.is_none() && second > MOSTLY * first {
            *layer = Some(Layer::Second);
        }
    }
}
