use super::*;
use crate::base::mesh::{Channel, Joint, Part, Semantic, Skeleton};
use crate::record::Severity;

/// One triangle per part, each named as told; weights of two joints per part, or none.
fn mesh(parts: &[(&str, &str, Option<[f32; 4]>)]) -> Mesh {
    let n = parts.len() as u32;
    let corners = |k: u32| [[0., 0.], [1., 0.], [0., 1.]].map(|[x, y]| [x + 2.0 * f64::from(k), y, 0.0]);
    let joint = Joint { name: String::new(), parent: None, inverse_bind: [0.0; 16], world: [0.0; 16] };
    let values = |semantic, f: &dyn Fn(usize) -> [f32; 4]| Channel {
        semantic,
        width: 4,
        values: (0..parts.len()).flat_map(f).collect(),
        corners: (0..3 * n).map(|c| parts[c as usize / 3].2.map_or(crate::base::mesh::NONE, |_| c / 3)).collect(),
    };
    let part = |&(node, material, _): &(&str, &str, Option<[f32; 4]>)| Part {
        node: node.into(),
        material: material.into(),
        ..Part::default()
    };
    let mut channels = vec![
        values(Semantic::Joints(0), &|_| [0.0, 1.0, 2.0, 3.0]),
        values(Semantic::Weights(0), &|k| parts[k].2.unwrap_or_default()),
    ];
    channels.retain(|c| c.corners.iter().any(|&k| k != crate::base::mesh::NONE));
    Mesh {
        positions: (0..n).flat_map(corners).collect(),
        triangles: (0..n).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
        triangle_part: (0..n).collect(),
        parts: parts.iter().map(part).collect(),
        skeleton: Skeleton { joints: vec![joint; if channels.is_empty() { 0 } else { 7 }] },
        channels,
    }
}

const ONE: Option<[f32; 4]> = Some([1.0, 0.0, 0.0, 0.0]);
const TWO: Option<[f32; 4]> = Some([0.5, 0.5, 0.0, 0.0]);
const THREE: Option<[f32; 4]> = Some([0.4, 0.3, 0.3, 0.0]);
const FOUR: Option<[f32; 4]> = Some([0.25; 4]);

fn patterns(list: &[&str]) -> Vec<Pattern> {
    list.iter().map(|p| p.parse().unwrap()).collect()
}

fn of(cloth: &[&str], body: &[&str], rigid: &[&str]) -> SelectOptions {
    SelectOptions { cloth: patterns(cloth), body: patterns(body), rigid: patterns(rigid) }
}

#[test]
fn the_rule_reads_names_then_joints() {
    let mesh = mesh(&[
        ("Mage_Cape", "atlas", None),
        ("Mage_Head", "atlas", TWO),
        ("Object_1", "Shirt", ONE),
        ("Object_2", "", ONE),
        ("Object_3", "", THREE),
        ("Object_4", "", FOUR),
        ("Object_5", "", None),
    ]);
    let roles: Vec<Role> = roles(&mesh, &SelectOptions::default()).unwrap().iter().map(|v| v.role).collect();
    use Role::*;
    assert_eq!(roles, [Cloth, Body, Cloth, Rigid, Cloth, Body, Rigid]);
}

#[test]
fn a_node_with_garments_tells_nothing_of_its_other_materials() {
    let parts =
        [("Skin", FOUR), ("Shirt", THREE), ("Gold", THREE), ("Material.001", FOUR), ("Red", ONE), ("Belt", THREE)];
    let mut all = mesh(&parts.map(|(material, weights)| ("Body", material, weights)));
    (0..).zip(&mut all.parts).for_each(|(k, part)| (part.primitive, part.has_siblings) = (k, true));
    let of = |mesh: &Mesh| -> Vec<Role> {
        roles(mesh, &SelectOptions::default()).unwrap().iter().map(|v| v.looks_like).collect()
    };
    use Role::*;
    assert_eq!(of(&all), [Body, Cloth, Cloth, Body, Rigid, Rigid]);
    let said = findings(&all, &roles(&all, &SelectOptions::default()).unwrap(), &SelectOptions::default());
    assert!(said[0].message.contains("cloth: Body/Shirt, Body/Gold; body: Body/Skin"), "{}", said[0].message);
    // Trims follow as many joints as the garment that they are on, be it half of them all.
    let mut robe = mesh(&["Skin", "Robe", "Gold"].map(|material| ("Body", material, FOUR)));
    (0..).zip(&mut robe.parts).for_each(|(k, part)| part.primitive = k);
    assert_eq!(of(&robe), [Body, Cloth, Cloth]);
    // Without a garment or skin beside it, the name of the node counts.
    (all.parts[0].material, all.parts[1].material) = ("Pale".into(), "Blue".into());
    assert_eq!(of(&all), [Body, Body, Body, Body, Body, Rigid]);
}

