use std::path::Path;

use super::*;
use crate::base::mesh::Part;
use crate::base::shapes::{self, Join};
use crate::base::surface::Surface;
use crate::error::Error;

/// Surfaces as parts of one mesh, each moved along x.
fn list_of(surfaces: &[(&str, Surface, f64)]) -> Contents {
    list_as(surfaces, &BuildOptions::default())
}

/// The same with both sheets of thin shells.
fn list_kept(surfaces: &[(&str, Surface, f64)]) -> Contents {
    list_as(surfaces, &BuildOptions { shell: ShellOptions { shell: Layer::Keep }, ..BuildOptions::default() })
}

fn list_as(surfaces: &[(&str, Surface, f64)], options: &BuildOptions) -> Contents {
    let mut mesh = Mesh::default();
    for (name, surface, x) in surfaces {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(surface.positions.iter().map(|p| [p[0] + x, p[1], p[2]]));
        mesh.triangles.extend(surface.triangles.iter().map(|t| t.map(|v| v + first)));
        mesh.triangle_part.resize(mesh.triangles.len(), mesh.parts.len() as u32);
        mesh.parts.push(Part { node: (*name).into(), ..Part::default() });
    }
    let (source, scene, origins, findings) = Default::default();
    let imported = Imported { mesh, source, scene, origins, transform: [0.0; 16], findings };
    contents(Path::new("test.obj"), imported, options).unwrap()
}

/// A box around the origin, `cells` cells per side of its faces.
fn cuboid(cells: u32, size: [f64; 3]) -> Surface {
    banded(cells, cells, size)
}

/// A box with `bands` cells along z.
fn banded(cells: u32, bands: u32, size: [f64; 3]) -> Surface {
    let mut all = Surface::default();
    for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let count = |k: usize| if k == 2 { bands } else { cells };
        let face = shapes::sheet(count(i), count(j), Join::Open, Join::Open, |u, v| {
            let mut p = [0.0; 3];
            p[axis] = 0.5 * sign * size[axis];
            p[i] = (u - 0.5) * size[i];
            p[j] = (v - 0.5) * size[j];
            p
        });
        let first = all.positions.len() as u32;
        all.positions.extend(&face.positions);
        let turn = |t: &[u32; 3]| if sign > 0.0 { *t } else { [t[0], t[2], t[1]] };
        all.triangles.extend(face.triangles.iter().map(turn).map(|t| t.map(|v| v + first)));
    }
    all
}

fn flipped(mut s: Surface, z: f64) -> Surface {
    s.positions.iter_mut().for_each(|p| p[2] += z);
    s.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    s
}

fn kinds(contents: &Contents) -> Vec<(&str, Kind)> {
    contents.components.iter().map(|c| (c.name.as_str(), c.kind)).collect()
}

#[test]
fn a_sheet_is_open_and_its_loop_is_measured() {
    let out = list_of(&[("sheet", shapes::rectangle(8, 4, 0.6, 0.4), 0.0)]);
    assert_eq!(kinds(&out), [("sheet", Kind::OpenSurface)]);
    let rim = &out.components[0].loops[0];
    assert!((rim.length - 2.0).abs() < 1e-12 && rim.edges == 24 && rim.pin == Some(0), "{rim:?}");
    assert_eq!(rim.height, [0.0, 0.4]);
    let size = out.size;
    assert_eq!((size.triangles, size.vertices, size.extent()), (64, 45, [0.6, 0.4, 0.0]));
    assert!((size.area - 0.24).abs() < 1e-12);
}

#[test]
fn a_sphere_and_a_tube_are_no_thin_shells() {
    let out = list_of(&[("ball", shapes::sphere(16, 12), 0.0), ("tube", shapes::tube(16, 8, 1.0), 5.0)]);
    let mut found = kinds(&out);
    found.sort_by_key(|k| k.0);
    assert_eq!(found, [("ball", Kind::ClosedShell), ("tube", Kind::OpenSurface)]);
    assert_eq!(out.components.iter().map(|c| c.loops.len()).sum::<usize>(), 2);
    let pins: Vec<_> = out.components.iter().flat_map(|c| &c.loops).map(|l| l.pin).collect();
    assert_eq!(pins, [Some(0), Some(1)]);
}

