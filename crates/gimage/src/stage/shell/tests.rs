use std::f64::consts::TAU;

use super::*;
use crate::base::mesh::Part;
use crate::base::shapes::{self, Join, sheet};
use crate::base::surface::Surface;
use crate::base::topology::Topology;
use crate::base::vec3::norm;
use crate::stage::repair::{RepairOptions, repair};

/// Surfaces as parts of one repaired mesh.
fn mesh(surfaces: &[(&str, &Surface)]) -> Mesh {
    let mut mesh = Mesh::default();
    for (name, surface) in surfaces {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(&surface.positions);
        mesh.triangles.extend(surface.triangles.iter().map(|t| t.map(|v| v + first)));
        mesh.triangle_part.resize(mesh.triangles.len(), mesh.parts.len() as u32);
        mesh.parts.push(Part { node: (*name).into(), ..Part::default() });
    }
    repair(mesh, &RepairOptions::default()).unwrap().mesh
}

fn thinned(mesh: &Mesh) -> Thinned {
    let out = thin(mesh.clone(), &ShellOptions::default(), &ComponentOptions::default());
    assert_eq!(out.shell_of.len(), if out.shells.is_empty() { 0 } else { out.mesh.triangles.len() });
    out
}

/// That nothing changes, with a warning or without.
fn stays(mesh: &Mesh, is_doubtful: bool) -> Vec<Finding> {
    let out = thinned(mesh);
    assert!(&out.mesh == mesh, "{:?}", out.findings);
    let kinds: Vec<_> = out.findings.iter().map(|f| f.kind).collect();
    assert_eq!(kinds, vec!["thin-shell-kept"; usize::from(is_doubtful)], "{:?}", out.findings);
    out.findings
}

fn turned(mut s: Surface) -> Surface {
    s.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    s
}

/// Two surfaces as one, their vertices apart.
fn both(mut a: Surface, b: &Surface) -> Surface {
    let first = a.positions.len() as u32;
    a.positions.extend(&b.positions);
    a.triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + first)));
    shapes::surface(a.positions, a.triangles)
}

/// Joins two rows of vertices that run the same way, of any numbers of vertices, by a strip of triangles.
fn strip(a: &[u32], b: &[u32], is_turned: bool) -> Vec<[u32; 3]> {
    let (mut i, mut j, mut out) = (0, 0, Vec::new());
    while i + 1 < a.len() || j + 1 < b.len() {
        let along_a = j + 1 == b.len() || (i + 1 < a.len() && (i + 1) * (b.len() - 1) <= (j + 1) * (a.len() - 1));
        out.push(if along_a { [a[i], a[i + 1], b[j]] } else { [b[j], a[i], b[j + 1]] });
        if along_a { i += 1 } else { j += 1 }
    }
    if is_turned {
        out.iter_mut().for_each(|t| t.swap(1, 2));
    }
    out
}

/// A tube around y with a thickness: `outer` and `inner` cells around and along, the distance of the sheets by the angle.
fn thick_tube(outer: [u32; 2], inner: [u32; 2], radius: f64, gap: impl Fn(f64) -> f64) -> Surface {
    let wall = |cells: [u32; 2], inside: f64| {
        sheet(cells[0], cells[1], Join::Same, Join::Open, |u, v| {
            let r = radius - inside * gap(TAU * u);
            [r * (TAU * u).cos(), v, -r * (TAU * u).sin()]
        })
    };
    let mut s = both(wall(outer, 0.0), &turned(wall(inner, 1.0)));
    let first = outer[0] * (outer[1] + 1);
    let ring = |first: u32, n: u32, row: u32| (0..=n).map(|k| first + row * n + k % n).collect::<Vec<_>>();
    s.triangles.extend(strip(&ring(0, outer[0], 0), &ring(first, inner[0], 0), true));
    s.triangles.extend(strip(&ring(0, outer[0], outer[1]), &ring(first, inner[0], inner[1]), false));
    shapes::surface(s.positions, s.triangles)
}

