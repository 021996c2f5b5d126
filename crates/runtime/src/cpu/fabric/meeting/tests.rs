use super::patrol::{MAX_SUSPECTS, ROUND};
use super::tiles::{SIDE, corner};
use super::*;
use crate::cloth::{Cloth, ClothContact, Flat, SKIPPED_CELLS};
use crate::cpu::fabric::partners::{MAX_PARTNERS, REST_SHARE};
use crate::number::real::{dot, sub};

/// -1 to 1, the same for the same numbers.
pub fn noise(k: usize, of: usize) -> f32 {
    let mut x = (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (of as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 31)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^= x >> 29;
    ((x >> 11) as f64 / (1u64 << 52) as f64 - 1.0) as f32
}

fn cloth(n: u32) -> Cloth {
    let mut cloth = Flat::square("sheet", n).cloth().unwrap();
    cloth.contact = Some(ClothContact::default());
    cloth.set_pinned(5, true).unwrap();
    cloth
}

/// A square that is squeezed, waved and shaken, by a number; it has moved by up to `way` \[m\] in the last step.
fn crumpled(cloth: &Cloth, seed: usize, way: f32) -> Vec<Sheet<f32>> {
    let [squeeze, wave, shake] = [0, 1, 2].map(|of| 0.5 + 0.5 * noise(seed, of));
    let mut sheets: Vec<Sheet<f32>> = cloth.grids().iter().map(Sheet::new).collect();
    let at = |k: usize, p: &[f32; 3]| {
        let around = 12.0 * p[0] * (1.0 - squeeze);
        let bent = [squeeze * p[0] + 0.1 * around.sin(), p[1] * (1.0 - 0.9 * wave), 0.1 * around.cos()];
        [0, 1, 2].map(|c| bent[c] + 0.03 * shake * noise(k, 3 + c))
    };
    let now: Vec<[f32; 4]> =
        cloth.positions().iter().enumerate().map(|(k, p)| at(k, p)).map(|[x, y, z]| [x, y, z, 1.0]).collect();
    let was = |(k, p): (usize, &[f32; 4])| [0, 1, 2, 3].map(|c| p[c] + way * noise(k, seed + c));
    let before: Vec<_> = now.iter().enumerate().map(was).collect();
    sheets[0].load(&now, &before);
    sheets[0].weigh(|k| if cloth.particles()[k].is_pinned() { 0.0 } else { 1.0 });
    sheets
}

fn searched(cloth: &Cloth, sheets: &[Sheet<f32>]) -> Meeting<f32> {
    let mut meeting = Meeting::of(cloth, sheets, 0.0).unwrap();
    meeting.leaves(sheets);
    meeting.refit();
    meeting.search(&Threads::one());
    meeting
}

/// The partners of a particle by comparison with all others, the nearest first.
fn partners_of(meeting: &Meeting<f32>, place: usize) -> Vec<u32> {
    let (tiles, reach) = (&meeting.tiles, &meeting.tree.reach);
    let cell = |place: usize| {
        let (spot, [i, j]) = (tiles.spots[place / LANES_OF_TILE], corner(place % LANES_OF_TILE));
        [spot.column as usize * SIDE + i, spot.row as usize * SIDE + j]
    };
    let mut found = Vec::new();
    for other in (0..tiles.texel.len()).filter(|other| tiles.texel[*other] != u32::MAX) {
        let (a, b) = (cell(place), cell(other));
        let way = sub(tiles.now(other), tiles.now(place));
        let rest = sub(Tiles::at(&tiles.rest, place), Tiles::at(&tiles.rest, other));
        let least = meeting.distance.min(dot(rest, rest).sqrt() * REST_SHARE as f32);
        let reach = reach[place / LANES_OF_TILE] + reach[other / LANES_OF_TILE];
        let close = a[0].abs_diff(b[0]).max(a[1].abs_diff(b[1])) <= SKIPPED_CELLS;
        if !close && dot(way, way).sqrt() < least + reach {
            found.push((dot(way, way), other as u32));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    found.into_iter().map(|(_, other)| other).take(MAX_PARTNERS).collect()
}

/// The place of a partner of a particle.
fn partner(meeting: &Meeting<f32>, tile: usize, (slot, lane): (usize, usize)) -> u32 {
    let rows = meeting.tiles.lane_rows;
    let row = meeting.lists[tile].partner[slot * LANES_OF_TILE + rows[lane]] as usize;
    let there = rows.iter().position(|of| *of == row % LANES_OF_TILE).unwrap();
    (row / LANES_OF_TILE * LANES_OF_TILE + there) as u32
}

#[test]
fn partners_are_those_of_a_comparison_of_all_with_all() {
    for (seed, n) in (0..24).zip([5, 9, 14, 22].into_iter().cycle()) {
        let cloth = cloth(n);
        let meeting = searched(&cloth, &crumpled(&cloth, seed, 0.004));
        let mut some = 0;
        for place in (0..meeting.tiles.texel.len()).filter(|place| meeting.tiles.texel[*place] != u32::MAX) {
            let (list, lane) = (&meeting.lists[place / LANES_OF_TILE], place % LANES_OF_TILE);
            let slots = (0..list.count as usize).map(|slot| partner(&meeting, place / LANES_OF_TILE, (slot, lane)));
            let found: Vec<u32> = slots.filter(|other| *other as usize != place).collect();
            let pinned = meeting.tiles.blocks[place / LANES_OF_TILE].w[lane] == 0.0;
            let expected = if pinned { Vec::new() } else { partners_of(&meeting, place) };
            assert_eq!(found, expected, "crumpled {seed}, place {place}");
            some += expected.len();
        }
        assert!(some > 0, "{seed}");
    }
}

#[test]
fn vectors_out_of_reach_are_skipped_without_a_change_of_bits() {
    for seed in 0..12 {
        let cloth = cloth(22);
        let mut meeting = searched(&cloth, &crumpled(&cloth, seed, 0.0));
        let mut moved = crumpled(&cloth, seed, 0.0);
        moved[0].now.iter_mut().enumerate().for_each(|(k, x)| *x += 0.0005 * noise(k, 9));
        let run = |meeting: &mut Meeting<f32>| {
            meeting.touch(&moved, &Threads::one(), 0.002);
            let pushed = meeting.lists.iter().filter(|list| list.moves);
            pushed.flat_map(|list| list.change.as_flattened().iter().map(|x| x.to_bits())).collect::<Vec<_>>()
        };
        let skipped = run(&mut meeting);
        meeting.lists.iter_mut().for_each(|list| list.spare = [-1.0; MAX_PARTNERS]);
        assert!(!skipped.is_empty());
        assert_eq!(run(&mut meeting), skipped, "{seed}");
    }
}

#[test]
fn lists_hold_while_cloth_moves_as_a_whole_and_no_longer_where_one_particle_leaves_it() {
    let cloth = cloth(22);
    let here = crumpled(&cloth, 3, 0.0);
    let mut meeting = searched(&cloth, &here);
    let reach = meeting.tree.reach[0];
    let gone = |way: [f32; 3], farther: f32| {
        let mut sheets = crumpled(&cloth, 3, 0.0);
        let at = |k: usize, p: &[f32; 4]| [0, 1, 2].map(|c| p[c] + way[c] + if k == 40 { farther } else { 0.0 });
        let [mut now, mut before] = [0, 1].map(|_| vec![[0.0; 4]; cloth.len()]);
        sheets[0].store(&mut now, &mut before);
        let now: Vec<_> = now.iter().enumerate().map(|(k, p)| at(k, p)).map(|[x, y, z]| [x, y, z, 1.0]).collect();
        let before: Vec<_> = now.iter().map(|p| [p[0] - 0.02, p[1] + 0.03, p[2], 1.0]).collect();
        sheets[0].load(&now, &before);
        sheets[0].weigh(|k| if cloth.particles()[k].is_pinned() { 0.0 } else { 1.0 });
        sheets
    };
    for (way, farther, holds) in
        [([0.0; 3], 0.0, true), ([4.0, -2.0, 1.0], 0.0, true), ([4.0, -2.0, 1.0], 3.0 * reach, false)]
    {
        meeting.tiles.load_all(&gone(way, farther));
        assert_eq!(drift::holds(&meeting.tree, &meeting.tiles), holds, "{way:?} {farther}");
    }
}

#[test]
fn vectors_are_skipped_without_a_change_of_bits_while_cloth_moves_as_a_whole() {
    let cloth = cloth(22);
    for seed in 0..6 {
        let mut meeting = searched(&cloth, &crumpled(&cloth, seed, 0.0));
        let mut sheets = crumpled(&cloth, seed, 0.0);
        for step in 1..6 {
            // Half a millimetre of its own, two centimetres with all others.
            sheets[0].now.iter_mut().enumerate().for_each(|(k, x)| *x += 0.02 + 0.0005 * noise(k, 9 + step));
            let run = |meeting: &mut Meeting<f32>| {
                meeting.touch(&sheets, &Threads::one(), 0.002);
                let pushed = meeting.lists.iter().filter(|list| list.moves);
                pushed.flat_map(|list| list.change.as_flattened().iter().map(|x| x.to_bits())).collect::<Vec<_>>()
            };
            // The first time the common motion is that of the step before.
            assert_eq!(run(&mut meeting), run(&mut meeting), "{seed}, step {step}");
            let skipped = run(&mut meeting);
            let tiles = meeting.active.iter().map(|tile| meeting.tree.drift.moved(*tile as usize));
            let moved = tiles.fold(0.0, f32::max);
            assert!(moved < 0.02, "{seed}, step {step}: {moved} m");
            let spares: Vec<_> = meeting.lists.iter().map(|list| list.spare).collect();
            meeting.lists.iter_mut().for_each(|list| list.spare = [-1.0; MAX_PARTNERS]);
            assert!(!skipped.is_empty());
            assert_eq!(run(&mut meeting), skipped, "{seed}, step {step}");
            meeting.lists.iter_mut().zip(spares).for_each(|(list, spare)| list.spare = spare);
        }
    }
}

#[test]
fn shares_of_pushes_follow_inverse_masses_that_change_while_lists_hold() {
    let cloth = cloth(14);
    let mut sheets = crumpled(&cloth, 2, 0.0);
    let mut meeting = searched(&cloth, &sheets);
    let w = |k: usize| 1.0 + (k % 3) as f32;
    sheets[0].weigh(w);
    meeting.leaves(&sheets);
    meeting.refit();
    meeting.search(&Threads::one());
    let mut pairs = 0;
    for (tile, list) in meeting.lists.iter().enumerate() {
        for at in (0..list.count as usize * LANES_OF_TILE).filter(|at| list.least[*at] > 0.0) {
            let of = |place: usize| w(meeting.tiles.texel[place] as usize);
            let lane = at % LANES_OF_TILE;
            let (own, other) =
                (of(tile * LANES_OF_TILE + lane), of(partner(&meeting, tile, (at / LANES_OF_TILE, lane)) as usize));
            assert_eq!(list.own[at], own / (own + other), "tile {tile}, {at}");
            pairs += 1;
        }
    }
    assert!(pairs > 0);
}

#[test]
fn a_round_of_looks_finds_all_particles_that_are_too_near() {
    let mut compared = 0;
    for (seed, n) in (0..12).zip([9usize, 14, 22].into_iter().cycle()) {
        let cloth = cloth(n as u32);
        let sheets = crumpled(&cloth, seed, 0.0);
        let mut meeting = searched(&cloth, &sheets);
        let (mut found, mut full) = (Vec::new(), vec![false; meeting.tiles.count()]);
        for _ in 0..ROUND {
            meeting.begin_patrol();
            meeting.leaves(&sheets);
            meeting.search(&Threads::one());
            let patrol = meeting.patrol.as_ref().unwrap();
            found.extend(patrol.suspects.iter().map(|suspect| [suspect.place, suspect.other]));
            if patrol.suspects.len() == MAX_SUSPECTS {
                (0..full.len()).filter(|tile| patrol.has(*tile)).for_each(|tile| full[tile] = true);
            }
        }
        found.sort_unstable();
        let tiles = &meeting.tiles;
        let there: Vec<usize> = (0..tiles.texel.len()).filter(|place| tiles.texel[*place] != u32::MAX).collect();
        for (k, a) in there.iter().enumerate().filter(|(_, a)| !full[**a / LANES_OF_TILE]) {
            for b in &there[k + 1..] {
                let (p, q) = (tiles.texel[*a] as usize, tiles.texel[*b] as usize);
                let close = (p % n).abs_diff(q % n).max((p / n).abs_diff(q / n)) <= SKIPPED_CELLS;
                let (way, h) = (sub(tiles.now(*b), tiles.now(*a)), 1.0 / (n - 1) as f32);
                if !close && dot(way, way) < 0.999 * h * h {
                    compared += 1;
                    let pair = [*a as u32, *b as u32];
                    assert!(found.binary_search(&pair).is_ok(), "{seed}: {pair:?} of {} pairs", found.len());
                }
            }
        }
    }
    assert!(compared > 100, "{compared} pairs in frames that do not find too many");
}
