use super::*;
use crate::cloth::{Cloth, Flat};
use crate::cpu::truncation::surface::Source;
use crate::crossings::{self, Drawn};

/// Cloths as they start, in layers.
fn tangled(cloths: &[Cloth], layers: &[i32]) -> Untangle {
    let sources: Vec<_> = cloths.iter().enumerate().map(|(index, cloth)| Source { index, cloth, holes: &[] }).collect();
    let spacing = f64::from(cloths[0].spacing());
    let mut untangle = Untangle::new(Surface::new(&sources), spacing, |cloth| layers[cloth as usize]);
    for point in 0..untangle.surface.count() {
        let texel = untangle.surface.of_point(point)[0];
        untangle.at[point] = cloths[texel.cloth as usize].positions()[texel.particle as usize].map(f64::from);
    }
    untangle
}

/// The point of each texel of the surface.
fn points_of(untangle: &Untangle) -> Vec<usize> {
    let surface = &untangle.surface;
    (0..surface.count()).flat_map(|point| surface.of_point(point).iter().map(move |_| point)).collect()
}

/// A look at points where they are.
fn look(untangle: &mut Untangle) -> usize {
    let at = untangle.at.clone();
    let points = points_of(untangle);
    untangle.look(|first, _| at[points[first]]).hits
}

/// A square of 1 m, and one that it crosses along a line at a share of its length: beyond it the second one is above. Both have their front above.
fn two(share: f32) -> Vec<Cloth> {
    let flat = Flat { origin: [-0.011, 0.0, 0.993], down: [0.0, 0.0, -1.0], ..Flat::square("flat", 12) };
    let mut tilted = Flat { origin: [0.0, 0.0, 1.0], down: [0.0, 0.0, -1.0], ..Flat::square("tilted", 12) };
    (tilted.origin[1], tilted.right[1]) = (-0.2 * share, 0.2);
    vec![flat.cloth().unwrap(), tilted.cloth().unwrap()]
}

fn verdicts(untangle: &mut Untangle) -> Vec<Option<side::Verdict>> {
    let hits = untangle.finder.find(&untangle.surface, &untangle.net, &untangle.at);
    let mut flood = side::Flood::new(untangle, &hits);
    let contours = contour::contours(&untangle.net, &hits);
    contours.iter().map(|contour| side::verdict(untangle, &mut flood, &hits, contour)).collect()
}

#[test]
fn two_squares_cross_along_one_contour_whose_sheets_are_the_cloths() {
    let mut untangle = tangled(&two(0.3), &[0, 0]);
    let hits = untangle.finder.find(&untangle.surface, &untangle.net, &untangle.at);
    let contours = contour::contours(&untangle.net, &hits);
    assert_eq!(contours.len(), 1);
    let mut firsts = Vec::new();
    for on in &contours[0].hits {
        let cloth = |n: &u32| untangle.cloth(untangle.net.edges[hits[*n as usize].edge as usize][0]);
        let first = cloth(&on[0]);
        assert!(on.len() >= 11 && on.iter().all(|n| cloth(n) == first));
        firsts.push(first);
    }
    assert!(firsts.contains(&0) && firsts.contains(&1), "{firsts:?}");
    untangle.finder.thorough = true;
    assert_eq!(untangle.finder.find(&untangle.surface, &untangle.net, &untangle.at), hits);
}

