//! Newton steps on one part of a large map after another: the memory is that of a part, not of the whole.
//!
//! The free vertices of a tile of the plane move while all others stay, so that every step lowers the energy of the whole and
//! none flips a triangle (a multiplicative Schwarz method). Borders of tiles lie elsewhere in every round, so that a vertex held
//! back by one moves in the next. Errors must be short-range, as they are after the turns of a map that came from a coarse one.

use super::distortion::{Rest, energy};
use super::newton::{self, NewtonOptions, NewtonRecord};
use super::system::System;

/// Tile of a vertex that no tile moves.
const HELD: u32 = u32::MAX;
/// Newton steps of a tile in a round: its border stops further ones.
const STEPS: usize = 3;
/// Most rounds, if the work allows as many.
const ROUNDS: usize = 6;
/// A round that lowers the energy by less than this share of what it is above an isometry's is the last.
const FALLING: f64 = 0.01;

/// Lowers the energy of `uv` by rounds of Newton steps on tiles of about `part` triangles, of at most about `work` steps times
/// triangles in all but of one round at least. Of `options` the number of steps counts. The steps recorded are, for each round,
/// those of the tile that took most. O(triangles) a round and the steps.
pub(super) fn minimise(
    triangles: &[[u32; 3]],
    rest: &[Rest],
    fixed: &[bool],
    uv: &mut [[f64; 2]],
    (part, work): (usize, usize),
    options: &NewtonOptions,
) -> NewtonRecord {
    let mut now = energy(rest, triangles, uv);
    let mut record = NewtonRecord { steps: 0, start: now, end: now, converged: false, capped: false };
    if !now.is_finite() || options.steps == 0 {
        return record;
    }
    let options = NewtonOptions { steps: STEPS.min(options.steps), further: 0, tolerance: FALLING };
    let least: f64 = 4.0 * rest.iter().map(|r| r.weight).sum::<f64>();
    let mut free: Vec<u32> = (0..fixed.len() as u32).filter(|&v| !fixed[v as usize]).collect();
    let tiles = triangles.len().div_ceil(part.max(1)).next_power_of_two();
    let rounds = (work / (STEPS * triangles.len()).max(1)).clamp(1, ROUNDS);
    let mut tile_of = vec![HELD; fixed.len()];
    for round in 0..rounds {
        share(&mut free, uv, tiles, round, &mut tile_of);
        let mut most = 0;
        for (tile, chosen) in members(triangles, &tile_of, tiles).into_iter().enumerate() {
            most = most.max(one((triangles, rest), &chosen, |v| tile_of[v as usize] == tile as u32, uv, &options));
        }
        record.steps += most;
        record.end = energy(rest, triangles, uv);
        if now - record.end < FALLING * (now - least).max(1e-14 * now) {
            record.converged = record.steps > 0;
            return record;
        }
        now = record.end;
    }
    record.capped = true;
    record
}

/// The triangles with a free vertex in each tile, ascending.
fn members(triangles: &[[u32; 3]], tile_of: &[u32], tiles: usize) -> Vec<Vec<u32>> {
    let mut out = vec![Vec::new(); tiles];
    for (t, &corners) in triangles.iter().enumerate() {
        let [a, b, c] = corners.map(|v| tile_of[v as usize]);
        for (k, tile) in [a, b, c].into_iter().enumerate() {
            let new = tile != HELD && (k < 1 || tile != a) && (k < 2 || tile != b);
            if new {
                out[tile as usize].push(t as u32);
            }
        }
    }
    out
}

/// Shares free vertices out to tiles 0, 1, ... by their places: halves of halves, across the longer side of each. In odd rounds
/// the first two cuts are at thirds, so that a tile has up to 16/9 of a share.
fn share(free: &mut [u32], uv: &[[f64; 2]], tiles: usize, round: usize, tile_of: &mut [u32]) {
    let mut next = 0;
    cut(free, uv, tiles, if round % 2 == 1 { 2 } else { 0 }, &mut next, tile_of);
}

fn cut(part: &mut [u32], uv: &[[f64; 2]], tiles: usize, thirds: usize, next: &mut u32, tile_of: &mut [u32]) {
    if tiles <= 1 || part.len() < 2 {
        part.iter().for_each(|&v| tile_of[v as usize] = *next);
        *next += 1;
        return;
    }
    let side = |c: usize| {
        let at = part.iter().map(|&v| uv[v as usize][c]);
        at.clone().fold(f64::NEG_INFINITY, f64::max) - at.fold(f64::INFINITY, f64::min)
    };
    let c = usize::from(side(1) > side(0));
    let middle = if thirds > 0 { part.len() / 3 } else { part.len() / 2 };
    part.select_nth_unstable_by(middle, |&a, &b| uv[a as usize][c].total_cmp(&uv[b as usize][c]).then(a.cmp(&b)));
    let (low, high) = part.split_at_mut(middle);
    let thirds = thirds.saturating_sub(1);
    cut(low, uv, tiles / 2, thirds, next, tile_of);
    cut(high, uv, tiles / 2, thirds, next, tile_of);
}

