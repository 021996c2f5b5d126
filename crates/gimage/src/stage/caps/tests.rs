use super::*;
use crate::base::mesh::{Channel, Joint, Part, Semantic, Skeleton};
use crate::base::vec3::distance;

/// A tube along y from 0 to 1 m, of 24 vertices around, whose upper end is turned in and closed by a lid, in which a bone from the middle goes up to `top`.
fn sleeve(top: f64, is_bent: bool) -> Mesh {
    let around = 24u32;
    // Radius and height of each ring: the tube, its hem, and the way back inside.
    let mut rings: Vec<[f64; 2]> = (0..=10).map(|j| [0.1, 0.1 * f64::from(j)]).collect();
    rings.extend(match is_bent {
        true => vec![[0.09, 1.0], [0.085, 0.97]],
        // A dome, which bends nowhere sharply.
        false => (1..6).map(|j| (f64::from(j) * 0.25).sin_cos()).map(|(s, c)| [0.1 * c, 1.0 + 0.1 * s]).collect(),
    });
    let mut mesh = Mesh { parts: vec![Part { node: "Sleeve".into(), ..Part::default() }], ..Mesh::default() };
    for [r, y] in &rings {
        let at = |i: u32| f64::from(i) * std::f64::consts::TAU / f64::from(around);
        mesh.positions.extend((0..around).map(|i| [r * at(i).cos(), *y, -r * at(i).sin()]));
    }
    let at = |i: u32, j: u32| j * around + i % around;
    for (i, j) in (0..rings.len() as u32 - 1).flat_map(|j| (0..around).map(move |i| (i, j))) {
        mesh.triangles.extend([[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]]);
    }
    let (last, middle) = (rings.len() as u32 - 1, mesh.positions.len() as u32);
    mesh.positions.push([0.0, rings[last as usize][1], 0.0]);
    mesh.triangles.extend((0..around).map(|i| [at(i, last), at(i + 1, last), middle]));
    mesh.triangle_part = vec![0; mesh.triangles.len()];
    let joint = |y: f64, parent| {
        let mut inverse_bind = crate::import::IDENTITY;
        inverse_bind[13] = -y;
        Joint { name: format!("at {y}"), parent, inverse_bind, world: crate::import::IDENTITY }
    };
    mesh.skeleton = Skeleton { joints: vec![joint(0.5, None), joint(top, Some(0))] };
    let corners = vec![0; 3 * mesh.triangles.len()];
    let channel =
        |semantic, values: &[f32]| Channel { semantic, width: 4, values: values.to_vec(), corners: corners.clone() };
    mesh.channels = vec![channel(Semantic::Joints(0), &[0.0; 4]), channel(Semantic::Weights(0), &[1.0, 0.0, 0.0, 0.0])];
    mesh
}

fn opened(mesh: &Mesh, caps: Caps) -> Opened {
    open_caps(mesh.clone(), &CapsOptions { caps })
}

#[test]
fn a_lid_around_a_bone_is_left_out_with_its_hem() {
    let mesh = sleeve(1.5, true);
    let of = opened(&mesh, Caps::Auto);
    assert_eq!(of.mesh.triangles.len(), 480);
    assert_eq!(of.mesh.channels[0].corners.len(), 3 * 480);
    let [cap] = &of.caps[..] else { panic!("{:?}", of.caps) };
    assert_eq!((cap.triangles.len(), cap.bone.as_deref(), cap.node.as_str()), (48 + 48 + 24, Some("at 1.5"), "Sleeve"));
    assert!((cap.length - 0.1 * std::f64::consts::TAU).abs() < 0.01 && (0.03..0.07).contains(&cap.area), "{cap:?}");
    let finding = of.finding.unwrap();
    assert_eq!((finding.kind, finding.count), ("caps-opened", 1));
    assert!(finding.examples[0].contains("120 triangles"), "{:?}", finding.examples);
    assert_eq!(opened(&mesh, Caps::Keep).mesh, mesh);
}

#[test]
fn the_opening_of_a_lid_is_its_area_and_that_of_a_lining_is_not() {
    let mesh = sleeve(1.5, true);
    let of = |range: std::ops::Range<usize>| {
        let triangle = |t: usize| {
            let [a, b, c] = mesh.corners(t);
            let n = crate::base::vec3::cross(crate::base::vec3::sub(b, a), crate::base::vec3::sub(c, a));
            (mesh.triangle_area(t), crate::base::vec3::normalize(n))
        };
        let area: f64 = range.clone().map(|t| mesh.triangle_area(t)).sum();
        find::opening(range.map(triangle)) / area
    };
    assert!((of(576..600) - 1.0).abs() < 1e-9);
    // Around an arm, without and with a slit.
    assert!(of(0..480) < 1e-9 && of(0..470) < 0.05);
}

#[test]
fn a_lining_behind_a_long_border_is_not_a_cap() {
    // The end of the sleeve goes up and down, and is turned in by 0.3 m.
    let mut mesh = sleeve(1.5, true);
    let ring = |j: usize| 24 * j..24 * (j + 1);
    for v in ring(10).chain(ring(11)) {
        mesh.positions[v][1] += 0.04 * ((v % 24) as f64 / 24.0 * 6.0 * std::f64::consts::TAU).sin();
    }
    for v in ring(12).chain([24 * 13]) {
        mesh.positions[v][1] = 0.7;
    }
    let around: f64 = ring(10).map(|v| distance(mesh.positions[v], mesh.positions[240 + (v + 1) % 24])).sum();
    let area: f64 = (480..mesh.triangles.len()).map(|t| mesh.triangle_area(t)).sum();
    // A flat disk with such a border has more than half of the area.
    assert!(around * around / (4.0 * std::f64::consts::PI) > 0.5 * area);
    assert_eq!(opened(&mesh, Caps::Open).caps, []);
}

#[test]
fn without_a_bone_a_lid_is_cloth_unless_all_are_opened() {
    for mesh in [sleeve(0.9, true), Mesh { skeleton: Skeleton::default(), channels: Vec::new(), ..sleeve(1.5, true) }] {
        let of = opened(&mesh, Caps::Auto);
        assert_eq!((&of.mesh, of.caps.len(), of.finding), (&mesh, 0, None));
        let of = opened(&mesh, Caps::Open);
        assert_eq!((of.mesh.triangles.len(), of.caps.len()), (480, 1));
    }
    // A bone of joints that move none of the garment, as those of a rig's handles.
    let mut mesh = sleeve(1.5, true);
    mesh.skeleton.joints.push(Joint { name: "root".into(), parent: None, ..mesh.skeleton.joints[0].clone() });
    mesh.channels[0].values[0] = 2.0;
    assert_eq!(opened(&mesh, Caps::Auto).caps, []);
}

#[test]
fn rounded_ends_and_ends_with_a_hole_are_not_lids() {
    let dome = sleeve(1.5, false);
    let of = opened(&dome, Caps::Open);
    assert_eq!((&of.mesh, of.caps.len(), of.finding), (&dome, 0, None));
    let mut torn = sleeve(1.5, true);
    torn.triangles.pop();
    torn.triangle_part.pop();
    torn.channels.iter_mut().for_each(|channel| channel.corners.truncate(3 * torn.triangles.len()));
    assert_eq!(opened(&torn, Caps::Open).caps, []);
}