#[test]
fn moves_make_the_crossings_vanish() {
    for (share, layers) in [(0.3, [0, 0]), (0.7, [0, 1]), (0.6, [0, 0])] {
        let cloths = two(share);
        let mut untangle = tangled(&cloths, &layers);
        let mut looks = 0;
        while look(&mut untangle) > 0 {
            assert!(looks < 600, "{share} {layers:?}");
            for (at, way) in untangle.at.iter_mut().zip(&untangle.moves) {
                *at = [0, 1, 2].map(|c| f64::from((at[c] + way[c]) as f32));
            }
            looks += 1;
        }
        let mut now: Vec<Vec<[f32; 4]>> = cloths.iter().map(|cloth| vec![[0.0; 4]; cloth.len()]).collect();
        for (point, at) in untangle.at.iter().enumerate() {
            let texel = untangle.surface.of_point(point)[0];
            now[texel.cloth as usize][texel.particle as usize] = [at[0] as f32, at[1] as f32, at[2] as f32, 1.0];
        }
        let drawn: Vec<_> = cloths.iter().zip(&now).map(|(cloth, now)| Drawn::at(cloth, now)).collect();
        assert_eq!(crossings::find(&drawn, 0).unwrap().total(), 0, "{share} {layers:?}");
        assert!(untangle.loose.iter().all(|loose| !loose.any()) && looks > 0);
    }
}

#[test]
fn a_search_around_one_crossing_finds_the_whole_contour() {
    let mut untangle = tangled(&two(0.3), &[0, 0]);
    let all = untangle.finder.find(&untangle.surface, &untangle.net, &untangle.at);
    let (edge, face) = (untangle.net.edges[all[0].edge as usize], untangle.net.faces[all[0].face as usize]);
    untangle.search_around(edge.into_iter().chain(face));
    assert_eq!(look(&mut untangle), all.len());
    assert_eq!(untangle.region.as_ref().map(|region| region.cells.len() < untangle.surface.corners.len()), Some(true));
    // It knows from then on where cloth crosses, and still looks there once cloth is apart.
    assert_eq!(look(&mut untangle), all.len());
    let above = untangle.at.iter().map(|p| [p[0], p[1] + 1.0, p[2]]).collect::<Vec<_>>();
    let second = (0..above.len()).find(|point| untangle.cloth(*point as u32) == 1).unwrap();
    untangle.at[second..].copy_from_slice(&above[second..]);
    assert_eq!(look(&mut untangle), 0);
    assert_eq!(untangle.region.as_ref().map(|region| region.cells.is_empty()), Some(false));
    untangle.forget();
    assert_eq!(untangle.region.as_ref().map(|region| region.cells.len()), Some(0));
}

#[test]
fn a_contour_that_stays_is_left_alone_for_a_time() {
    let mut untangle = tangled(&two(0.3), &[0, 0]);
    untangle.gives_up = true;
    let mut moved = Vec::new();
    for _ in 0..10 {
        let at = untangle.at.clone();
        let points = points_of(&untangle);
        let found = untangle.look(|first, _| at[points[first]]);
        assert!(found.hits > 0);
        assert_eq!(found.is_moved, untangle.moves.iter().any(|way| *way != [0.0; 3]));
        moved.push(found.is_moved);
        untangle.pass(0.3);
    }
    // It stays for 1 s until it is left alone, and is moved again after 2 s.
    assert_eq!(moved, [true, true, true, true, false, false, false, true, true, true]);
    let mut again = Vec::new();
    for second in 3..140 {
        let at = untangle.at.clone();
        let points = points_of(&untangle);
        // Always in the middle of a second.
        untangle.pass(if second == 3 { 0.5 } else { 1.0 });
        again.extend(untangle.look(|first, _| at[points[first]]).is_moved.then_some(second));
    }
    // It had crossed for 3 s when the first of these looks began.
    assert_eq!(again, [4, 8, 16, 32, 64, 96, 128]);
}

#[test]
fn cloth_apart_is_left_alone() {
    let mut cloths = two(0.3);
    cloths[1] = Flat { origin: [0.0, 0.1, 0.0], ..Flat::square("above", 12) }.cloth().unwrap();
    let mut untangle = tangled(&cloths, &[0, 1]);
    assert_eq!(look(&mut untangle), 0);
    assert!(untangle.moves.iter().all(|way| *way == [0.0; 3]) && untangle.loose.iter().all(|loose| !loose.any()));
}

