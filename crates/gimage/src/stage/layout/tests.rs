use super::*;
use crate::base::shapes;
use crate::base::surface::Surface;
use crate::stage::border::Border;
use proptest::prelude::*;

const SEARCH: SearchOptions = SearchOptions {
    triangles: 400,
    shifts: 12,
    rough: 12,
    passes: 3,
    steps: [3, 4, 5],
    keep: [12, 3],
    refine: true,
    snap: 6,
};

fn searched(s: &Surface, size: Size) -> (Layout, Vec<u32>) {
    let rim = shapes::rim(s);
    let mut disk = shapes::opened(s, &[]);
    let border = Border::new(&mut disk, |v| rim[v as usize]);
    let layout = Proxy::new(&disk, &border, SEARCH).search_map(size, None).unwrap().layout;
    let dead = border.dead_ends(&layout.count);
    (layout, dead)
}

#[test]
fn a_rectangle_and_a_tube_are_laid_out_without_distortion() {
    // 24 x 12 cells of a 2 x 1 m sheet are squares; the tube of circumference 1 and length 0.5 likewise.
    for s in [shapes::rectangle(16, 8, 2.0, 1.0), shapes::rectangle(8, 16, 1.0, 2.0)] {
        for size in [Size::Fixed(25, 13), Size::Fixed(13, 25)] {
            let l = searched(&s, size).0;
            // As near as the search's short solve goes.
            assert!(l.score.abs() < 1e-5, "{size:?}: {}", l.score);
        }
        let l = searched(&s, Size::Budget(325)).0;
        assert!(l.score < 1e-2, "{l:?}");
    }
    let l = searched(&shapes::tube(64, 8, 0.5), Size::Fixed(25, 13)).0;
    assert!(l.score.abs() < 1e-4, "{l:?}");
}

#[test]
fn dead_ends_are_never_on_a_corner_of_the_image() {
    for (name, s) in shapes::all() {
        let (l, dead) = searched(&s, Size::Budget(400));
        if l.score.is_finite() {
            let all = 2 * (l.w + l.h);
            let at = |d: u32| (f64::from(d) + l.shift).rem_euclid(f64::from(all)) as u32;
            for d in dead {
                assert!(![0, l.w, l.w + l.h, 2 * l.w + l.h].contains(&at(d)), "{name}");
            }
        }
    }
}

#[test]
fn a_search_that_starts_worse_than_another_is_given_up_and_no_other() {
    let s = shapes::torus(24, 16);
    let mut disk = shapes::opened(&s, &[]);
    let border = Border::new(&mut disk, |_| false);
    let found = |than| Proxy::new(&disk, &border, SEARCH).search_map(Size::Budget(2000), than);
    let free = found(None).unwrap();
    let [first, second] = free.early;
    // Steps lower the energy, and the score, a mean of logarithms, only in the main.
    assert!(first > 0.01 && second > 0.01 && free.layout.score < 1.01 * second, "{free:?}");
    assert!(found(Some([0.9 * first, f64::INFINITY])).is_none());
    assert!(found(Some([f64::INFINITY, 0.9 * second])).is_none());
    // A search that starts well enough is the same search.
    assert_eq!(found(Some([first, second])).unwrap().layout, free.layout);
}

#[test]
fn an_image_too_small_for_the_border_is_refused() {
    assert_eq!(cells(Size::Fixed(5, 5), 1.0, 16), Some((4, 4)));
    assert_eq!(cells(Size::Fixed(5, 5), 1.0, 18), None);
    assert_eq!(cells(Size::Fixed(2, 50), 1.0, 8), None);
}

#[test]
fn no_image_is_longer_or_larger_than_can_be_stored() {
    let cap = gimage_bundle::MAX_PARTICLES;
    assert!(cells(Size::Budget(cap), 1.0 / 24.0, 8).is_none());
    assert!(cells(Size::Budget(100), 1.0, 4 * gimage_bundle::MAX_SIDE).is_none());
    let (w, h) = cells(Size::Budget(cap), 1.0, 8).unwrap();
    assert!((w + 1) * (h + 1) <= cap);
}

proptest! {
    #[test]
    fn cells_keep_the_budget_and_hold_the_border(texels in 64u32..2_000_000, aspect in 0.2f64..6.4, least in 8u32..5000) {
        let (w, h) = cells(Size::Budget(texels), aspect, least).unwrap();
        prop_assert!(2 * (w + h) >= least);
        // More than the budget only where the border needs it, and then no more than it needs.
        prop_assert!((w + 1) * (h + 1) <= texels || 2 * (w + h) <= least.max(8) + 1);
    }

    #[test]
    fn the_smallest_image_holds_the_border(least in 8u32..10_000) {
        let (w, h) = smallest(least);
        prop_assert!(w >= 3 && h >= 3);
        prop_assert_eq!(cells(Size::Fixed(w, h), 1.0, least), Some((w - 1, h - 1)));
        prop_assert!(w.abs_diff(h) <= 1 && 2 * (w + h - 2) <= least + 3);
    }
}

