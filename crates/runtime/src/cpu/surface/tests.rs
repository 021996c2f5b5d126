use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{TriMesh, Triangle};

use super::boxes::nearest_of;
use super::nearest::{faces_away, walk, walk_beyond};
use super::passing::{FAST_WAY_M, NEARER_M, Passing};
use super::pose::unit;
use super::search::kept;
use super::*;
use crate::cloth::surface::{PASSES_M, on_triangle};
use crate::cloth::{Flat, Influence, Rows, SkinJoint, Skinning};

/// Numbers of a fixed sequence between -1 and 1.
fn noise(k: usize, of: usize) -> f64 {
    let prime = [2u32, 3, 5, 7, 11, 13, 17, 19, 23, 29][of % 10];
    2.0 * ((k + 1) as f64 * f64::from(prime).sqrt()).fract() - 1.0
}

/// A closed tube along y of 12 cm, with waves, in two joints.
fn body() -> BodySurface {
    let (around, rings) = (40u32, 80u32);
    let (mut positions, mut triangles, mut influences) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..around * rings {
        let (i, t) = (k % around, (k / around) as f32 / (rings - 1) as f32);
        let a = std::f32::consts::TAU * i as f32 / around as f32;
        let round = (1.0 - (2.0 * t - 1.0).powi(6)).max(0.01).sqrt();
        let r = round * (0.12 + 0.015 * (3.0 * a).sin() + 0.02 * (12.0 * t).sin());
        positions.push([r * a.cos(), 0.5 - t, r * a.sin()]);
        let second = (4.0 * t - 1.5).clamp(0.0, 1.0);
        influences.push(Influence { joints: [0, 1, 0, 0], weights: [1.0 - second, second, 0.0, 0.0] });
    }
    let at = |i: u32, j: u32| j * around + i % around;
    for (i, j) in (0..rings - 1).flat_map(|j| (0..around).map(move |i| (i, j))) {
        triangles.extend([[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]]);
    }
    for (j, y) in [(0, 0.5), (rings - 1, -0.5)] {
        let middle = positions.len() as u32;
        positions.push([0.0, y, 0.0]);
        influences.push(Influence {
            joints: [0, 1, 0, 0],
            weights: if j == 0 { [1.0, 0.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0, 0.0] },
        });
        let cap = |i| if j == 0 { [middle, at(i + 1, j), at(i, j)] } else { [middle, at(i, j), at(i + 1, j)] };
        triangles.extend((0..around).map(cap));
    }
    BodySurface::new(positions, triangles, influences).unwrap()
}

fn pose(frame: usize) -> Vec<Rows> {
    let t = frame as f32 / 60.0;
    let turn = |angle: f32| {
        let (s, c) = angle.sin_cos();
        [[c, -s, 0.0, 0.1 * (2.0 * t).sin()], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.2 * (3.0 * t).sin()]]
    };
    vec![turn(0.4 * (3.0 * t).sin()), turn(0.4 * (3.0 * t).sin() + 0.8 * (4.0 * t).sin())]
}

/// Particles around the body, those of one row on one side of it.
fn worn(n: u32) -> (Worn<f32>, Vec<Sheet<f32>>) {
    let mut cloth = Flat::square("cloth", n).cloth().unwrap();
    let own = vec![Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] }; cloth.len()];
    cloth.set_skin(vec![SkinJoint::default(); 2], &own).unwrap();
    cloth.set_body(Some(Arc::new(body()))).unwrap();
    cloth.thickness = Some(0.003);
    let mut sheet = Sheet::<f32>::new(&cloth.grids()[0]);
    sheet.weigh(|_| 1.0);
    let place = |k: usize| (0, sheet.single(k), sheet.triple(k));
    let mut worn = Worn::of(&cloth, std::slice::from_ref(&sheet), 0.0, place).unwrap();
    // A part of the square is inside of the body at rest, and might stay there.
    assert!(worn.clearances.iter().any(|c| *c < 0.0) && worn.clearances.contains(&0.003));
    worn.clearances.fill(0.003);
    (worn, vec![sheet])
}