#[test]
fn the_smaller_part_without_pins_is_wrong_and_layers_decide_first() {
    let mut untangle = tangled(&two(0.3), &[0, 0]);
    let found = verdicts(&mut untangle);
    // The part of the second sheet at its left, behind the first one, or that of the first sheet, in front of the second one.
    let sheet_of = |cloth: usize, in_front: bool| Some(side::Verdict { sheet: cloth, in_front });
    assert!(found == [sheet_of(0, true)] || found == [sheet_of(1, false)], "{found:?}");
    // Pins in the left parts of both.
    for point in 0..untangle.at.len() {
        untangle.free[point] = untangle.at[point][0] > 0.1;
    }
    let found = verdicts(&mut untangle);
    assert!(found == [sheet_of(0, false)] || found == [sheet_of(1, true)], "{found:?}");
    let mut layered = tangled(&two(0.3), &[4, 2]);
    let found = verdicts(&mut layered);
    assert!(found[0].is_some_and(|verdict| !verdict.in_front), "{found:?}");
}

#[test]
fn a_contour_that_ends_in_both_sheets_decides_nothing_between_pins() {
    let mut cloths = two(0.3);
    // Half of each sheet is beside the other one.
    let mut beside = Flat { origin: [0.0, -0.06, 0.5], down: [0.0, 0.0, -1.0], ..Flat::square("beside", 12) };
    beside.right[1] = 0.2;
    cloths[1] = beside.cloth().unwrap();
    let mut untangle = tangled(&cloths, &[0, 0]);
    let found = verdicts(&mut untangle);
    assert!(found.len() == 1 && found[0].is_some(), "{found:?}");
    // Pins on the left and the right of both.
    for point in 0..untangle.at.len() {
        untangle.free[point] = (untangle.at[point][0] - 0.5).abs() < 0.4;
    }
    assert_eq!(verdicts(&mut untangle), [None]);
    // Pins at the corners of both, which the parts reach late.
    let corners: Vec<usize> = [0, 12 * 12].into_iter().flat_map(|first| [0, 11, 132, 143].map(|n| first + n)).collect();
    (0..untangle.at.len()).for_each(|point| untangle.free[point] = !corners.contains(&point));
    assert_eq!(verdicts(&mut untangle), [None]);
}

#[test]
fn a_short_contour_in_a_large_sheet_decides_nothing_and_looks_no_farther() {
    let large = Flat { origin: [0.0, 0.0, 1.0], down: [0.0, 0.0, -1.0], ..Flat::square("large", 60) }.cloth().unwrap();
    // It stands in the middle, half of it below.
    let small = Flat {
        origin: [0.45, -0.05, 0.503],
        right: [0.1, 0.0, 0.0],
        down: [0.0, 0.1, 0.0],
        ..Flat::square("small", 6)
    };
    let mut untangle = tangled(&[large, small.cloth().unwrap()], &[0, 0]);
    let hits = untangle.finder.find(&untangle.surface, &untangle.net, &untangle.at);
    let contours = contour::contours(&untangle.net, &hits);
    assert_eq!(contours.len(), 1);
    let mut flood = side::Flood::new(&untangle, &hits);
    let verdict = side::verdict(&untangle, &mut flood, &hits, &contours[0]);
    let cloth =
        |sheet: usize| untangle.cloth(untangle.net.edges[hits[contours[0].hits[sheet][0] as usize].edge as usize][0]);
    assert_eq!(verdict.map(|verdict| cloth(verdict.sheet)), Some(1), "a half of the small one is wrong");
    let seen =
        (0..untangle.at.len() as u32).filter(|point| untangle.cloth(*point) == 0 && flood.is_seen(*point)).count();
    // At most two parts of the size that these edges may separate.
    let edges = contours[0]
        .hits
        .iter()
        .flatten()
        .filter(|n| untangle.cloth(untangle.net.edges[hits[**n as usize].edge as usize][0]) == 0)
        .count();
    assert!(seen <= 2 * (64 + 4 * edges * edges) + 2 && seen < 1800, "{seen} of 3600 points, {edges} edges");
}
