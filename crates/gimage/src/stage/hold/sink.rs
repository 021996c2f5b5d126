//! Cloth that joints take into the body around its pins, as a cape at the shoulder when the arm hangs. It is pinned as well: beside pins that are inside, contact would push it
//! out, as far as springs stretch.

use rayon::prelude::*;

use super::motion::Motion;
use super::sheet::Sheet;
use crate::base::mesh::Mesh;
use crate::stage::assemble::Piece;
use crate::stage::assemble::attributes;

/// Depth \[m\] from which cloth is taken into the body.
const SUNK_M: f64 = 0.002;

/// A garment on a body that moves.
pub(super) struct Worn<'a> {
    pub motion: &'a Motion<'a>,
    /// The joints of each point, and their weights.
    pub influences: Vec<([f32; 4], [f32; 4])>,
}

/// The joints that each point of a garment follows: those of its last texel.
pub(super) fn influences(mesh: &Mesh, pieces: &[Piece<'_>], sheet: &Sheet) -> Vec<([f32; 4], [f32; 4])> {
    let mut all = vec![([0.0; 4], [0.0; 4]); sheet.positions.len()];
    for (piece, points) in pieces.iter().zip(&sheet.points) {
        let own = attributes::influences(mesh, &piece.image, &piece.surface);
        points.iter().zip(own).for_each(|(p, own)| all[*p as usize] = own);
    }
    all
}

/// Pins the points within limits \[m\] that are connected with a pin through points which some pose takes more than 2 mm into the body; how many. Beyond the limits nothing is
/// pinned, as legs that walk into a cape would hold all of it. One search for the nearest triangle per limited point and pose until the point is found inside.
pub(super) fn sink(worn: &Worn, sheet: &Sheet, limits: &[f64], pinned: &mut [bool]) -> usize {
    let limited = (0..pinned.len()).filter(|&p| !pinned[p] && limits[p].is_finite());
    let mut points: Vec<(usize, bool)> = limited.map(|p| (p, false)).collect();
    for posed in worn.motion.poses() {
        points.par_iter_mut().filter(|(_, is_sunk)| !is_sunk).for_each(|(p, is_sunk)| {
            *is_sunk = posed.is_deeper(posed.place(&worn.influences[*p], sheet.positions[*p]), SUNK_M);
        });
    }
    let mut is_sunk = vec![false; pinned.len()];
    points.iter().for_each(|(p, sunk)| is_sunk[*p] = *sunk);
    let mut open: Vec<u32> = (0..pinned.len() as u32).filter(|&p| pinned[p as usize]).collect();
    let mut added = 0;
    while let Some(p) = open.pop() {
        for q in sheet.neighbours(p) {
            if !pinned[q as usize] && is_sunk[q as usize] {
                pinned[q as usize] = true;
                added += 1;
                open.push(q);
            }
        }
    }
    added
}
