use gimage_bundle::{Body, Image, MapKind};

use super::*;
use crate::cloth::{Cloth, Skinning};

/// A bowl: a part of a ball of 1 m, seen from inside, with a border.
fn bowl(n: u32) -> BodySurface {
    let at = |i: u32, j: u32| {
        let [x, z] = [i, j].map(|k| 1.2 * k as f32 / (n - 1) as f32 - 0.6);
        [x, -(1.0 - x * x - z * z).sqrt(), z]
    };
    let positions = (0..n * n).map(|k| at(k % n, k / n)).collect();
    let cells = (0..(n - 1) * (n - 1)).map(|k| (k % (n - 1)) + k / (n - 1) * n);
    let triangles = cells.flat_map(|k| [[k, k + n, k + 1], [k + 1, k + n, k + n + 1]]).collect();
    BodySurface::new(positions, triangles, Vec::new()).unwrap()
}

#[test]
fn sides_have_their_neighbours_and_a_bowl_is_hollow_everywhere() {
    let n = 12;
    let bowl = bowl(n);
    for (t, across) in bowl.across.iter().enumerate() {
        for (c, other) in across.iter().enumerate().filter(|x| *x.1 != NONE) {
            let [a, b] = [bowl.triangles[t][c], bowl.triangles[t][(c + 1) % 3]];
            let theirs = bowl.triangles[*other as usize];
            assert!((0..3).any(|k| [theirs[(k + 1) % 3], theirs[k]] == [a, b]), "{t} {c}");
            // Which way the two triangles of a cell fold is up to their diagonal.
            let diagonal = a.abs_diff(b) == n - 1;
            assert!(diagonal || bowl.hollow[t] >> c & 1 == 1, "{t} {c}");
        }
    }
    assert_eq!(bowl.across.as_flattened().iter().filter(|t| **t == NONE).count() as u32, 4 * (n - 1));
    assert_eq!(bowl.border.iter().filter(|b| **b).count() as u32, 4 * (n - 1));
    assert!(bowl.normals.iter().all(|n| n[1] > 0.5), "they point inwards");
    let turned = bowl.triangles.iter().map(|t| [t[0], t[2], t[1]]).collect();
    let dome = BodySurface::new(bowl.rest.clone(), turned, Vec::new()).unwrap();
    let hollow: u32 = dome.hollow.iter().map(|bits| bits.count_ones()).sum();
    assert!(hollow <= 2 * (n - 1) * (n - 1), "only diagonals: {hollow}");
}

#[test]
fn every_triangle_is_in_a_patch_that_has_its_middle() {
    let bowl = bowl(40);
    assert!((64..=1024).contains(&bowl.middles.len()), "{}", bowl.middles.len());
    for (n, middle) in bowl.middles.iter().enumerate() {
        assert_eq!(bowl.patch[*middle as usize], n as u32);
    }
    assert!(bowl.patch.iter().all(|p| (*p as usize) < bowl.middles.len()));
}

/// A closed box from -0.1 to 0.1 m that follows one joint.
fn cube() -> BodySurface {
    let at = |k: u32| [0, 1, 2].map(|c| if k >> c & 1 == 1 { 0.1 } else { -0.1 });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let influence = Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] };
    BodySurface::new((0..8).map(at).collect(), triangles, vec![influence; 8]).unwrap()
}

/// Weighed by area, that of a corner with a large narrow triangle points behind a small wide one, and cloth in front of both is taken for inside.
#[test]
fn the_normal_of_a_corner_points_in_front_of_small_triangles_too() {
    let at = vec![[0.0; 3], [2.0, -0.5, 0.0], [2.0, 0.5, 0.0], [0.0, 0.1, 0.0], [0.03, 0.0, -0.0954]];
    let sharp = BodySurface::new(at, vec![[0, 1, 2], [0, 3, 4]], Vec::new()).unwrap();
    for t in &sharp.triangles {
        let up = dot(cast(sharp.normals[0]), normal(t.map(|v| cast(sharp.rest[v as usize]))));
        assert!(up > 0.0, "{t:?}: {up}");
    }
}

#[test]
fn heights_above_a_moved_surface_are_those_above_it_at_rest() {
    let cube = cube();
    // A turn of 90 degrees about z, and a shift.
    let rows = [[0.0, -1.0, 0.0, 0.5], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, -2.0]];
    let (rest, moved) = (Posed::at_rest(&cube), Posed::by_joints(&cube, Skinning::Linear, &[rows]));
    for (p, want) in [([0.0, 0.05, 0.0], -0.05), ([0.3, 0.0, 0.0], 0.2), ([0.2, 0.2, 0.0], 0.02f64.sqrt())] {
        let there = [0.5 - p[1], p[0], p[2] - 2.0];
        for height in [rest.height(p), moved.height(there)] {
            assert!((height - want).abs() < 1e-7, "{p:?}: {height}, not {want}");
        }
    }
    assert_eq!(Posed::by_joints(&cube, Skinning::Linear, &[]).height([0.3, 0.0, 0.0]), rest.height([0.3, 0.0, 0.0]));
}

