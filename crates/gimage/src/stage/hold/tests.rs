//! A torso with a neck, and garments on it.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::*;
use crate::base::mesh::Mesh;
use crate::options::{BuildOptions, ImageSize};
use crate::stage::component::{Component, extract, split};
use crate::stage::image::{ImageOptions, image};

/// A surface of revolution about y, through (radius, height) \[m\]; its normals point away from the axis where heights fall.
fn revolved(profile: &[(f64, f64)]) -> Mesh {
    const AROUND: usize = 32;
    let mut mesh = Mesh::default();
    for &(r, y) in profile {
        for k in 0..AROUND {
            let (sin, cos) = (k as f64 / AROUND as f64 * TAU).sin_cos();
            mesh.positions.push([r * cos, y, r * sin]);
        }
    }
    for j in 0..profile.len() - 1 {
        for k in 0..AROUND {
            let [a, b] = [k, (k + 1) % AROUND].map(|k| (j * AROUND + k) as u32);
            let [c, d] = [a, b].map(|x| x + AROUND as u32);
            mesh.triangles.extend([[a, b, c], [c, b, d]]);
        }
    }
    mesh
}

/// A half circle of shoulders about the height 1.35, at a distance from the body, from a radius at the neck down to the chest.
fn shoulders(off: f64, neck: f64) -> Vec<(f64, f64)> {
    let radius = 0.15 + off;
    let first = (neck / radius).asin();
    (0..=8)
        .map(|k| first + (FRAC_PI_2 - first) * f64::from(k) / 8.0)
        .map(|a| (radius * a.sin(), 1.35 + radius * a.cos()))
        .collect()
}

/// 1.8 m tall: neck, shoulders, torso.
fn body() -> Mesh {
    let mut profile = vec![(0.01, 1.8), (0.05, 1.75)];
    profile.extend(shoulders(0.0, 0.05));
    profile.extend([(0.15, 0.0)]);
    revolved(&profile)
}

fn sheet(at: impl Fn(f64, f64) -> [f64; 3]) -> Mesh {
    let mut mesh = Mesh::default();
    for k in 0..17 * 17 {
        mesh.positions.push(at(f64::from(k % 17) / 16.0, f64::from(k / 17) / 16.0));
    }
    for k in (0..16 * 17).filter(|k| k % 17 < 16) {
        mesh.triangles.extend([[k, k + 17, k + 1], [k + 1, k + 17, k + 18]]);
    }
    mesh
}

/// Takes in a garment of one piece.
fn of_piece<T>(mut garment: Mesh, take: impl FnOnce(Piece) -> T) -> T {
    garment.triangle_part = vec![0; garment.triangles.len()];
    garment.parts = vec![Default::default()];
    let mut options = BuildOptions::default();
    options.image.size = ImageSize::Texels(900);
    let components = split(&garment, &options.component).pieces;
    let component: &Component = &components[0];
    let surface = extract(&garment, component);
    let image = image(&component.name, &surface, None, &ImageOptions::new(&options, Some(900))).unwrap();
    take(Piece { component, surface, image })
}

/// How a garment of one piece is held, with the position of each texel.
fn held(garment: Mesh) -> (Hold, Held, Vec<[f64; 3]>) {
    of_piece(garment, |piece| {
        let positions = piece.image.grid.positions.clone();
        let Holds { mut pieces, mut garments } = hold(&Wearer::new(&body()).unwrap(), &[piece], &[]);
        assert_eq!((pieces.len(), garments.len()), (1, 1));
        (garments.remove(0), pieces.remove(0), positions)
    })
}

/// How two garments are held that are worn together, with the position of each texel.
fn both(first: Mesh, second: Mesh) -> [(Hold, Held, Vec<[f64; 3]>); 2] {
    of_piece(first, |first| {
        of_piece(second, |second| {
            let positions = [&first, &second].map(|piece| piece.image.grid.positions.clone());
            let Holds { pieces, garments } = hold(&Wearer::new(&body()).unwrap(), &[first, second], &[]);
            let each = garments.into_iter().zip(pieces).zip(positions);
            let each: Vec<_> = each.map(|((hold, held), positions)| (hold, held, positions)).collect();
            each.try_into().unwrap()
        })
    })
}

