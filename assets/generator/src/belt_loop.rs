//! A belt loop: a flat tube between two holes of one panel. It uses up both holes, so the surface gets a handle and no
//! new boundary.

use crate::math::{V2, V3, add, cross, lerp, norm, scale, sub, unit};
use crate::panel::PanelMesh;
use crate::sew::Garment;

/// The middle of the loop on the front left panel, and the size of its holes.
const LOOP: V2 = [0.090, 1.012];
const HOLE: V2 = [0.034, 0.011];
/// How far apart the centres of the two holes are.
const SPAN: f64 = 0.054;

/// The two holes, the upper one first.
pub fn holes() -> Vec<Vec<V2>> {
    vec![hole(LOOP[1] + SPAN / 2.0), hole(LOOP[1] - SPAN / 2.0)]
}

/// A clockwise rectangle with two segments across and one down, starting at its top left corner.
fn hole(y: f64) -> Vec<V2> {
    let (w, h) = (HOLE[0] / 2.0, HOLE[1] / 2.0);
    [[-w, h], [0.0, h], [w, h], [w, -h], [0.0, -h], [-w, -h]].iter().map(|q| [q[0] + LOOP[0], q[1] + y]).collect()
}

/// Bridges the two holes of a panel with a tube that arches over the cloth.
pub fn sew_on(g: &mut Garment, panel: usize) {
    let ring = |k: usize| g.panels[panel].holes[k].iter().map(|&i| g.particle[panel][i]).collect::<Vec<_>>();
    let (top, low) = (ring(0), ring(1));
    // Points at the top of the upper hole meet points at the bottom of the lower one.
    let bottom: Vec<usize> = [5, 4, 3, 2, 1, 0].iter().map(|&k| low[k]).collect();
    let x = |i: usize| g.x[i];
    let out = unit(cross(sub(x(top[2]), x(low[0])), sub(x(top[0]), x(low[2]))));
    let steps = 7;
    let mut rings = vec![top.clone()];
    let mut places = g.x.clone();
    for s in 1..steps {
        let t = s as f64 / steps as f64;
        let arch = |k: usize| {
            // The upper side of the strap arches higher than the one next to the cloth.
            let high = if k < 3 { 0.020 } else { 0.010 };
            add(lerp(x(top[k]), x(bottom[k]), ease(t)), scale(out, high * 4.0 * t * (1.0 - t)))
        };
        rings.push((0..6).map(|k| places.len() + k).collect());
        places.extend((0..6).map(arch));
    }
    rings.push(bottom);
    g.x = places;
    g.panels.push(strip(&g.x, &rings));
    g.particle.push(rings.iter().flat_map(|r| (0..=6).map(|k| r[k % 6])).collect());
}

/// Leaves the ends steeply, so that the strap stands off the cloth.
fn ease(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t) * 0.6 + t * 0.4
}

/// The tube unrolled: seven columns, the last one sewn to the first.
fn strip(x: &[V3], rings: &[Vec<usize>]) -> PanelMesh {
    let gap = |a: usize, b: usize| norm(sub(x[a], x[b]));
    let across: Vec<f64> = (0..6).map(|k| rings.iter().map(|r| gap(r[k], r[(k + 1) % 6])).sum::<f64>()).collect();
    let mut points: Vec<V2> = Vec::new();
    let mut down = 0.0;
    for (j, r) in rings.iter().enumerate() {
        if j > 0 {
            down -= (0..6).map(|k| gap(r[k], rings[j - 1][k])).sum::<f64>() / 6.0;
        }
        let mut u = 0.0;
        for k in 0..=6 {
            points.push([u, down]);
            u += across[k % 6] / rings.len() as f64;
        }
    }
    let mut triangles = Vec::new();
    for j in 0..rings.len() - 1 {
        for k in 0..6 {
            let (a, b) = (j * 7 + k, j * 7 + k + 1);
            let (c, d) = (a + 7, b + 7);
            let [pa, pb, pc, pd] = [a, b, c, d].map(|i| x[rings[i / 7][(i % 7) % 6]]);
            // Split along the shorter diagonal.
            if norm(sub(pb, pc)) < norm(sub(pa, pd)) {
                triangles.extend([[b, a, c], [b, c, d]]);
            } else {
                triangles.extend([[b, a, d], [a, c, d]]);
            }
        }
    }
    PanelMesh { points, triangles, edges: vec![], holes: vec![] }
}