/// A box around the origin with its smallest side along z, and a rim of `rim` strips.
fn plate(cells: u32, size: [f64; 3], rim: u32) -> Surface {
    let mut all = Surface::default();
    for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let count = |k: usize| if k == 2 { rim } else { cells };
        let face = sheet(count(i), count(j), Join::Open, Join::Open, |u, v| {
            let mut p = [0.0; 3];
            p[axis] = 0.5 * sign * size[axis];
            p[i] = (u - 0.5) * size[i];
            p[j] = (v - 0.5) * size[j];
            p
        });
        all = both(all, &if sign > 0.0 { face } else { turned(face) });
    }
    all
}

#[test]
fn a_tube_with_a_thickness_becomes_the_tube_between_its_walls() {
    let gap = |a: f64| 0.002 + 0.001 * a.sin();
    let solid = mesh(&[("sleeve", &thick_tube([48, 20], [37, 13], 0.1, gap))]);
    assert_eq!(Topology::of(&solid.triangles).boundary_edges, 0);
    let out = thinned(&solid);
    let topology = Topology::of(&out.mesh.triangles);
    assert_eq!((topology.euler, topology.boundary_loops, topology.components), (0, 2, 1), "{:?}", out.findings);
    assert_eq!((out.mesh.triangles.len(), out.shells.len()), (2 * 48 * 20, 1));
    for p in &out.mesh.positions {
        let middle = 0.1 - 0.5 * gap((-p[2]).atan2(p[0]));
        // The chords of the coarser wall lie up to 0.4 mm inside of the circle.
        assert!(((p[0].hypot(p[2])) - middle).abs() < 3e-4, "{p:?} {middle}");
    }
    let shell = &out.shells[0];
    assert!((shell.thickness - 0.002).abs() < 3e-4 && shell.range[0] < 0.0015 && shell.range[1] > 0.0025, "{shell:?}");
    assert!(shell.share > 0.95 && (shell.bound_area - 0.6).abs() < 0.05, "{shell:?}");
}

/// A sleeve of `cells` quads around with a share of 0.67 that faces another sheet: `ridges` around it are padded, to more than three times the median
/// thickness.
fn padded(ridges: f64, cells: u32) -> Mesh {
    let gap = move |a: f64| 0.002 + 0.008 * (((ridges * a).cos() - 0.4) / 0.2).clamp(0.0, 1.0);
    mesh(&[("sleeve", &thick_tube([cells, 20], [cells, 13], 0.1, gap))])
}

#[test]
fn a_shell_that_would_fall_into_stripes_between_padding_is_kept_with_a_warning() {
    let findings = stays(&padded(5.0, 120), true);
    assert!(findings[0].examples[0].contains("would fall apart"), "{findings:?}");
}

#[test]
fn padding_whose_inner_sheet_would_be_loose_is_kept() {
    stays(&padded(1.0, 120), false);
}

#[test]
fn padded_sleeves_come_out_as_one_whole_layer_or_stay_as_they_are() {
    let mut thinner = 0;
    for (ridges, cells) in [6.0, 7.0, 12.0, 14.0, 20.0, 30.0].into_iter().flat_map(|r| [100, 120, 240].map(|c| (r, c)))
    {
        let sleeve = padded(ridges, cells);
        let out = thinned(&sleeve);
        if out.mesh == sleeve {
            continue;
        }
        let topology = Topology::of(&out.mesh.triangles);
        let (parts, loops) = (topology.components, topology.boundary_loops);
        assert_eq!((parts, loops, topology.euler), (1, 2, 0), "{ridges}, {cells}: {:?}", out.findings);
        thinner += 1;
    }
    assert!(thinner > 5, "{thinner}");
}