#[test]
fn a_box_of_a_millimetre_is_a_thin_shell() {
    for cells in [1, 3, 12] {
        let panel = [("panel", cuboid(cells, [0.4, 0.3, 0.001]), 0.0)];
        for (out, loops) in [(list_kept(&panel), 0), (list_of(&panel), 1)] {
            assert_eq!(kinds(&out), [("panel", Kind::ThinShell)], "{cells} cells");
            let c = &out.components[0];
            assert!((c.thickness.unwrap() - 0.001).abs() < 1e-9 && c.other_sheet.is_none(), "{c:?}");
            assert_eq!(c.loops.len(), loops);
        }
    }
    // Its rim has most of the triangles, and 8 % of the area.
    let out = list_kept(&[("panel", banded(3, 50, [0.4, 0.3, 0.015]), 0.0)]);
    assert_eq!(kinds(&out), [("panel", Kind::ThinShell)]);
    assert_eq!(kinds(&list_of(&[("box", cuboid(4, [0.4, 0.3, 0.2]), 0.0)])), [("box", Kind::ClosedShell)]);
}

#[test]
fn two_facing_sheets_are_a_thin_shell() {
    let outer = shapes::rectangle(9, 9, 0.5, 0.5);
    let sheets = [("outer", outer.clone(), 0.0), ("lining", flipped(outer.clone(), -0.002), 0.0)];
    // A build makes one layer of them.
    assert_eq!(kinds(&list_of(&sheets)), [("outer", Kind::ThinShell)]);
    let out = list_kept(&sheets);
    assert_eq!(kinds(&out), [("outer", Kind::ThinShell), ("lining", Kind::ThinShell)]);
    assert!(out.components.iter().all(|c| (c.thickness.unwrap() - 0.002).abs() < 1e-9));
    assert_eq!(out.components[0].other_sheet.as_deref(), Some("lining"));
    // A pocket that lies on the cloth does not face it, nor do sheets that lie far apart.
    let pocket = {
        let p = flipped(outer.clone(), 0.002);
        flipped(p, 0.0)
    };
    let out = list_of(&[("outer", outer.clone(), 0.0), ("pocket", pocket, 0.0), ("far", flipped(outer, -0.3), 0.0)]);
    assert!(out.components.iter().all(|c| c.kind == Kind::OpenSurface), "{:?}", kinds(&out));
}

#[test]
fn a_button_is_a_crumb() {
    let button = cuboid(2, [0.01, 0.01, 0.003]);
    let out = list_of(&[("button", button, 0.0), ("shirt", shapes::rectangle(8, 8, 0.7, 0.7), 1.0)]);
    assert_eq!(kinds(&out), [("shirt", Kind::OpenSurface), ("button", Kind::Crumb)]);
    assert_eq!(
        (out.parts[0].node.as_str(), out.parts[0].size.triangles, out.parts[0].size.vertices),
        ("button", 48, 26)
    );
}

#[test]
fn parts_that_are_left_out_are_listed_without_pins() {
    let mut options = BuildOptions::default();
    options.select.cloth = vec!["sh*".parse().unwrap()];
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("two.obj");
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nv 3 0 0\nv 2 2 0\no shirt\nusemtl red\nf 1 2 3\no head\nf 4 5 6\n";
    std::fs::write(&path, text).unwrap();
    let out = list(&path, &options).unwrap();
    assert_eq!(out.parts.iter().map(|p| p.verdict.role).collect::<Vec<_>>(), [Role::Cloth, Role::Other]);
    assert_eq!((out.components[0].name.as_str(), out.components[0].loops[0].pin), ("shirt", Some(0)));
    assert_eq!((out.components[1].role, out.components[1].loops[0].pin), (Role::Other, None));
    assert_eq!(out, list(&path, &options).unwrap());
    options.select.cloth = vec!["skirt".parse().unwrap()];
    assert!(matches!(list(&path, &options), Err(Error::Option { .. })));
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n").unwrap();
    assert!(matches!(list(&path, &BuildOptions::default()), Err(Error::Empty { .. })));
}