/// Lowest and highest point that is pinned.
fn span(held: &Held, positions: &[[f64; 3]]) -> [f64; 2] {
    let pinned = positions.iter().zip(&held.pinned).filter(|x| *x.1).map(|x| x.0[1]);
    pinned.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], y| [lo.min(y), hi.max(y)])
}

#[test]
fn a_skirt_is_held_by_its_waistband() {
    let profile: Vec<_> = (0..=10).map(|k| f64::from(k) / 10.0).map(|t| (0.16 + 0.15 * t, 0.95 - 0.5 * t)).collect();
    let (hold, held, positions) = held(revolved(&profile));
    assert_eq!(hold.rules, [Rule::Ring]);
    let [low, high] = span(&held, &positions);
    assert!(low > 0.91 && high > 0.949, "{low} {high}");
    for ((p, pinned), limit) in positions.iter().zip(&held.pinned).zip(&held.limits) {
        assert_eq!(*pinned, *limit == 0.0, "{p:?}");
        assert!(p[1] < 0.949 || *pinned, "all of the waistband: {p:?}");
        assert!(p[1] > 0.75 || limit.is_infinite(), "free below: {p:?} {limit}");
        assert!(limit.is_infinite() || f64::from(*limit) < (2.5 * (0.95 - p[1])).max(0.046), "{p:?} {limit}");
    }
    assert!(hold.pinned > 0.01 && hold.pinned < 0.1 && hold.limited > hold.pinned, "{hold:?}");
}

#[test]
fn a_shirt_is_held_by_collar_and_shoulders_not_where_it_lies_on_the_chest() {
    let mut profile = shoulders(0.01, 0.07);
    profile.extend((1..=8).map(|k| (0.16, 1.35 - 0.05 * f64::from(k))));
    let (hold, held, positions) = held(revolved(&profile));
    assert_eq!(hold.rules, [Rule::Ring, Rule::Shoulders]);
    let [low, high] = span(&held, &positions);
    assert!(low > 1.4 && high > 1.48, "{low} {high}");
    assert!(hold.pinned < 0.3, "{hold:?}");
}

#[test]
fn a_cuff_that_hides_where_the_arm_ends_goes_less_far_than_would_show_it() {
    // A hand, of which the file has nothing above 0.8, or all of the arm; and a sleeve down to 0.77.
    let hand = [(0.001, 0.7), (0.04, 0.72), (0.04, 0.8)];
    let sleeve = || revolved(&(0..=20).map(|k| (0.05, 1.2 - 0.43 * f64::from(k) / 20.0)).collect::<Vec<_>>());
    for (body, hems) in [(hand.to_vec(), 1), ([&hand[..], &[(0.04, 1.3)]].concat(), 0)] {
        let wearer = Wearer::new(&revolved(&body)).unwrap();
        let (holds, positions) = of_piece(sleeve(), |piece| {
            let positions = piece.image.grid.positions.clone();
            (hold(&wearer, &[piece], &[]), positions)
        });
        assert_eq!(holds.garments[0].hems, hems);
        assert_eq!(holds.findings().iter().any(|f| f.kind == "hint-ends"), hems > 0);
        for (p, limit) in positions.iter().zip(&holds.pieces[0].limits) {
            if p[1] < 0.772 {
                assert!(hems == 0 || *limit < 0.013, "{p:?} {limit}");
            }
            assert!(!(0.85..1.0).contains(&p[1]) || limit.is_infinite(), "{p:?} {limit}");
        }
    }
}

#[test]
fn a_cape_is_held_by_its_upper_edge() {
    let (hold, held, positions) = held(sheet(|u, v| [0.3 * u - 0.15, 1.3 - 0.8 * v, -0.17 - 0.2 * v]));
    assert_eq!(hold.rules, [Rule::Edge]);
    let [low, high] = span(&held, &positions);
    assert!(low > 1.1 && high > 1.29, "{low} {high}");
    assert!(hold.pinned < 0.2, "{hold:?}");
}