#[test]
fn pleats_of_which_no_sheet_would_be_left_are_kept() {
    // One sheet in pleats that fold back over one another: it faces itself all over, and all of it is labelled as rim.
    let pleats = sheet(1440, 24, Join::Same, Join::Open, |u, v| {
        let pleat = (60.0 * u).fract();
        let r = 0.13 + 0.28 * v + (0.02 + 0.05 * v) * (1.0 - (2.0 * pleat - 1.0).abs());
        let a = TAU * u + 1.4 * TAU / 60.0 * (TAU * pleat).sin() * v;
        [r * a.cos(), 1.0 - 0.75 * v, r * a.sin()]
    });
    let out = thinned(&mesh(&[("skirt", &pleats)]));
    assert_eq!(out.mesh.triangles.len(), pleats.triangles.len(), "{:?}", out.findings);
}

#[test]
fn the_outer_sheet_stays_in_place_on_request_and_both_sheets_are_kept_on_request() {
    let solid = mesh(&[("sleeve", &thick_tube([32, 10], [24, 9], 0.1, |_| 0.002))]);
    let options = |shell| ShellOptions { shell };
    let out = thin(solid.clone(), &options(Layer::Outer), &ComponentOptions::default());
    assert!(out.mesh.positions.iter().all(|p| (p[0].hypot(p[2]) - 0.1).abs() < 1e-12));
    assert_eq!(out.mesh.triangles.len(), 640);
    let out = thin(solid.clone(), &options(Layer::Keep), &ComponentOptions::default());
    assert!(out.mesh == solid && out.findings.is_empty());
}

#[test]
fn a_solid_that_is_inside_out_is_a_shell_too() {
    let out = thinned(&mesh(&[("sleeve", &turned(thick_tube([32, 10], [24, 9], 0.1, |_| 0.002)))]));
    assert_eq!(out.mesh.triangles.len(), 640, "{:?}", out.findings);
    assert!(out.mesh.positions.iter().all(|p| (p[0].hypot(p[2]) - 0.099).abs() < 6e-4));
}

#[test]
fn a_hole_in_the_inner_sheet_alone_does_not_matter() {
    let solid = thick_tube([40, 20], [40, 20], 0.1, |_| 0.002);
    let inner = 2 * 40 * 20;
    let hole =
        |t: usize| (inner..2 * inner).contains(&t) && (6..12).contains(&((t - inner) / 80)) && (t - inner) % 80 < 24;
    let holed = shapes::without(&solid, hole);
    let out = thinned(&mesh(&[("sleeve", &holed)]));
    let topology = Topology::of(&out.mesh.triangles);
    assert_eq!(
        (out.mesh.triangles.len(), topology.euler, topology.boundary_loops),
        (inner, 0, 2),
        "{:?}",
        out.findings
    );
    assert!(out.mesh.positions.iter().all(|p| (p[0].hypot(p[2]) - 0.099).abs() < 3e-4));
}

#[test]
fn thick_panels_become_flat_sheets() {
    for thickness in [0.001, 0.005] {
        for (cells, rim) in [(1, 1), (4, 1), (12, 3)] {
            let solid = mesh(&[("panel", &plate(cells, [0.4, 0.3, thickness], rim))]);
            let out = thinned(&solid);
            let topology = Topology::of(&out.mesh.triangles);
            assert_eq!((topology.euler, topology.boundary_loops), (1, 1), "{cells}: {:?}", out.findings);
            assert!(out.mesh.positions.iter().all(|p| p[2].abs() < 1e-9), "{cells}");
            let area: f64 = (0..out.mesh.triangles.len()).map(|t| out.mesh.triangle_area(t)).sum();
            assert!((area - 0.12).abs() < 1e-9 && (out.shells[0].thickness - thickness).abs() < 1e-9, "{area}");
        }
    }
}