/// Where a particle is in a frame: it swings about the axis of the body.
fn path(k: usize, n: usize, frame: usize) -> V3<f32> {
    let t = frame as f64 / 60.0;
    let around = 6.0 * (k % n) as f64 / n as f64 + 0.3 * (2.0 * t).sin();
    let r = 0.17 + 0.05 * noise(k, 3) + 0.02 * (5.0 * t + k as f64).sin();
    [(r * around.cos()) as f32, (0.8 * (k / n) as f64 / n as f64 - 0.4) as f32, (r * around.sin()) as f32]
}

#[test]
fn a_pin_inside_of_a_body_lowers_what_the_cloth_beside_it_keeps() {
    // A particle 10 mm above the surface, which is at the height 0; its pin is 2 mm above, on, or 40 mm below it.
    let (p, from, normal) = ([0.0, 0.01, 0.0], [0.0, 0.01, 0.0], [0.0, 1.0, 0.0]);
    assert_eq!(kept(0.003, &None, p, (from, normal)), 0.003);
    let kept = |pin: f64, most: f64| {
        let pin = |modelled: f64| Some(Pin { at: [0.3, pin - modelled, 0.1], most, modelled });
        let [own, deeper] = [0.0, 0.02].map(|modelled| kept(0.003, &pin(modelled), p, (from, normal)));
        assert!((own - deeper).abs() < 1e-12, "as deep as it was modelled is not inside: {own} {deeper}");
        own
    };
    assert_eq!((kept(0.002, 0.012), kept(0.0, 0.004)), (0.003, 0.003));
    // It comes out where the cloth is 1.25 times as long as the pin is deep, far from the pin where it is as long.
    for (most, want) in [(0.01, -0.04), (0.05, 0.0), (0.052, 0.002), (0.06, 0.003)] {
        assert!((kept(-0.04, most) - want).abs() < 1e-12, "{most}: {}", kept(-0.04, most));
    }
    assert!((kept(-0.4, 0.402) - 0.002).abs() < 1e-12 && (kept(-0.15, 0.15) + 0.15 * 0.125).abs() < 1e-12);

    // A particle that is not pinned any more holds nothing.
    let mut sheet = Sheet::<f64>::new(&Flat::square("cloth", 4).cloth().unwrap().grids()[0]);
    let (at, single) = (sheet.triple(1), sheet.single(1));
    let place = Member { sheet: 0, at: at as u32, single: single as u32 };
    let hold = Hold { place, most: 0.5, modelled: 0.01 };
    sheet.weigh(|k| if k == 1 { 0.0 } else { 1.0 });
    sheet.put(at, [1.0, 2.0, 3.0]);
    let pin = hold.pin(std::slice::from_ref(&sheet)).unwrap();
    assert_eq!((pin.at, pin.most, pin.modelled), ([1.0, 2.0, 3.0], 0.5, 0.01));
    sheet.weigh(|_| 1.0);
    assert!(hold.pin(&[sheet]).is_none());
}

#[test]
fn particles_know_the_nearest_point_of_a_body_in_motion() {
    let n = 24;
    let (mut worn, mut sheets) = worn(n as u32);
    let (mut errors, mut beyond) = (Vec::new(), 0);
    for frame in 0..120 {
        worn.lead(&Poses::new(Skinning::Linear, &pose(frame)), if frame > 0 { 60.0 } else { 0.0 });
        for k in 0..n * n {
            let triple = sheets[0].triple(k);
            sheets[0].put(triple, path(k, n, frame));
        }
        worn.begin();
        worn.search(&sheets, &[0]);
        let surface = worn.surface.clone();
        let vertices: Vec<Vector> = (0..surface.rest.len() as u32)
            .map(|v| Vector::from_array(worn.skinned.vertex(v).at[0].map(f64::from)))
            .collect();
        let mesh = TriMesh::new(vertices, surface.triangles.clone()).unwrap();
        for k in 0..n * n {
            let p = path(k, n, frame).map(f64::from);
            let exact = mesh.distance_to_point(&Pose::IDENTITY, Vector::from_array(p), false);
            let near = exact < 0.01;
            let place = (sheets[0].single(k), sheets[0].triple(k));
            let plane = worn.planes[0][0].get(place, sheets[0].half);
            let Some(plane) = plane else {
                beyond += usize::from(near);
                continue;
            };
            let at = |c: usize| f64::from(plane.at[c]) - f64::from(plane.drift[c]) / 60.0;
            let found = (0..3).map(|c| (p[c] - at(c)).powi(2)).sum::<f64>().sqrt();
            if near {
                errors.push((found - exact).abs());
            }
        }
    }
    assert_eq!(beyond, 0, "of {}: a particle that is near has no plane", errors.len());
    errors.sort_by(f64::total_cmp);
    let at = |share: f64| errors[((errors.len() - 1) as f64 * share) as usize];
    assert!(errors.len() > 3000 && at(0.99) < 6e-4 && at(1.0) < 5e-3, "{}: {:e} {:e}", errors.len(), at(0.99), at(1.0));
}

