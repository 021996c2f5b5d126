//! Cloth that joints take into the body around its pins, as a cape at the shoulder when the arm hangs. It is pinned as well: beside pins that are inside, contact would push it
//! out, as far as springs stretch.

use rayon::prelude::*;

use super::motion::Motion;
use super::sheet::Sheet;
use super::{Garment, rest, spread};
use crate::base::mesh::Mesh;
use crate::stage::assemble::Piece;
use crate::stage::assemble::attributes;

/// Depth \[m\] from which cloth is taken into the body.
const SUNK_M: f64 = 0.002;

/// The joints that each point of a garment follows, and their weights: those of its first texel.
pub(super) fn influences(mesh: &Mesh, pieces: &[Piece<'_>], sheet: &Sheet) -> Vec<([f32; 4], [f32; 4])> {
    let mut all = vec![([0.0; 4], [0.0; 4]); sheet.positions.len()];
    for (piece, points) in pieces.iter().zip(&sheet.points).rev() {
        let own = attributes::influences(mesh, &piece.image, &piece.surface);
        points.iter().zip(own).rev().for_each(|(p, own)| all[*p as usize] = own);
    }
    all
}

/// Pins the points within limits that are connected with a pin through points which some pose takes more than 2 mm into the body, unless more than half of the garment would be
/// pinned. Beyond the limits nothing is, as legs that walk into a cape would hold all of it. The limits of other points stay.
pub(super) fn sink(motion: &Motion, garments: &mut [Garment]) {
    // The limited points of each garment, and whether they have been found inside.
    let limited = |g: &Garment| {
        let points = (0..g.pinned.len()).filter(|&p| !g.pinned[p] && g.limits[p].is_finite());
        points.map(|p| (p, false)).collect::<Vec<_>>()
    };
    let mut points: Vec<_> = garments.iter().map(limited).collect();
    for posed in motion.poses() {
        if points.iter().flatten().all(|(_, is_sunk)| *is_sunk) {
            break;
        }
        for (points, g) in points.iter_mut().zip(&*garments) {
            points.par_iter_mut().filter(|(_, is_sunk)| !is_sunk).for_each(|(p, is_sunk)| {
                *is_sunk = posed.is_deeper(posed.place(&g.influences[*p], g.sheet.positions[*p]), SUNK_M);
            });
        }
    }
    for (points, g) in points.iter().zip(garments) {
        let mut is_sunk = vec![false; g.pinned.len()];
        points.iter().for_each(|(p, sunk)| is_sunk[*p] = *sunk);
        let (pinned, added) = grown(&g.sheet, &g.pinned, &is_sunk);
        if spread::share(&g.sheet, &pinned) <= rest::MOST {
            (g.pinned, g.sunk) = (pinned, added);
            g.limits.iter_mut().zip(&g.pinned).filter(|x| *x.1).for_each(|(limit, _)| *limit = 0.0);
        }
    }
}

/// Pins, and the points that are connected with one through chosen points; how many these are.
fn grown(sheet: &Sheet, pinned: &[bool], is_chosen: &[bool]) -> (Vec<bool>, usize) {
    let (mut pinned, mut added) = (pinned.to_vec(), 0);
    let mut open: Vec<u32> = (0..pinned.len() as u32).filter(|&p| pinned[p as usize]).collect();
    while let Some(p) = open.pop() {
        for q in sheet.neighbours(p) {
            if !pinned[q as usize] && is_chosen[q as usize] {
                pinned[q as usize] = true;
                added += 1;
                open.push(q);
            }
        }
    }
    (pinned, added)
}