#[test]
fn solids_and_single_layers_stay() {
    for (name, s) in [
        ("ball", shapes::sphere(24, 16)),
        ("blob", shapes::blob(3, 12, 0)),
        ("torus", shapes::torus(24, 12)),
        ("box", plate(4, [0.4, 0.3, 0.2], 2)),
        ("sole", plate(6, [0.27, 0.09, 0.02], 2)),
        ("sheet", shapes::rectangle(9, 9, 0.5, 0.5)),
        ("tube", shapes::tube(16, 8, 1.0)),
        ("moebius", shapes::moebius(40, 6)),
        ("square rope", plate(20, [1.0, 0.002, 0.002], 1)),
    ] {
        stays(&mesh(&[(name, &s)]), false);
    }
}

/// As welding leaves it that is coarser than the fabric is thick.
#[test]
fn a_part_of_one_layer_stays_where_both_sheets_end_in_it() {
    let mut plate = plate(24, [0.6, 0.4, 0.004], 1);
    let is_seam = |p: &[f64; 3]| p[0] > 0.299 && p[1].abs() < 0.03;
    plate.positions.iter_mut().filter(|p| is_seam(p)).for_each(|p| p[2] = 0.0);
    let mut seam: Vec<u32> =
        (0..plate.positions.len() as u32).filter(|&v| is_seam(&plate.positions[v as usize])).collect();
    seam.sort_by(|&a, &b| plate.positions[a as usize][1].total_cmp(&plate.positions[b as usize][1]));
    // The faces of the plate have vertices of their own.
    seam.dedup_by_key(|v| plate.positions[*v as usize][1]);
    for pair in seam.windows(2) {
        let first = plate.positions.len() as u32;
        let far = [0, 1].map(|k| add(plate.positions[pair[k] as usize], [1.0, 0.0, 0.0]));
        plate.positions.extend(far);
        plate.triangles.extend([[pair[0], first, first + 1], [pair[0], first + 1, pair[1]]]);
    }
    let count = 2 * (seam.len() - 1);
    let out = thinned(&mesh(&[("plate", &plate)]));
    let on_flap = |t: &&[u32; 3]| t.iter().any(|&v| out.mesh.positions[v as usize][0] > 0.35);
    assert_eq!(out.mesh.triangles.iter().filter(on_flap).count(), count, "{:?}", out.findings);
    assert!(out.shells.len() == 1 && out.shells[0].alone == count, "{:?}", out.findings);
    assert!(out.mesh.triangles.len() < 1200 && out.shell_of.iter().all(|&k| k == 0), "{:?}", out.findings);
    let words = format!("{count} of one layer among them");
    assert!(out.findings[0].examples[0].ends_with(&words), "{:?}", out.findings);
}

/// The needles around a vertex far off the others face one another, and have most of the area.
#[test]
fn spikes_are_not_the_sheets_of_a_shell() {
    let mut draw = shapes::random(5);
    for _ in 0..60 {
        let mut spiked = shapes::tube(24, 12, 1.0);
        for _ in 0..8 {
            let v = draw(spiked.positions.len());
            spiked.positions[v] = [0, 1, 2].map(|_| draw(2000) as f64 / 100.0 - 10.0);
        }
        stays(&mesh(&[("spiked", &spiked)]), false);
    }
}

#[test]
fn two_facing_sheets_become_one() {
    let place = |u: f64, v: f64, z: f64| [0.5 * u, 0.5 * v, z + 0.02 * (6.0 * u).sin()];
    let outer = sheet(28, 9, Join::Open, Join::Open, |u, v| place(u, v, 0.0));
    let lining = turned(sheet(20, 16, Join::Open, Join::Open, |u, v| place(u, v, -0.002)));
    let out = thinned(&mesh(&[("outer", &outer), ("lining", &lining)]));
    assert_eq!((out.shells.len(), Topology::of(&out.mesh.triangles).components), (1, 1), "{:?}", out.findings);
    for p in &out.mesh.positions {
        assert!((p[2] + 0.001 - 0.02 * (12.0 * p[0]).sin()).abs() < 4e-4, "{p:?}");
    }
    // So far apart, they may be the front and the back of a garment laid flat.
    let far = turned(sheet(9, 16, Join::Open, Join::Open, |u, v| place(u, v, -0.01)));
    let findings = stays(&mesh(&[("front", &outer), ("back", &far)]), true);
    assert!(findings[0].examples[0].contains("laid flat"), "{findings:?}");
}