#[test]
fn beside_skin_with_a_material_of_its_own_colors_are_clothes() {
    let colors = [("Skin", FOUR), ("Blue", THREE), ("Black", FOUR), ("Button", THREE), ("Gold", ONE)];
    let of = |node: &str| -> Vec<Role> {
        let mut all = mesh(&colors.map(|(material, weights)| (node, material, weights)));
        (0..).zip(&mut all.parts).for_each(|(k, part)| part.primitive = k);
        roles(&all, &SelectOptions::default()).unwrap().iter().map(|v| v.looks_like).collect()
    };
    use Role::*;
    assert_eq!(of("King_Body"), [Body, Cloth, Cloth, Rigid, Rigid]);
    assert_eq!(of("Cube.003"), [Body, Cloth, Cloth, Rigid, Rigid]);
    // Of a head they are hair, of feet shoes.
    assert_eq!(of("King_Head"), [Body, Body, Body, Rigid, Body]);
    assert_eq!(of("King_Feet"), [Body, Body, Body, Rigid, Body]);
}

#[test]
fn a_material_that_names_a_garment_goes_before_a_node_or_mesh_that_names_what_it_covers() {
    let mut all = mesh(&[
        ("man", "skin_tone", FOUR),
        ("man.002", "robe_export", FOUR),
        ("hood", "export", THREE),
        ("Body", "cloth", FOUR),
    ]);
    // As copies of the body, which their artist made clothes of.
    all.parts[..3].iter_mut().for_each(|part| part.mesh = "Male_Body.010".into());
    let of = |mesh: &Mesh| -> Vec<Role> {
        roles(mesh, &SelectOptions::default()).unwrap().iter().map(|v| v.looks_like).collect()
    };
    use Role::*;
    assert_eq!(of(&all), [Body, Cloth, Cloth, Body]);
    // A head in the material of its hood is a head.
    (all.parts[1].node, all.parts[1].mesh) = ("Head".into(), "Head".into());
    assert_eq!(of(&all), [Body, Body, Cloth, Body]);
}

#[test]
fn solid_pieces_of_a_part_beside_garments_are_a_part_of_their_own() {
    let mut all = mesh(&["Shirt", "Band", "", "Main", ""].map(|material| ("Body", material, THREE)));
    (0..).zip(&mut all.parts).for_each(|(k, part)| part.primitive = k);
    all.triangle_part = vec![0, 1, 1, 3, 3];
    let weights = all.channels.iter_mut().find(|c| c.semantic == Semantic::Weights(0)).unwrap();
    // The last triangles of both are on one joint; those of the other part are joined.
    [2, 4].into_iter().for_each(|k| weights.values[4 * k..4 * k + 4].copy_from_slice(&[1.0, 0.0, 0.0, 0.0]));
    all.triangles[4][0] = all.triangles[3][0];
    let out = divided(all.clone(), &SelectOptions::default());
    assert_eq!(out.triangle_part, [0, 1, 5, 3, 3]);
    assert_eq!((out.parts[5].material.as_str(), out.parts[5].component), ("Band", None));
    let roles: Vec<Role> = roles(&out, &SelectOptions::default()).unwrap().iter().map(|v| v.role).collect();
    assert_eq!([0, 1, 3, 5].map(|p: usize| roles[p]), [Role::Cloth, Role::Cloth, Role::Cloth, Role::Rigid]);
    // Names choose whole parts, and a mesh without garments stays.
    assert_eq!(divided(all.clone(), &of(&["Band"], &[], &[])), all);
    all.parts[0].material = "Blue".into();
    assert_eq!(divided(all.clone(), &SelectOptions::default()), all);
}

#[test]
fn solid_parts_that_follow_most_joints_are_the_body_where_nothing_else_is() {
    let other: Option<[f32; 4]> = Some([0.0, 0.0, 0.5, 0.5]);
    let mut all =
        mesh(&[("Plates", "", TWO), ("", "", other), ("Jacket", "", THREE), ("Plate", "", TWO), ("", "", None)]);
    all.triangle_part = vec![0, 0, 2, 3, 3];
    let of = |mesh: &Mesh| {
        let verdicts = roles(mesh, &SelectOptions::default()).unwrap();
        [0, 2, 3].map(|p: usize| verdicts[p].role)
    };
    use Role::*;
    assert_eq!(of(&all), [Body, Cloth, Rigid]);
    // Two joints of four are a prop.
    all.skeleton.joints.truncate(4);
    assert_eq!(of(&all), [Body, Cloth, Rigid]);
    all.parts[3].node = "Head".into();
    assert_eq!(of(&all), [Rigid, Cloth, Body]);
}