#[test]
fn cloth_far_from_the_body_is_held_by_its_top_with_a_warning() {
    let (hold, held, positions) = held(sheet(|u, v| [u - 3.0, 1.0 - v, 0.0]));
    assert_eq!(hold.rules, [Rule::Top]);
    let [low, high] = span(&held, &positions);
    assert!(low >= 0.94 - 1e-9 && high > 0.99, "{low} {high}");
    let findings = Holds { pieces: Vec::new(), garments: vec![hold] }.findings();
    assert_eq!(findings.iter().map(|f| f.kind).collect::<Vec<_>>(), ["rests-nowhere"]);
}

#[test]
fn a_narrow_belt_is_not_held_all_over() {
    let (hold, held, _) = held(revolved(&[(0.16, 0.95), (0.16, 0.945), (0.16, 0.94), (0.16, 0.935)]));
    assert_eq!(hold.rules, [Rule::Ring]);
    assert!(held.pinned.contains(&true) && held.pinned.contains(&false), "{hold:?}");
    assert!(hold.pinned > 0.0 && hold.pinned < 1.0, "{hold:?}");
}

#[test]
fn without_triangles_there_is_no_body() {
    assert!(Wearer::new(&Mesh::default()).is_none());
    let mut flat = body();
    flat.positions.iter_mut().for_each(|p| *p = [f64::NAN; 3]);
    assert!(Wearer::new(&flat).is_none());
}

#[test]
fn cloth_around_pins_inside_of_the_body_is_pinned_too() {
    // A cape whose upper edge is 30 mm inside of the back, in the middle.
    let depth = |p: &[f64; 3]| 0.15 - p[0].hypot(p[2]);
    let (hold, held, positions) = held(sheet(|u, v| [0.2 * (u - 0.5), 1.3 - 0.8 * v, 0.12 + 0.2 * v]));
    // The rule of its upper edge pins nothing below this height.
    let window = 1.3 - 0.2 * 0.8 - 0.01;
    assert_eq!(hold.rules, [Rule::Edge]);
    assert!(hold.tuck.found > 0 && hold.tuck.added > 0, "{hold:?}");
    assert!((hold.tuck.deepest - 0.03).abs() < 2e-3, "{hold:?}");
    for ((p, pinned), limit) in positions.iter().zip(&held.pinned).zip(&held.limits) {
        assert!(depth(p) < 2e-3 || *pinned, "{p:?} is inside and free");
        assert!(depth(p) > -2e-3 || p[1] > window || !*pinned, "{p:?} is outside, far from the edge, and pinned");
        assert_eq!(*pinned, *limit == 0.0);
    }
    let deepest = format!("{:.1} mm", 1e3 * hold.tuck.deepest);
    let said = Holds { pieces: vec![held], garments: vec![hold] }.findings();
    assert!(said.iter().any(|f| f.kind == "hint-tucked" && f.message.contains(&deepest)), "{said:?}");
}

#[test]
fn cloth_outside_of_the_body_has_no_other_pins() {
    let (hold, ..) = held(sheet(|u, v| [0.2 * (u - 0.5), 1.3 - 0.8 * v, 0.16 + 0.2 * v]));
    assert_eq!((hold.rules, hold.tuck), (vec![Rule::Edge], Tuck::default()));
}

#[test]
fn a_share_of_nothing_has_no_sign() {
    let share = of_piece(sheet(|u, v| [u, v, 0.0]), |piece| {
        let sheet = Sheet::new(&[piece], &[]);
        spread::share(&sheet, &vec![false; sheet.positions.len()])
    });
    assert_eq!(format!("{share:.1}"), "0.0");
}

/// A tube of a radius, between two heights.
fn tube(radius: impl Fn(f64) -> f64, [high, low]: [f64; 2]) -> Mesh {
    let rows = (0..=12).map(|k| f64::from(k) / 12.0).map(|t| (radius(t), high + t * (low - high)));
    revolved(&rows.collect::<Vec<_>>())
}