#[test]
fn a_lining_of_a_part_is_kept_with_a_warning() {
    let outer = shapes::rectangle(20, 20, 0.6, 0.6);
    let mut lining = turned(shapes::rectangle(9, 9, 0.6, 0.3));
    lining.positions.iter_mut().for_each(|p| p[2] -= 0.002);
    let findings = stays(&mesh(&[("outer", &outer), ("lining", &lining)]), true);
    assert!(findings[0].examples[0].contains("covers only 50 % of outer"), "{findings:?}");
}

#[test]
fn a_garment_laid_flat_is_not_a_shell() {
    // An open tube pressed flat: its two openings run along both sides.
    let flat = sheet(40, 12, Join::Same, Join::Open, |u, v| {
        let (half, back) = if u < 0.5 { (2.0 * u, 1.0) } else { (2.0 - 2.0 * u, -1.0) };
        let z = 0.004 * back * (8.0 * half.min(1.0 - half)).min(1.0);
        [0.5 * half, 0.7 * v, z]
    });
    let out = thinned(&mesh(&[("shirt", &turned(flat))]));
    assert!(out.shells.is_empty(), "{:?}", out.findings);
    assert!(out.findings[0].examples[0].contains("laid flat"), "{:?}", out.findings);
}

#[test]
fn thick_fabric_around_a_body_is_a_shell_where_borders_run_along_both_sheets() {
    // Open along a slit without a rim, as programs export sewn panels: the borders are those of a garment laid flat, which does not go around.
    let mut tube = thick_tube([48, 20], [37, 13], 0.1, |_| 0.002);
    let angle = |v: u32| tube.positions[v as usize][2].atan2(tube.positions[v as usize][0]);
    let open: Vec<bool> = tube.triangles.iter().map(|t| t.iter().any(|v| angle(*v).abs() < 0.2)).collect();
    let mut at = 0..;
    tube.triangles.retain(|_| !open[at.next().unwrap()]);
    let out = thinned(&mesh(&[("dress", &tube)]));
    let topology = Topology::of(&out.mesh.triangles);
    assert_eq!((out.shells.len(), topology.components, topology.boundary_loops), (1, 1, 1), "{:?}", out.findings);
}

#[test]
fn stacked_shells_are_shells_each_and_a_patch_on_one_stays() {
    let panel = |z: f64| {
        let mut s = plate(8, [0.4, 0.3, 0.002], 1);
        s.positions.iter_mut().for_each(|p| p[2] += z);
        s
    };
    let mut logo = shapes::rectangle(5, 5, 0.2, 0.1);
    logo.positions.iter_mut().for_each(|p| p[2] += 0.00101);
    let mut all = mesh(&[("upper", &panel(0.0)), ("lower", &panel(-0.0021)), ("logo", &logo)]);
    all = thinned(&all).mesh;
    let mut heights: Vec<i64> = all.positions.iter().map(|p| (p[2] * 1e5).round() as i64).collect();
    heights.sort_unstable();
    heights.dedup();
    assert_eq!(heights, [-210, 0, 101]);
    assert_eq!(Topology::of(&all.triangles).components, 3);
}

