use super::*;
use crate::base::shapes;
use crate::base::surface::Surface;
use crate::stage::layout::Layout;
use std::collections::BTreeMap;

fn bordered(s: &Surface) -> (Disk, Border, Vec<bool>) {
    let rim = shapes::rim(s);
    let mut disk = shapes::opened(s, &[]);
    let border = Border::new(&mut disk, |v| rim[v as usize]);
    (disk, border, rim)
}

#[test]
fn counts_sum_to_the_steps_and_too_few_are_refused() {
    for (name, s) in shapes::all() {
        let (_, border, _) = bordered(&s);
        let least = border.least_steps();
        for steps in (least..least + 40).step_by(2).chain([512]) {
            let count = border.share(steps).unwrap_or_else(|| panic!("{name}: {steps} steps"));
            let sum: u32 = border.segments.iter().map(|s| count[s.group]).sum();
            assert_eq!(sum, steps, "{name}");
            assert!(border.groups.iter().zip(&count).all(|(g, c)| *c >= g.least), "{name}");
            assert_eq!(border.node_steps(&count).len(), border.segments.len());
        }
        if !border.free && least > 8 {
            assert!(border.share(least - 2).is_none(), "{name}");
        }
    }
}

#[test]
fn boundary_vertices_in_one_place_get_places_apart() {
    // All of the boundary in two points, and all of it in one.
    for keep in [1, 0] {
        let mut s = shapes::rectangle(6, 6, 1.0, 1.0);
        let rim = shapes::rim(&s);
        let corner = s.positions[0];
        for v in (1..s.positions.len() - keep).filter(|&v| rim[v]) {
            s.positions[v] = corner;
        }
        let mut disk = shapes::opened(&s, &[]);
        let border = Border::new(&mut disk, |v| rim[v as usize]);
        let count = border.share(64).unwrap();
        let along = border.along(&disk, &count);
        assert!(along.windows(2).all(|w| w[1] - w[0] > 1e-5), "{along:?}");
    }
}

#[test]
fn an_odd_rest_is_shared_with_a_path_of_two_sides() {
    let (_, mut border, _) = bordered(&shapes::tube(12, 8, 0.7));
    for steps in (border.least_steps()..60).step_by(2) {
        // Whatever the lengths.
        for (k, length) in [0.1, 3.0, 7.7].into_iter().enumerate() {
            let n = border.groups.len();
            border.groups[k % n].length = length;
            let count = border.share(steps).unwrap();
            assert_eq!(border.segments.iter().map(|s| count[s.group]).sum::<u32>(), steps);
        }
    }
}

#[test]
fn cut_paths_have_two_sides() {
    for (name, s) in shapes::all() {
        let (disk, border, _) = bordered(&s);
        for (g, group) in border.groups.iter().enumerate() {
            let mine: Vec<&Segment> = border.segments.iter().filter(|s| s.group == g).collect();
            let cut = disk.on_cut[mine[0].first];
            assert_eq!(mine.len(), if cut { 2 } else { 1 }, "{name}");
            assert_eq!(group.members as usize, mine.len());
            assert_eq!(group.rim.is_none(), cut);
        }
    }
}

#[test]
fn texels_of_one_key_are_one_point_and_nodes_are_on_texels() {
    for (name, s) in shapes::all() {
        let (disk, border, rim) = bordered(&s);
        let steps = (border.least_steps() + 20).next_multiple_of(4);
        let (w, h) = (steps / 4, steps / 4);
        let count = border.share(steps).unwrap();
        for shift in [0.0, 3.0] {
            let placed = border
                .place(&disk, &s, &|v| rim[v as usize], &Layout { w, h, shift, count: count.clone(), score: 0.0 })
                .unwrap();
            assert_eq!(placed.texels.len(), steps as usize);
            let mut by_key: BTreeMap<Key, Vec<[f64; 3]>> = BTreeMap::new();
            for (p, t) in placed.texels.iter().enumerate() {
                by_key.entry(t.key).or_default().push(t.position);
                // The texel lies where its triangle says, on the surface and in the plane.
                let tri = placed.disk.triangles[t.triangle as usize];
                let at = on_rectangle(p as f64, w, h);
                for c in 0..3 {
                    let x: f64 = (0..3).map(|k| t.bary[k] * placed.disk.positions[tri[k] as usize][c]).sum();
                    assert!((x - t.position[c]).abs() < 1e-7, "{name}: texel {p}");
                }
                for (c, at) in at.iter().enumerate() {
                    let x: f64 = (0..3).map(|k| t.bary[k] * placed.uv[tri[k] as usize][c]).sum();
                    assert!((x - at).abs() < 1e-9, "{name}: texel {p}: {x} {at}");
                }
            }
            for (key, points) in &by_key {
                assert!(points.iter().all(|p| p == &points[0]), "{name}: {key:?}");
                if let Key::Inner(g, _) = key {
                    assert_eq!(points.len(), border.groups[*g as usize].members as usize, "{name}");
                }
            }
            let nodes = placed.texels.iter().filter(|t| matches!(t.key, Key::Node(_))).count();
            assert_eq!(nodes, if border.free { 0 } else { border.segments.len() }, "{name}");
        }
    }
}