#[test]
fn a_border_too_long_for_the_budget_makes_the_image_longer_not_larger() {
    for (texels, least) in [(16_384, 810), (6417, 690), (1000, 140), (400, 96)] {
        for aspect in [0.2, 0.5, 1.0, 3.0] {
            let (w, h) = cells(Size::Budget(texels), aspect, least).unwrap();
            assert!((w + 1) * (h + 1) <= texels && 2 * (w + h) >= least, "{texels} {least}: {w} x {h}");
            // Longer along the side that the aspect asks for.
            assert!(if aspect < 1.0 { w <= h } else { w >= h }, "{texels} {least} {aspect}: {w} x {h}");
        }
    }
    // Narrower than that the border decides.
    let (w, h) = cells(Size::Budget(100), 1.0, 200).unwrap();
    assert!((w + 1) * (h + 1) > 100 && 2 * (w + h) >= 200);
}

/// A ribbon of 1 x 200 in loose turns; with round ends it has no corner that its border could start at.
fn ribbon(round: bool) -> Surface {
    shapes::sheet(400, 4, shapes::Join::Open, shapes::Join::Open, |u, v| {
        let side = 2.0 * v - 1.0;
        let out = if round { 0.025 * (1.0 - side * side).max(0.0).sqrt() * (2.0 * u - 1.0) } else { 0.0 };
        let a = 0.6 * (10.0 * u + out);
        [1.6 * a.cos(), 0.05 * v + 0.1 * a, 1.6 * a.sin()]
    })
}

#[test]
fn a_ribbon_becomes_a_long_image() {
    for round in [false, true] {
        let s = ribbon(round);
        for search in [SEARCH, SearchOptions::DEFAULT, SearchOptions::FAST] {
            let rim = shapes::rim(&s);
            let mut disk = shapes::opened(&s, &[]);
            let border = Border::new(&mut disk, |v| rim[v as usize]);
            let l = Proxy::new(&disk, &border, search).search_map(Size::Budget(16_384), None).unwrap().layout;
            let aspect = f64::from(l.w.max(l.h)) / f64::from(l.w.min(l.h));
            assert!((100.0..400.0).contains(&aspect) && l.score < 0.1, "round {round}: {} x {}, {}", l.w, l.h, l.score);
            assert!((l.w + 1) * (l.h + 1) <= 16_384);
        }
    }
}

#[test]
fn a_ribbon_too_long_for_the_budget_is_three_texels_wide() {
    let s = shapes::rectangle(1000, 1, 20.0, 0.01);
    let l = searched(&s, Size::Budget(900)).0;
    assert_eq!(l.w.min(l.h), 2, "{l:?}");
    assert!((l.w + 1) * (l.h + 1) <= 900, "{l:?}");
}

#[test]
fn only_what_is_long_is_a_strip() {
    let around = |s: &Surface| -> Vec<[f64; 3]> {
        let disk = shapes::opened(s, &[]);
        disk.boundary.iter().map(|&v| disk.positions[v as usize]).collect()
    };
    for (x, strip) in [(1.0, false), (6.0, false), (10.0, true), (1000.0, true)] {
        let s = shapes::rectangle(100, 4, x, 1.0);
        let found = strip::Strip::of(&around(&s), x, 6.4);
        assert_eq!(found.is_some(), strip, "{x}");
        if let Some(found) = found {
            assert!((found.aspect / x - 1.0).abs() < 1e-6, "{found:?}");
        }
    }
    // Long because of its fringe: folded anywhere, its sides are far apart.
    let fringed = |u: f64, v: f64| if v > 0.0 { [u, 0.3 + 0.3 * (300.0 * u).sin(), 0.0] } else { [u, 0.0, 0.0] };
    let s = shapes::sheet(400, 1, shapes::Join::Open, shapes::Join::Open, fringed);
    assert!(strip::Strip::of(&around(&s), s.area(), 6.4).is_none());
    assert!(strip::Strip::of(&[], 1.0, 6.4).is_none() && strip::Strip::of(&[[0.0; 3]; 3], 0.0, 6.4).is_none());
    assert!(strip::Strip::of(&[[f64::NAN; 3]; 4], 1.0, 6.4).is_none());
}

#[test]
fn a_border_of_a_thousand_holes_is_refused_and_not_given_millions_of_texels() {
    assert!(cells(Size::Budget(16_384), 1.0, 16_000).is_none());
    // A size that a piece of a garment may need is still given.
    let (w, h) = cells(Size::Budget(591), 1.0, 1800).unwrap();
    assert!(2 * (w + h) >= 1800);
}