#[test]
fn a_walk_from_any_triangle_ends_at_the_nearest_point_of_a_round_body() {
    let surface = body();
    let (mut skinned, mut boxes) = (Skinned::<f64>::new(&surface), Boxes::new(&surface));
    skinned.begin();
    let mut missed = 0;
    for k in 0..2000 {
        let (a, r) = (3.0 * noise(k, 0), 0.15 + 0.04 * noise(k, 1));
        let p = [r * a.cos(), 0.45 * noise(k, 2), r * a.sin()];
        let best = boxes.search(&surface, &mut skinned, p);
        let exact = walk(&surface, &mut skinned, best, p).distance2.sqrt();
        // Not from the other side, but from nearby.
        let start = surface.triangles.len() * (((k * 7919) % 1000) as f64 / 1000.0) as usize;
        let near = surface.across[best as usize][k % 3];
        let near = if near == NONE { best } else { surface.across[near as usize][(k + 1) % 3] };
        let from = if near == NONE { start as u32 } else { near };
        let found = walk(&surface, &mut skinned, from, p).distance2.sqrt();
        assert!(found >= exact - 1e-12, "the search among patches is exact");
        missed += usize::from(found > exact + 1e-6);
    }
    assert!(missed < 20, "{missed} of 2000");
}

#[test]
fn the_nearest_point_of_a_triangle_is_that_of_parry() {
    let mut seen = std::collections::BTreeSet::new();
    for k in 0..4000 {
        let corner = |n: usize| [0, 1, 2].map(|c| noise(k + 7 * n, 3 * n + c));
        let (corners, p) = ([corner(0), corner(1), corner(2)], [0, 1, 2].map(|c| 2.0 * noise(k, c + 6)));
        let spot = on_triangle(p, 0, corners);
        let v = |p: V3<f64>| Vector::from_array(p);
        let judge = Triangle::new(v(corners[0]), v(corners[1]), v(corners[2]));
        let exact = judge.distance_to_local_point(v(p), true);
        assert!((spot.distance2.sqrt() - exact).abs() < 1e-9, "{k}");
        assert!((spot.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12 && spot.weights.iter().all(|w| *w > -1e-12));
        seen.insert(format!("{:?}", spot.on));
    }
    assert_eq!(seen.len(), 7, "{seen:?}");
}

#[test]
fn the_first_of_the_nearest_points_is_found() {
    for k in 0..200 {
        let mut points = [0, 1, 2].map(|c| (0..48).map(|n| noise(n + k, c) as f32).collect::<Vec<f32>>());
        // Two at one place.
        points.iter_mut().for_each(|list| list[40] = list[3]);
        let p = [0, 1, 2].map(|c| noise(k, c + 4) as f32);
        let far = |n: usize| (0..3).map(|c| (points[c][n] - p[c]) * (points[c][n] - p[c])).fold(0.0, |a, b| a + b);
        let want = (0..48).min_by(|a, b| far(*a).total_cmp(&far(*b))).unwrap();
        assert_eq!(nearest_of(&points, p), want);
    }
}

#[test]
fn the_patch_that_passes_nearest_is_that_of_all_times() {
    let surface = body();
    let count = surface.middles.len();
    let (mut of_fast, mut of_slow) = (0, 0);
    for k in 0..400 {
        let from = |n: usize| [0, 1, 2].map(|c| 0.4 * noise(n + 31 * k, c));
        // Half of them go far, in a direction of their own.
        let way = |n: usize| [0, 1, 2].map(|c| if n.is_multiple_of(2) { 0.2 } else { 0.01 } * noise(n + 17 * k, c + 3));
        let mut passing = Passing::<f64>::new(&surface);
        passing.follow((0..count).map(|n| [from(n), add(from(n), way(n))]));
        let p = [0, 1, 2].map(|c| 0.4 * noise(k, c + 6));
        let goes = [0, 1, 2].map(|c| if k.is_multiple_of(2) { 0.1 } else { 0.005 } * noise(k, c + 7));
        let is_fast = |v: V3<f64>| length(v) > FAST_WAY_M;
        // By looks at 2,000 times.
        let share = |n: usize| {
            let away = |time: f64| length(sub(add(from(n), scale(way(n), time)), add(p, scale(goes, time))));
            let nearest = (0..=2000).map(|t| away(f64::from(t) / 2000.0)).fold(f64::INFINITY, f64::min);
            let comes = away(0.0) > nearest + NEARER_M && (is_fast(goes) || is_fast(way(n)));
            if comes { nearest / (f64::from(surface.extents[n]) + PASSES_M) } else { f64::INFINITY }
        };
        let least = (0..count).map(share).fold(f64::INFINITY, f64::min);
        match passing.nearest(p, goes, true) {
            Some(n) => {
                assert!(
                    share(n as usize) < least + 1e-3 && least < 1.0 + 1e-3,
                    "{k}: {} of {least}",
                    share(n as usize)
                );
                *(if is_fast(goes) { &mut of_fast } else { &mut of_slow }) += 1;
            }
            None => assert!(least > 1.0 - 1e-3, "{k}: {least}"),
        }
    }
    assert!(of_fast > 20 && of_slow > 20, "{of_fast}, {of_slow}");
}

#[test]
fn a_walk_on_one_wall_of_a_crease_stays_there() {
    // Two walls along z that open by 100 degrees from the origin, in strips of 1 cm, as seen from between them.
    let wall = |side: f32, k: u32, z: f32| {
        let (sin, cos) = 50f32.to_radians().sin_cos();
        [side * sin * 0.01 * k as f32, cos * 0.01 * k as f32, z]
    };
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for z in 0..11 {
        positions.extend((0..21).map(|n: u32| {
            let side = if n < 10 { -1.0 } else { 1.0 };
            wall(side, n.abs_diff(10), 0.01 * z as f32)
        }));
    }
    for (i, j) in (0..10).flat_map(|j| (0..20).map(move |i| (i, j))) {
        let at = |i: u32, j: u32| j * 21 + i;
        triangles.extend([[at(i, j), at(i, j + 1), at(i + 1, j)], [at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]]);
    }
    let surface = BodySurface::new(positions, triangles, Vec::new()).unwrap();
    let mut skinned = Skinned::<f64>::new(&surface);
    skinned.begin();
    let is_left = |surface: &BodySurface, t: u32| {
        surface.triangles[t as usize].iter().map(|v| surface.rest[*v as usize][0]).sum::<f32>() < 0.0
    };
    let right = |skinned: &mut Skinned<f64>, t: u32| unit(face(&skinned.corners(&surface, t)));
    let mut crossed = 0;
    for k in 0..40 {
        // Nearer to the wall on the right, from which it goes to the one on the left.
        let far = 0.02 + 0.001 * f64::from(k);
        let (sin, cos) = 40f64.to_radians().sin_cos();
        let p = [far * cos - 0.002 * sin, far * sin + 0.002 * cos, 0.053];
        let own = surface.triangles.iter().position(|t| t.iter().all(|v| surface.rest[*v as usize][0] > 0.03)).unwrap();
        let other =
            surface.triangles.iter().position(|t| t.iter().all(|v| surface.rest[*v as usize][0] < -0.01)).unwrap();
        let normal = right(&mut skinned, own as u32);
        assert!(normal[1] > 0.0 && faces_away(&surface, &mut skinned, other as u32, normal));
        let plain = walk(&surface, &mut skinned, other as u32, p);
        crossed += usize::from(!is_left(&surface, plain.triangle));
        let spot = walk_beyond(&surface, &mut skinned, (other as u32, Some(normal)), p);
        assert!(is_left(&surface, spot.triangle), "{far}: {spot:?}");
        // The crease is the nearest part of that wall.
        let exact = (p[0] * p[0] + p[1] * p[1]).sqrt();
        assert!((spot.distance2.sqrt() - exact).abs() < 1e-6, "{far}: {spot:?}, {exact}");
    }
    assert!(crossed > 20, "{crossed}: a walk without the rule leaves the wall");
}

/// Boxes of 20 x 2 x 20 cm, each in a joint of its own, their lower sides at these heights.
fn plates(heights: &[f32]) -> BodySurface {
    let (mut positions, mut triangles, mut influences) = (Vec::new(), Vec::new(), Vec::new());
    for (joint, low) in heights.iter().enumerate() {
        let first = positions.len() as u32;
        positions.extend((0..8).map(|k| {
            let side = |bit: u32| if k >> bit & 1 == 1 { 0.1 } else { -0.1 };
            [side(0), low + if k >> 1 & 1 == 1 { 0.02 } else { 0.0 }, side(2)]
        }));
        let weights = [1.0, 0.0, 0.0, 0.0];
        influences.extend(vec![Influence { joints: [joint as u32, 0, 0, 0], weights }; 8]);
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        triangles
            .extend(quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).map(|t| t.map(|v| v + first)));
    }
    BodySurface::new(positions, triangles, influences).unwrap()
}