#[test]
fn a_surface_that_rests_goes_where_a_scene_puts_its_cloth() {
    let mut cloth = crate::Flat::square("sheet", 9).cloth().unwrap();
    cloth.set_body(Some(std::sync::Arc::new(bowl(12)))).unwrap();
    let floors = cloth.worn_on.as_ref().unwrap().floors.clone();
    let heights = |cloth: &Cloth| heights(cloth.body().unwrap(), cloth.positions().iter().copied());
    let before = heights(&cloth);
    // A turn about y, and a shift.
    let by = |[x, y, z]: [f32; 3]| [0.6 * x + 0.8 * z + 3.0, y - 1.0, 0.6 * z - 0.8 * x + 0.5];
    let placed = cloth.positions().iter().map(|p| by(*p)).collect();
    cloth.place(placed).unwrap();
    cloth.carry_body(by).unwrap();
    assert!(before.iter().zip(heights(&cloth)).all(|(a, b)| (a - b).abs() < 1e-5));
    assert_eq!(cloth.worn_on.as_ref().unwrap().floors, floors);
    // A skin knows where the cloth was modelled: heights there are asked for again, and joints take both back.
    let mut cloth = crate::Flat::square("sheet", 9).cloth().unwrap();
    let own = vec![Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] }; cloth.len()];
    let one = std::array::from_fn(|n| f32::from(n % 5 == 0));
    cloth.set_skin(vec![crate::SkinJoint { inverse_bind: one, ..Default::default() }], &own).unwrap();
    let (body, start) = (std::sync::Arc::new(bowl(12)), cloth.positions().to_vec());
    cloth.set_body(Some(body.clone())).unwrap();
    let placed = start.iter().map(|p| by(*p)).collect();
    cloth.place(placed).unwrap();
    cloth.carry_body(by).unwrap();
    assert!(!std::sync::Arc::ptr_eq(cloth.body().unwrap(), &body));
    let moved = cloth.body().cloned();
    cloth.set_body(moved).unwrap();
    let (modelled, kept) = cloth.modelled_on().unwrap();
    assert!(std::sync::Arc::ptr_eq(modelled, &body) && *kept == *floors);
    cloth.follow_joints(&[one]).unwrap();
    assert!(std::sync::Arc::ptr_eq(cloth.body().unwrap(), &body));
    assert!(cloth.positions().iter().zip(&start).all(|(a, b)| (0..3).all(|c| (a[c] - b[c]).abs() < 1e-6)));
}

#[test]
fn loose_cloth_of_a_bundle_keeps_its_cells_away_and_tight_cloth_its_thickness() {
    let thickness = 0.003;
    // Cells of 10 mm, above the top of a cube.
    let kept = |height: f32, has_room: bool| {
        let sheet = crate::Flat::square("sheet", 11);
        let flat = crate::Flat {
            origin: [-0.05, 0.1 + height, -0.05],
            right: [0.1, 0.0, 0.0],
            down: [0.0, 0.0, 0.1],
            ..sheet
        };
        let mut cloth = flat.cloth().unwrap();
        let cube = cube();
        let still = BodySurface::new(cube.rest.clone(), cube.triangles.clone(), Vec::new()).unwrap();
        cloth.set_body(Some(std::sync::Arc::new(still))).unwrap();
        if has_room {
            cloth.keep_room();
        }
        let kept = cloth.clearances(thickness);
        assert!(kept.iter().all(|h| (h - kept[0]).abs() < 1e-6), "{kept:?}");
        kept[0]
    };
    for (height, want) in [(0.1, 0.01), (0.02, 0.005), (0.008, thickness), (0.002, 0.002), (0.0, 0.001)] {
        assert!((kept(height, true) - want).abs() < 1e-6, "{height}: {}, not {want}", kept(height, true));
    }
    assert_eq!(kept(0.1, false), thickness);
}

#[test]
fn cloth_of_a_bundle_has_its_room_and_keeps_it_with_the_same_surface() {
    let cube = cube();
    // Cells of 10 mm, 20 mm above the top of a cube.
    let mut bundle = Bundle::new("test");
    bundle.add_piece("p", 4, 4).unwrap();
    let at = |k: u32| [0.01 * (k % 4) as f32, 0.12, 0.01 * (k / 4) as f32, 1.0];
    let data = (0..16).flat_map(at).collect();
    bundle.insert(0, MapKind::Position, Image { width: 4, height: 4, channels: 4, data }).unwrap();
    bundle.manifest.pieces[0].constants.rest = Some([0.01, 0.01, 0.0, 0.0]);
    bundle.body = Some(Body { positions: cube.rest.clone(), triangles: cube.triangles.clone(), ..Body::default() });
    let mut cloth = Cloth::from_bundle("p", &bundle).unwrap();
    let has = |cloth: &Cloth, want: f32| cloth.clearances(0.003).iter().all(|h| (h - want).abs() < 1e-6);
    assert!(has(&cloth, 0.005), "{:?}", cloth.clearances(0.003));
    let surface = cloth.body().cloned();
    cloth.set_body(surface.clone()).unwrap();
    assert!(has(&cloth, 0.005), "{:?}", cloth.clearances(0.003));
    // A host that gives the cloth another surface sets the thickness.
    cloth.set_body(surface.map(|surface| std::sync::Arc::new((*surface).clone()))).unwrap();
    assert!(has(&cloth, 0.003), "{:?}", cloth.clearances(0.003));
}
