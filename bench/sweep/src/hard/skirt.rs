//! A garment of a size and a state that artists hand over: a pleated skirt of loose panels, with dirt.

use std::f64::consts::TAU;

use crate::random::Random;
use crate::shape::Shape;

/// Its name in tables.
pub const NAME: &str = "dirty-skirt";

/// Tiers from waist to hem.
const TIERS: usize = 3;
/// Knife pleats around; each is a panel of every tier.
const PLEATS: usize = 320;
/// Distance of vertices of two panels that are one on the garment \[m\], at most; a weld of 0.1 mm joins them.
const APART: f64 = 4e-5;

/// A skirt of about `triangles` triangles in 960 panels that share no vertex. Half a percent of the triangles are wound the wrong
/// way; one in 600 each is there twice, has a copy without area, or has a fin; twelve are missing.
pub fn skirt(seed: u64, triangles: usize) -> Shape {
    let mut random = Random::new(seed, 0);
    let cells = (triangles as f64 / (2 * TIERS * PLEATS) as f64).max(4.0);
    // Cells are higher than wide.
    let across = 2 * ((0.3 * cells).sqrt().round() as usize).max(1);
    let down = (cells / across as f64).round().max(1.0) as usize;
    let mut out = Shape::default();
    for panel in 0..TIERS * PLEATS {
        let (tier, pleat) = (panel / PLEATS, panel % PLEATS);
        let sheet = Shape::sheet(across, down, |u, v| {
            let along = (tier as f64 + v) / TIERS as f64;
            let angle = TAU * (pleat as f64 + u) / PLEATS as f64;
            // Out and back within a pleat, deeper towards the hem.
            let fold = (0.006 + 0.016 * along) * (1.0 - (2.0 * u - 1.0).abs());
            let radius = 0.13 + 0.3 * along + fold;
            [radius * angle.cos(), 1.0 - 0.75 * along, radius * angle.sin()]
        });
        out.join(&sheet.moved(|p| p.map(|x| x + random.within(-0.25, 0.25) * APART)));
    }
    dirty(&mut random, &mut out);
    out
}

fn dirty(random: &mut Random, s: &mut Shape) {
    let n = s.triangles.len();
    for _ in 0..12 {
        let at = random.below(n);
        s.triangles[at] = [0; 3];
    }
    for k in 0..n {
        if random.chance(0.005) {
            s.triangles[k].swap(1, 2);
        }
        let [a, b, _] = s.triangles[k];
        match random.below(600) {
            0 => s.triangles.push(s.triangles[k]),
            1 => s.triangles.push([a, b, b]),
            2 => {
                let tip = s.positions[a as usize].map(|x| x + random.within(-0.004, 0.004));
                s.positions.push(tip);
                s.triangles.push([a, b, s.positions.len() as u32 - 1]);
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gimage::topology::Topology;

    #[test]
    fn a_skirt_has_its_size_its_panels_and_its_dirt() {
        let s = skirt(1, 200_000);
        assert!((190_000..215_000).contains(&s.triangles.len()), "{}", s.triangles.len());
        assert_eq!(s, skirt(1, 200_000));
        let flat = s.triangles.iter().filter(|t| t[0] == t[1] || t[1] == t[2] || t[2] == t[0]).count();
        assert!(flat > 200, "{flat} triangles without an area");
        let sound: Vec<[u32; 3]> =
            s.triangles.iter().filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]).copied().collect();
        let Topology { misoriented_edges, non_manifold_edges, components, .. } = Topology::of(&sound);
        assert_eq!(components, TIERS * PLEATS);
        assert!(misoriented_edges > 1000 && non_manifold_edges > 200, "{misoriented_edges} {non_manifold_edges}");
    }
}