#[test]
fn a_shirt_stays_over_the_waistband_that_it_covers() {
    let trousers = || tube(|_| 0.165, [1.0, 0.5]);
    let mut profile = shoulders(0.03, 0.07);
    profile.extend((1..=9).map(|k| (0.18, 1.35 - 0.05 * f64::from(k))));
    let (_, alone, _) = held(trousers());
    let [(under, lower, at), (over, upper, there)] = both(trousers(), revolved(&profile));
    assert!(under.over == [over.name] && over.over.is_empty() && under.covered > 0.1, "{under:?} {:?}", over.over);
    let near = |x: f32| (f64::from(x) - 0.35 * 0.015).abs() < 5e-4;
    let (mut covered, mut behind) = (0, 0);
    for (k, p) in at.iter().enumerate().filter(|(k, _)| !lower.pinned[*k]) {
        assert!(p[1] < 0.91 || near(lower.limits[k]), "{p:?} {}", lower.limits[k]);
        assert!(p[1] > 0.89 || lower.limits[k] == alone.limits[k], "{p:?} {}", lower.limits[k]);
        covered += usize::from(p[1] > 0.91);
    }
    for (k, p) in there.iter().enumerate() {
        assert!(p[1] > 0.99 || near(upper.behind[k]), "{p:?} {}", upper.behind[k]);
        assert!(p[1] < 1.12 || upper.behind[k].is_infinite(), "{p:?} {}", upper.behind[k]);
        behind += usize::from(p[1] < 0.99);
    }
    assert!(covered > 20 && behind > 20 && lower.behind.iter().all(|x| x.is_infinite()), "{covered} {behind}");
    let said = Holds { pieces: Vec::new(), garments: vec![under] }.findings();
    assert!(said.iter().any(|f| f.kind == "hint-layers"), "{said:?}");
}

#[test]
fn a_lining_is_free_where_it_is_far_from_pins_and_the_body() {
    let skirt = |off: f64| tube(move |t| 0.16 + off + 0.4 * t, [0.95, 0.45]);
    let [(under, lower, at), (_, upper, there)] = both(skirt(0.0), skirt(0.015));
    assert_eq!(under.over.len(), 1);
    let free = |p: &[f64; 3]| p[1] < 0.95 - 0.3;
    let all = at.iter().zip(&lower.limits).chain(there.iter().zip(&upper.behind));
    let far: Vec<f32> = all.filter(|(p, _)| free(p)).map(|(_, x)| *x).collect();
    assert!(far.len() > 100 && far.iter().all(|x| x.is_infinite()));
    assert!(upper.behind.iter().any(|x| x.is_finite()));
}

#[test]
fn garments_whose_normals_point_inwards_have_no_order() {
    let turned = |mut mesh: Mesh| {
        mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        mesh
    };
    let [(under, ..), (over, ..)] = both(turned(tube(|_| 0.165, [1.0, 0.5])), turned(tube(|_| 0.18, [1.1, 0.9])));
    assert!(under.over.is_empty() && over.over.is_empty(), "{under:?} {over:?}");
}

#[test]
fn trousers_with_a_closed_waist_are_not_held_by_their_hems() {
    // A leg whose upper end is closed by a disk that faces up.
    let mut profile = vec![(0.001, 0.96), (0.05, 0.96), (0.1, 0.96), (0.16, 0.96)];
    profile.extend((1..=10).map(|k| (0.16, 0.96 - 0.09 * f64::from(k))));
    let (hold, held, positions) = held(revolved(&profile));
    assert!(!hold.rules.contains(&Rule::Ring), "{hold:?}");
    let [low, high] = span(&held, &positions);
    assert!(low > 0.8 && high > 0.959, "{low} {high} {hold:?}");
}

#[test]
fn a_pocket_does_not_hold_the_shirt_beneath() {
    let mut profile = shoulders(0.01, 0.07);
    profile.extend((1..=9).map(|k| (0.16, 1.35 - 0.05 * f64::from(k))));
    // A part of a tube about the same axis, 2 mm in front of the chest.
    let pocket = sheet(|u, v| {
        let (sin, cos) = (0.4 - 0.8 * u).sin_cos();
        [0.162 * cos, 1.25 - 0.12 * v, 0.162 * sin]
    });
    let [(shirt, ..), (own, upper, _)] = both(revolved(&profile), pocket);
    assert_eq!(own.rules, [Rule::Edge]);
    assert!(shirt.over.is_empty() && upper.behind.iter().all(|x| x.is_infinite()), "{shirt:?}");
}