#[test]
fn a_side_of_the_part_that_a_particle_is_before_gives_it_no_plane_from_behind() {
    let facing = |surface: &BodySurface, up: f32, from: f32| {
        let rest = |t: &[u32; 3]| t.map(|v| surface.rest[v as usize]);
        let is_it = |t: &[u32; 3]| {
            let corners = rest(t);
            face(&corners)[1] * up > 0.01 && corners[0][1] >= from
        };
        surface.triangles.iter().position(is_it).unwrap() as u32
    };
    let still = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let mut lower = still;
    lower[1][3] = -0.05;
    // Before a plate, of which it knows the other side; and where a second plate, 3 cm above it at rest, has come over the first one.
    for (heights, from, is_met) in [(&[-0.02][..], -1.0, false), (&[-0.02, 0.03], 0.01, true)] {
        let surface = Arc::new(plates(heights));
        let [top, under] = [facing(&surface, 1.0, -1.0), facing(&surface, -1.0, from)];
        let mut cloth = Flat::square("cloth", 4).cloth().unwrap();
        let own = vec![Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] }; cloth.len()];
        cloth.set_skin(vec![SkinJoint::default(); heights.len()], &own).unwrap();
        cloth.set_body(Some(surface)).unwrap();
        let mut sheet = Sheet::<f32>::new(&cloth.grids()[0]);
        sheet.weigh(|_| 1.0);
        let place = |k: usize| (0, sheet.single(k), sheet.triple(k));
        let mut worn = Worn::of(&cloth, std::slice::from_ref(&sheet), 0.0, place).unwrap();
        worn.clearances.fill(0.003);
        let p = [0.01, 0.002, 0.02];
        (0..16).for_each(|k| sheet.put(sheet.triple(k), p));
        let poses: Vec<Rows> = [still, lower].into_iter().take(heights.len()).collect();
        worn.lead(&Poses::new(Skinning::Linear, &poses), 60.0);
        for hint in &mut worn.hints {
            (hint.last, hint.triangle, hint.second, hint.weights) = (p, top, under, [1.0 / 3.0; 3]);
            hint.normal = [0.0, 1.0, 0.0];
        }
        worn.begin();
        worn.search(std::slice::from_ref(&sheet), &[0]);
        let places = (sheet.single(5), sheet.triple(5));
        let [first, second] = [0, 1].map(|n| worn.planes[n][0].get(places, sheet.half));
        assert!(first.is_some_and(|plane| plane.normal[1] > 0.99), "{first:?}");
        assert_eq!(second.map(|plane| plane.normal[1] < -0.99), is_met.then_some(true), "{heights:?}");
    }
}
