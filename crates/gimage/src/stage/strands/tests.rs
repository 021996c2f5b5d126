use super::*;
use crate::base::mesh::{Channel, Part, Semantic};
use crate::base::topology::Topology;

type Ring = [[f64; 3]; 4];

/// Cells per side of a sheet of 1 m.
const CELLS: u32 = 80;
/// Side \[m\] of a cell.
const SIDE: f64 = 1.0 / CELLS as f64;

/// A sheet in the plane of x and y that faces z, without the cells whose corners are in the first and the last ring, and a tube through the rings; one
/// whose last ring is not in the sheet ends there, closed if `is_closed`.
fn sheet_with(rings: &[Ring], is_closed: bool) -> Mesh {
    let row = CELLS + 1;
    let mut mesh = Mesh { parts: vec![Part { node: "Hood".into(), ..Part::default() }], ..Mesh::default() };
    let at = |k: u32| f64::from(k) * SIDE;
    mesh.positions = (0..row * row).map(|k| [at(k % row), at(k / row), 0.0]).collect();
    let grid = |p: &[f64; 3]| {
        let on = p[2].abs() < 1e-9;
        on.then(|| (p[1] / SIDE).round() as u32 * row + (p[0] / SIDE).round() as u32)
    };
    let mut corners: Vec<[u32; 4]> = Vec::new();
    for ring in rings {
        corners.push(ring.map(|p| {
            grid(&p).unwrap_or_else(|| {
                mesh.positions.push(p);
                mesh.positions.len() as u32 - 1
            })
        }));
    }
    let is_root = |cell: [u32; 4]| corners.iter().any(|ring| cell.iter().all(|v| ring.contains(v)));
    for k in (0..CELLS * CELLS).map(|k| k / CELLS * row + k % CELLS) {
        let [a, b, c, d] = [k, k + 1, k + row + 1, k + row];
        if !is_root([a, b, c, d]) {
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    for pair in corners.windows(2) {
        for k in 0..4 {
            let [a, b, c, d] = [pair[0][k], pair[0][(k + 1) % 4], pair[1][(k + 1) % 4], pair[1][k]];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    if let Some([a, b, c, d]) = corners.last().filter(|_| is_closed) {
        mesh.triangles.extend([[*a, *b, *c], [*a, *c, *d]]);
    }
    let count = mesh.triangles.len();
    mesh.triangle_part = vec![0; count];
    let corners: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    let values: Vec<f32> = mesh.positions.iter().flat_map(|p| [p[0] as f32, p[1] as f32]).collect();
    mesh.channels = vec![Channel { semantic: Semantic::TexCoord(0), width: 2, values, corners }];
    mesh
}

/// Rings of a tube that stands on the cell in the middle, by their heights \[m\].
fn upright(heights: impl Iterator<Item = f64>) -> Vec<Ring> {
    let [low, high] = [40.0, 41.0].map(|k| k * SIDE);
    heights.map(|z| [[low, low, z], [high, low, z], [high, high, z], [low, high, z]]).collect()
}

fn string(length: f64) -> Vec<Ring> {
    upright((0..=20).map(|k| length * f64::from(k) / 20.0))
}

fn left(mesh: &Mesh) -> Stripped {
    leave_strands(mesh.clone(), &StrandsOptions::default())
}

#[test]
fn a_string_is_left_out_and_its_root_is_closed() {
    let mesh = sheet_with(&string(0.2), true);
    assert!(Topology::of(&mesh.triangles).is_oriented_manifold());
    let of = left(&mesh);
    let [strand] = &of.strands[..] else { panic!("{:?}", of.strands) };
    assert_eq!((strand.triangles.len(), strand.node.as_str()), (162, "Hood"));
    assert!((strand.around - 4.0 * SIDE).abs() < 1e-9 && (0.2..0.3).contains(&strand.length), "{strand:?}");
    // A sheet again, whose last triangles have the attributes of the cells around them.
    let plain = (CELLS * CELLS * 2) as usize;
    assert_eq!((of.mesh.triangles.len(), of.mesh.channels[0].corners.len()), (plain, 3 * plain));
    let topology = Topology::of(&of.mesh.triangles);
    assert!(topology.is_oriented_manifold() && (topology.euler, topology.boundary_loops) == (1, 1), "{topology:?}");
    for t in plain - 2..plain {
        for (c, v) in of.mesh.triangles[t].into_iter().enumerate() {
            let p = of.mesh.positions[v as usize];
            assert_eq!(of.mesh.channels[0].at(t, c).unwrap(), [p[0] as f32, p[1] as f32]);
        }
    }
    assert!((0..plain).all(|t| of.mesh.triangle_area(t) > 0.4 * SIDE * SIDE));
    let finding = of.finding.unwrap();
    assert_eq!((finding.kind, finding.count), ("strands-left-out", 1));
    assert!(finding.examples[0].contains("Hood: 162 triangles"), "{:?}", finding.examples);
    let kept = leave_strands(mesh.clone(), &StrandsOptions { strands: Strands::Keep });
    assert_eq!((kept.mesh, kept.finding), (mesh, None));
}

#[test]
fn a_string_with_an_open_end_is_one_too() {
    let of = left(&sheet_with(&string(0.2), false));
    assert_eq!(of.strands.iter().map(|s| s.triangles.len()).collect::<Vec<_>>(), [160]);
    assert_eq!(Topology::of(&of.mesh.triangles).boundary_loops, 1);
}

#[test]
fn fingers_trumpets_and_straps_stay() {
    // A tube whose open end is wide, as a sleeve may be.
    let middle = [40.5 * SIDE, 40.5 * SIDE];
    let mut wide = string(0.2);
    let end = wide[20].map(|[x, y, z]| [middle[0] + 6.0 * (x - middle[0]), middle[1] + 6.0 * (y - middle[1]), z]);
    wide[20] = end;
    let trumpet = sheet_with(&wide, false);
    assert_eq!(left(&trumpet).mesh, trumpet);
    // As long as around.
    let finger = sheet_with(&string(4.0 * SIDE), true);
    assert_eq!(left(&finger).mesh, finger);
    // A strap has two roots.
    let (radius, turn) = (5.0 * SIDE, std::f64::consts::PI / 24.0);
    let arch: Vec<Ring> = (0..=24)
        .map(|k| {
            let (s, c) = (turn * f64::from(k)).sin_cos();
            let out = |r: f64, y: f64| [0.5 + 0.5 * SIDE - r * c, y, r * s];
            let (inner, outer) = (radius - 0.5 * SIDE, radius + 0.5 * SIDE);
            let [low, high] = [40.0, 41.0].map(|k| k * SIDE);
            [out(outer, low), out(inner, low), out(inner, high), out(outer, high)]
        })
        .collect();
    let strap = sheet_with(&arch, false);
    let topology = Topology::of(&strap.triangles);
    assert!(topology.is_oriented_manifold() && topology.boundary_loops == 1 && topology.euler == -1, "{topology:?}");
    assert_eq!(left(&strap).mesh, strap);
    // A flat sheet alone.
    let flat = sheet_with(&[], false);
    assert_eq!(left(&flat).mesh, flat);
}