#[test]
fn attributes_are_those_of_the_sheet_that_stays() {
    use crate::base::mesh::{Channel, Semantic};
    let mut solid = mesh(&[("sleeve", &thick_tube([32, 10], [24, 9], 0.1, |_| 0.002))]);
    let corners = 3 * solid.triangles.len() as u32;
    // The attribute of a corner is the radius of its vertex.
    let radius = |c: u32| {
        let p = solid.positions[solid.triangles[c as usize / 3][c as usize % 3] as usize];
        norm([p[0], 0.0, p[2]]) as f32
    };
    let values = (0..corners).map(radius).collect();
    solid.channels =
        vec![Channel { semantic: Semantic::Custom("_R".into()), width: 1, values, corners: (0..corners).collect() }];
    let out = thinned(&solid);
    let channel = &out.mesh.channels[0];
    assert_eq!(channel.corners.len(), 3 * out.mesh.triangles.len());
    for t in 0..out.mesh.triangles.len() {
        assert!((0..3).all(|c| (channel.at(t, c).unwrap()[0] - 0.1).abs() < 1e-6));
    }
}

#[test]
fn the_order_of_the_file_changes_neither_sheet_nor_place() {
    let solid = mesh(&[("sleeve", &thick_tube([24, 8], [19, 7], 0.1, |a| 0.002 + 5e-4 * a.cos()))]);
    let mut other = solid.clone();
    let n = other.positions.len() as u32;
    other.positions.reverse();
    other.triangles.iter_mut().for_each(|t| *t = t.map(|v| n - 1 - v));
    other.triangles.reverse();
    let places = |m: &Mesh| {
        let mut all: Vec<[i64; 3]> = m.positions.iter().map(|p| p.map(|x| (x * 1e9).round() as i64)).collect();
        all.sort_unstable();
        all
    };
    assert_eq!(places(&thinned(&solid).mesh), places(&thinned(&other).mesh));
}

/// Surfaces as triangles of one component, none of which faces another.
fn of_one_component(surfaces: &[Surface]) -> (Mesh, Zone) {
    let all = surfaces.iter().cloned().reduce(|a, b| both(a, &b)).unwrap();
    let mesh = mesh(&[("all", &all)]);
    let n = mesh.triangles.len();
    let zone = Zone {
        source: (0..n as u32).collect(),
        triangles: mesh.triangles.clone(),
        component: vec![0; n],
        area: (0..n).map(|t| mesh.triangle_area(t)).collect(),
        normal: vec![[0.0; 3]; n],
        gap: vec![f64::INFINITY; n],
        is_narrow: vec![false; n],
        pairs: Vec::new(),
    };
    (mesh, zone)
}

#[test]
fn fabric_that_is_doubled_does_not_make_a_sheet_fall_apart() {
    let tube = |radius: f64, low: f64, high: f64| {
        sheet(48, 12, Join::Same, Join::Open, |u, v| {
            let (sin, cos) = (TAU * u).sin_cos();
            [radius * cos, low + (high - low) * v, radius * sin]
        })
    };
    // A hem of a fifth of the height, turned over to the inside; and a second sleeve below the first one.
    let (sleeve, hem, below) = (tube(0.1, 0.0, 0.5), tube(0.096, 0.0, 0.1), tube(0.1, -0.3, -0.002));
    let over = |surfaces: &[Surface], thickness: f64| {
        let (mesh, zone) = of_one_component(surfaces);
        let stay = (0..zone.triangles.len() as u32).collect();
        doubled::doubled(&zone, &sides::sides(&zone), &mesh.positions, &stay, thickness)
    };
    let of_hem: Vec<u32> = (2 * 48 * 12..4 * 48 * 12).collect();
    assert_eq!(over(&[sleeve.clone(), hem.clone()], 0.001), Some(of_hem));
    assert_eq!(over(&[sleeve.clone(), hem.clone()], 0.0005), None, "4 mm are too far for fabric of 0.5 mm");
    assert_eq!(over(&[sleeve.clone(), below.clone()], 0.001), None);
    assert_eq!(over(&[sleeve.clone(), hem, below], 0.001), None);
    assert_eq!(over(&[sleeve], 0.001), Some(Vec::new()));
}