/// Newton steps of one tile, the `chosen` triangles, as a mesh of its own; how many there were.
fn one(
    (triangles, rest): (&[[u32; 3]], &[Rest]),
    chosen: &[u32],
    free: impl Fn(u32) -> bool,
    uv: &mut [[f64; 2]],
    options: &NewtonOptions,
) -> usize {
    let mut vertex: Vec<u32> = chosen.iter().flat_map(|&t| triangles[t as usize]).collect();
    vertex.sort_unstable();
    vertex.dedup();
    let number = |v: u32| vertex.binary_search(&v).unwrap_or_default() as u32;
    let own: Vec<[u32; 3]> = chosen.iter().map(|&t| triangles[t as usize].map(number)).collect();
    let own_rest: Vec<Rest> = chosen.iter().map(|&t| rest[t as usize]).collect();
    let held: Vec<bool> = vertex.iter().map(|&v| !free(v)).collect();
    let mut own_uv: Vec<[f64; 2]> = vertex.iter().map(|&v| uv[v as usize]).collect();
    let record = newton::minimise(&mut System::new(&own, &held), &own_rest, &own, &mut own_uv, options);
    vertex.iter().zip(&own_uv).for_each(|(&v, p)| uv[v as usize] = *p);
    record.steps
}

#[cfg(test)]
mod tests {
    use super::super::distortion::{flips, rest_shapes};
    use super::*;
    use crate::base::shapes;

    #[test]
    fn tiles_end_near_the_whole_and_flip_nothing() {
        let s = shapes::sheet(48, 48, shapes::Join::Open, shapes::Join::Open, |u, v| [u, v, 0.2 * u * v]);
        let fixed = shapes::rim(&s);
        let n = fixed.len();
        // Waves that are shorter than a tile and bend the map without a flip.
        let wave = |x: f64| (6.0 * std::f64::consts::PI * x).sin();
        let start: Vec<[f64; 2]> =
            s.positions.iter().map(|&[u, v, _]| [u + 0.03 * wave(u) * wave(v), v - 0.03 * wave(u) * wave(v)]).collect();
        let rest = rest_shapes(&s.positions, &s.triangles, &vec![1.0; n], 1.0);
        assert_eq!(flips(&s.triangles, &start), 0);
        let (mut whole, mut parts, mut again) = (start.clone(), start.clone(), start.clone());
        let options = NewtonOptions::default();
        let best = newton::minimise(&mut System::new(&s.triangles, &fixed), &rest, &s.triangles, &mut whole, &options);
        let record = minimise(&s.triangles, &rest, &fixed, &mut parts, (700, 10_000_000), &options);
        assert_eq!(flips(&s.triangles, &parts), 0);
        assert!((0..n).all(|v| !fixed[v] || parts[v] == start[v]), "the boundary moved");
        assert!(best.start > 1.1 * best.end && record.start == best.start, "{best:?}");
        let left = (record.end - best.end) / (best.start - best.end);
        assert!(left < 0.02, "{left} of the fall is left: {record:?} {best:?}");
        minimise(&s.triangles, &rest, &fixed, &mut again, (700, 10_000_000), &options);
        assert!(parts == again, "not the same bits twice");
        // Each free vertex is in one tile, of at most 16/9 of a share where cuts are at thirds.
        for (round, most) in [(0, 8), (1, 4)] {
            let mut free: Vec<u32> = (0..n as u32).filter(|&v| !fixed[v as usize]).collect();
            let mut tile_of = vec![HELD; n];
            share(&mut free, &start, 8, round, &mut tile_of);
            let count = |tile| tile_of.iter().filter(|&&t| t == tile).count();
            assert_eq!(count(HELD), n - free.len());
            let fair = free.len() / 20..=free.len().div_ceil(most);
            assert!((0..8).all(|tile| fair.contains(&count(tile))), "round {round}");
            let members = members(&s.triangles, &tile_of, 8);
            let inside = |t: &u32, tile: u32| s.triangles[*t as usize].iter().any(|&v| tile_of[v as usize] == tile);
            for (tile, list) in (0..).zip(&members) {
                assert!(list.windows(2).all(|w| w[0] < w[1]) && list.iter().all(|t| inside(t, tile)));
                assert_eq!(list.len(), (0..s.triangles.len() as u32).filter(|t| inside(t, tile)).count());
            }
        }
    }

    #[test]
    fn without_a_free_vertex_or_a_step_nothing_moves_and_nothing_converges() {
        let s = shapes::rectangle(2, 1, 1.0, 1.0);
        let rest = rest_shapes(&s.positions, &s.triangles, &vec![1.0; s.positions.len()], 2.0);
        let start: Vec<[f64; 2]> = s.positions.iter().map(|p| [p[0], p[1]]).collect();
        let (fixed, mut uv) = (vec![true; start.len()], start.clone());
        let record = minimise(&s.triangles, &rest, &fixed, &mut uv, (1, 100), &NewtonOptions::default());
        assert!(uv == start && record.steps == 0 && !record.converged && !record.capped, "{record:?}");
        let none = NewtonOptions { steps: 0, ..NewtonOptions::default() };
        let free = vec![false; start.len()];
        assert_eq!(minimise(&s.triangles, &rest, &free, &mut uv, (1, 100), &none).steps, 0);
        assert!(uv == start);
    }
}