#[test]
fn the_corners_of_a_rectangle_are_its_four_sides() {
    let (disk, border, _) = bordered(&shapes::rectangle(8, 6, 2.0, 1.0));
    assert_eq!(border.segments.len(), 4);
    for s in &border.segments {
        let p = disk.positions[disk.boundary[s.first] as usize];
        assert!((p[0] == 0.0 || p[0] == 2.0) && (p[1] == 0.0 || p[1] == 1.0));
    }
    assert_eq!(border.four_sides(9, 5, false), Some(vec![9, 5, 9, 5]));
    assert_eq!(border.four_sides(9, 5, true), Some(vec![5, 9, 5, 9]));
    // A tube's two cut sides face one another and agree; a torus's four are two pairs of neighbours or opposites.
    let (_, tube, _) = bordered(&shapes::tube(32, 8, 1.0));
    assert!(tube.four_sides(9, 5, false).is_some());
}

#[test]
fn a_smooth_disk_starts_anywhere() {
    let ball = shapes::sphere(24, 12);
    let cap = shapes::without(&ball, |t| ball.corners(t).iter().any(|p| p[1] < -0.3));
    let (_, border, _) = bordered(&cap);
    assert!(border.is_free());
    assert_eq!(border.share(40), Some(vec![40]));
    assert_eq!(border.least_steps(), 8);
}

#[test]
fn the_projective_plane_alone_has_a_loop_of_one_path() {
    let (_, border, _) = bordered(&shapes::projective_plane(2));
    assert!(border.segments.iter().all(|s| !s.reversed) && !border.is_free());
    assert!(border.groups.iter().all(|g| g.members == 2));
}

#[test]
fn fixed_counts_are_kept_and_the_rest_is_shared() {
    for (name, s) in shapes::all() {
        let (_, free, _) = bordered(&s);
        if free.free {
            continue;
        }
        for fixed in 0..free.groups.len() {
            let mut border = free.clone();
            border.fix(fixed, 1, Some(6));
            assert_eq!(border.exact_steps().is_some(), border.groups.len() == 1, "{name}");
            let least = border.least_steps();
            for steps in (least..least + 20).step_by(2) {
                let Some(count) = border.share(steps) else {
                    // Paths of two sides alone cannot make up for a single one of odd count, nor can fixed ones give.
                    let others = border.groups.iter().filter(|g| g.fixed.is_none());
                    assert!(others.clone().count() == 0 || others.clone().all(|g| g.members == 2), "{name}: {steps}");
                    continue;
                };
                assert_eq!(count[fixed], 6, "{name}");
                assert_eq!(border.segments.iter().map(|s| count[s.group]).sum::<u32>(), steps, "{name}");
                assert!(border.groups.iter().zip(&count).all(|(g, c)| *c >= g.least), "{name}");
            }
        }
        // With every count fixed there is one number of steps, and no side may be longer than its path.
        let mut border = free.clone();
        (0..border.groups.len()).for_each(|g| border.fix(g, 1, Some(4)));
        let steps = border.exact_steps().unwrap();
        assert_eq!(steps, 4 * border.segments.len() as u32);
        assert_eq!(border.share(steps), Some(vec![4; border.groups.len()]));
        assert_eq!(border.share(steps + 2), None, "{name}");
        assert_eq!(border.four_sides(5, 4, false), None);
    }
}