#[test]
fn files_without_a_skin_stay_as_they_are() {
    let plain = mesh(&[("Head", "", None), ("Staff", "", None)]);
    let selected = select(plain.clone(), &SelectOptions::default()).unwrap();
    assert_eq!((selected.mesh, selected.findings), (plain, Vec::new()));
    let single = mesh(&[("Head", "", TWO)]);
    let selected = select(single.clone(), &SelectOptions::default()).unwrap();
    assert_eq!((selected.mesh, selected.findings), (single, Vec::new()));
}

#[test]
fn names_tell_a_character_without_a_skin() {
    let doll = mesh(&[
        ("head", "", None),
        ("skirt_front", "", None),
        ("arm_left", "", None),
        ("", "fabric-red", None),
        ("golden", "", None),
    ]);
    let roles_of =
        |mesh: &Mesh| -> Vec<Role> { roles(mesh, &SelectOptions::default()).unwrap().iter().map(|v| v.role).collect() };
    assert_eq!(roles_of(&doll), [Role::Body, Role::Cloth, Role::Body, Role::Cloth, Role::Rigid]);
    assert_eq!(select(doll, &SelectOptions::default()).unwrap().findings[0].kind, "left-out");
    // The panels of a garment are all cloth, and so is a head without a garment.
    for parts in [["shirt_body", "arm_left", "collar"], ["head", "arm_left", "thing"]] {
        let whole = mesh(&parts.map(|name| (name, "", None)));
        assert_eq!(roles_of(&whole), [Role::Cloth; 3], "{parts:?}");
    }
}

#[test]
fn a_skinned_file_without_cloth_is_built_whole_with_a_warning() {
    let all = mesh(&[("Head", "", TWO), ("Staff", "", ONE)]);
    let selected = select(all.clone(), &SelectOptions::default()).unwrap();
    assert_eq!(selected.mesh, all);
    let finding = &selected.findings[0];
    assert_eq!((finding.kind, finding.count, finding.severity), ("no-cloth", 2, Severity::Warning));
    assert_eq!(finding.examples[1], "Staff looks like rigid (name has \"staff\")");
}

#[test]
fn dressing_a_character_of_one_part_asks_for_its_components() {
    let named = |name: &str| {
        let mut one = mesh(&[("Mesh", "", TWO)]);
        one.skeleton.joints[1].name = name.into();
        one
    };
    for name in ["ThumbFinger0_Left", "mixamorig:LeftHandIndex1", "J_Adj_L_FaceEye"] {
        let error = demand_cloth("a.vrm", &named(name), &SelectOptions::default()).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains("--cloth component:K"), "{error}");
        demand_cloth("a.vrm", &named(name), &of(&["component:0"], &[], &[])).unwrap();
    }
    // A sleeve follows a hand, a hood a head; joints that nothing follows do not count.
    for name in ["LeftHand", "Head", "Spine1"] {
        demand_cloth("jacket.glb", &named(name), &SelectOptions::default()).unwrap();
    }
    let mut other = named("Spine");
    other.skeleton.joints[5].name = "LeftEye".into();
    demand_cloth("jacket.glb", &other, &SelectOptions::default()).unwrap();
}

#[test]
fn dressing_a_skinned_file_without_cloth_is_refused_with_its_parts() {
    let all = mesh(&[("Head", "", TWO), ("Staff", "", ONE)]);
    let error = demand_cloth("knight.glb", &all, &SelectOptions::default()).unwrap_err().to_string();
    assert!(error.contains("no part of knight.glb looks like cloth"), "{error}");
    assert!(
        error.contains("--cloth (`*` takes all parts)") && error.contains("looks like rigid: name has \"staff\""),
        "{error}"
    );
    demand_cloth("knight.glb", &all, &of(&["*"], &[], &[])).unwrap();
    demand_cloth("knight.glb", &mesh(&[("Head", "", TWO), ("Cape", "", ONE)]), &SelectOptions::default()).unwrap();
    demand_cloth("knight.glb", &mesh(&[("Head", "", None)]), &SelectOptions::default()).unwrap();
}

#[test]
fn flags_choose_by_node_and_material_and_the_rest_is_reported() {
    let all = mesh(&[("Cape", "red", None), ("Head", "skin", TWO), ("Staff", "wood", ONE)]);
    let names = |options: &SelectOptions| {
        let selected = select(all.clone(), options).unwrap();
        let names = selected.mesh.parts.iter().map(|p| p.node.clone()).collect::<Vec<_>>().join(" ");
        (names, selected.findings.iter().map(|f| f.message.clone()).collect::<Vec<_>>().join(" "))
    };
    assert_eq!(
        names(&of(&["c*"], &["SKIN"], &[])),
        ("Cape".into(), "2 parts (2 triangles) left out; cloth: Cape; body: Head; other: Staff.".into())
    );
    let (kept, said) = names(&of(&[], &[], &["Staff"]));
    assert_eq!(
        (kept.as_str(), said.as_str()),
        ("Cape", "2 parts (2 triangles) left out; cloth: Cape; body: Head; rigid: Staff.")
    );
    let (kept, said) = names(&of(&[], &["Cape"], &[]));
    assert_eq!(
        (kept.as_str(), said.as_str()),
        ("Head Staff", "1 part (1 triangle) left out; cloth: Head, Staff; body: Cape.")
    );
    assert_eq!(names(&of(&["*"], &[], &[])), ("Cape Head Staff".into(), String::new()));
    let (kept, said) = names(&SelectOptions::default());
    assert!(kept == "Cape" && said.contains("body: Head; rigid: Staff") && said.contains("--cloth"), "{said}");
}

