//! Corners of a garment's own boundary: nodes too, so that they keep their shape and can be corners of the image.

use crate::base::vec3::{cross, distance, dot, norm, sub};
use crate::stage::cut::disk::Disk;

/// How far the boundary turns at a corner, at least \[rad\].
const SHARP: f64 = 0.9;
/// Most corners marked, the sharpest first.
const MOST: usize = 16;
/// Least distance between nodes, as a share of the loop.
const APART: f64 = 0.02;

/// Marks the sharp corners of the parts of the loop that are not cut.
pub(super) fn mark(disk: &Disk, node: &mut [bool]) {
    let n = disk.boundary.len();
    let mut angle = vec![0.0; disk.positions.len()];
    for t in &disk.triangles {
        for k in 0..3 {
            let [a, b, c] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]].map(|v| disk.positions[v as usize]);
            let (u, v) = (sub(b, a), sub(c, a));
            angle[t[k] as usize] += norm(cross(u, v)).atan2(dot(u, v));
        }
    }
    let mut at = vec![0.0; n + 1];
    for i in 0..n {
        let (a, b) = (disk.boundary[i] as usize, disk.boundary[(i + 1) % n] as usize);
        at[i + 1] = at[i] + distance(disk.positions[a], disk.positions[b]);
    }
    let total = at[n];
    let mut sharp: Vec<(f64, usize)> = (0..n)
        .filter(|&i| !disk.on_cut[i] && !disk.on_cut[(i + n - 1) % n] && !node[i])
        .map(|i| ((angle[disk.boundary[i] as usize] - std::f64::consts::PI).abs(), i))
        .filter(|x| x.0 > SHARP)
        .collect();
    sharp.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut taken: Vec<f64> = (0..n).filter(|&i| node[i]).map(|i| at[i]).collect();
    let mut marked = 0;
    for (_, i) in sharp {
        let far = |&x: &f64| {
            let d = (at[i] - x).abs();
            d.min(total - d) > APART * total
        };
        if marked < MOST && taken.iter().all(far) {
            node[i] = true;
            taken.push(at[i]);
            marked += 1;
        }
    }
}