#[test]
fn the_kept_mesh_has_its_own_vertices_and_values() {
    let all = mesh(&[("Head", "", ONE), ("Cape", "", TWO), ("Staff", "", None)]);
    let kept = select(all.clone(), &of(&["Cape"], &[], &[])).unwrap().mesh;
    assert_eq!((kept.triangles.clone(), kept.triangle_part.clone(), kept.parts.len()), (vec![[0, 1, 2]], vec![0], 1));
    assert_eq!(kept.positions, all.positions[3..6]);
    let weights = kept.channel(&Semantic::Weights(0)).unwrap();
    assert_eq!((weights.at(0, 2), weights.corners.len()), (Some(&[0.5, 0.5, 0.0, 0.0][..]), 3));
    let bare = select(all, &of(&["Staff"], &[], &[])).unwrap().mesh;
    assert!(bare.channels.is_empty());
}

#[test]
fn impossible_choices_are_typed_errors_that_help() {
    let all = mesh(&[("Cape", "red", None), ("Head", "skin", TWO)]);
    let error = |options: &SelectOptions| {
        let error = select(all.clone(), options).unwrap_err();
        assert!(matches!(error, Error::Option { .. }));
        error.to_string()
    };
    assert_eq!(
        error(&of(&["Cape"], &["Hed*"], &[])),
        "option body: no node, mesh or material matches `Hed*`; choose from `Cape`, `red`, `Head`, `skin`"
    );
    assert!(error(&of(&["Cape"], &[], &["red"])).contains("`red` matches Cape, which --cloth chooses too"));
    assert!(error(&of(&[], &["*"], &[])).contains("no part is left that is cloth"));
    let many: Vec<String> = (0..40).map(|k| format!("n{k}")).collect();
    let parts: Vec<_> = many.iter().map(|n| (n.as_str(), "", None)).collect();
    let text = select(mesh(&parts), &of(&["x"], &[], &[])).unwrap_err().to_string();
    assert!(text.contains("`n29`, ...") && !text.contains("`n30`"), "{text}");
}

/// One part of three triangles that share no vertex, the second the largest.
fn one_part() -> Mesh {
    let mut all = mesh(&[("Body", "skin", None), ("", "", None), ("", "", None)]);
    all.parts.truncate(1);
    all.triangle_part = vec![0; 3];
    all.positions[5][1] = 3.0;
    all
}

#[test]
fn components_of_one_part_are_chosen_by_number() {
    let all = one_part();
    assert_eq!(component_numbers(&all), (vec![1, 0, 2], 3));
    let kept = |options: &SelectOptions| {
        let selected = select(divided(all.clone(), options), options).unwrap();
        (selected.mesh.positions, selected.findings[0].message.clone())
    };
    let (positions, said) = kept(&of(&["component:0"], &[], &[]));
    assert_eq!(positions, all.positions[3..6]);
    assert_eq!(said, "1 part (2 triangles) left out; cloth: Body (component 0); other: Body.");
    // A number goes before a name.
    let (positions, said) = kept(&of(&["component:0"], &["body"], &["component:2"]));
    assert_eq!(positions, all.positions[3..6]);
    assert!(said.contains("body: Body; rigid: Body (component 2)"), "{said}");
    let (positions, _) = kept(&of(&[], &["component:0"], &[]));
    assert_eq!(positions, [&all.positions[..3], &all.positions[6..]].concat());
    // Without a number the mesh stays as it is.
    assert_eq!(divided(all.clone(), &of(&["Body"], &[], &[])), all);
}

#[test]
fn components_that_do_not_exist_are_refused_with_those_that_do() {
    let all = one_part();
    let options = of(&["component:3"], &[], &[]);
    let error = roles(&divided(all.clone(), &options), &options).unwrap_err().to_string();
    assert_eq!(
        error,
        "option cloth: there is no component 3; choose from component:0 to component:2; `gimage list` shows them"
    );
    let both = of(&["component:1"], &["component:1"], &[]);
    let error = roles(&divided(all, &both), &both).unwrap_err().to_string();
    assert!(error.contains("--cloth chooses too"), "{error}");
}
