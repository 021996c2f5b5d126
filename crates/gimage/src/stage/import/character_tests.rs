use base64::Engine;
use serde_json::json;

use super::*;

/// A file of three nodes in a chain (`hip`, `knee` 1 below it, `foot` 1 below that, all under a node that doubles) whose animation `go` has a
/// channel of each kind.
fn file(folder: &Path) -> std::path::PathBuf {
    let (h, mut bytes, mut views, mut accessors) = (0.5f32.sqrt(), Vec::new(), Vec::new(), Vec::new());
    let mut add = |kind: &str, values: &[f32], width: usize| {
        views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": 4 * values.len()}));
        accessors.push(
            json!({"bufferView": views.len() - 1, "componentType": 5126, "count": values.len() / width, "type": kind}),
        );
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        accessors.len() - 1
    };
    let two = add("SCALAR", &[0.0, 2.0], 1);
    let shift = add("VEC3", &[0.0, 0.0, 0.0, 3.0, 0.0, 0.0], 3);
    let turn = add("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, h, h], 4);
    let grow = add("VEC3", &[[0.0; 3], [1.0; 3], [0.0; 3], [0.0; 3], [3.0; 3], [0.0; 3]].concat(), 3);
    let channel =
        |sampler: usize, node: usize, path: &str| json!({"sampler": sampler, "target": {"node": node, "path": path}});
    let uri = base64::engine::general_purpose::STANDARD.encode(&bytes);
    let chain = |name: &str, child: usize| json!({"name": name, "translation": [0, -1, 0], "children": [child]});
    let text = json!({
        "asset": {"version": "2.0"},
        "nodes": [
            {"name": "double", "scale": [2, 2, 2], "children": [1]},
            chain("hip", 2), chain("knee", 3), {"name": "foot", "translation": [0, -1, 0]},
            {"name": "boot", "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1]},
        ],
        "animations": [
            {"name": "stand", "channels": [], "samplers": []},
            {"name": "go",
             "channels": [channel(0, 1, "translation"), channel(1, 2, "rotation"), channel(2, 3, "scale"), channel(2, 3, "weights")],
             "samplers": [{"input": two, "output": shift, "interpolation": "STEP"}, {"input": two, "output": turn},
                          {"input": two, "output": grow, "interpolation": "CUBICSPLINE"}]},
            {"name": "boots", "channels": [channel(0, 4, "translation")], "samplers": [{"input": two, "output": shift}]},
            {"name": "gone", "channels": [channel(0, 9, "translation")], "samplers": [{"input": two, "output": shift}]},
        ],
        "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{uri}")}],
    });
    let path = folder.join("chain.gltf");
    std::fs::write(&path, text.to_string()).unwrap();
    path
}

fn near(m: &[f64; 16], columns: [[f64; 3]; 4]) -> bool {
    columns.iter().enumerate().all(|(j, column)| (0..3).all(|i| (m[4 * j + i] - column[i]).abs() < 1e-6))
}

#[test]
fn nodes_follow_their_channels_and_their_parents() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(folder.path());
    let go = Character::read(&path, "go", &ImportOptions::default()).unwrap();
    assert_eq!((go.file(), go.name(), go.seconds(), go.loops(), go.skipped()), ("chain.gltf", "go", 2.0, false, 1));
    let [hip, knee, foot] = ["hip", "knee", "foot"].map(|name| go.node(name).unwrap());
    assert!(go.node("hand").unwrap_err().to_string().contains("`hand`"));
    // At 1 s, by hand. The hip steps: still at its first key. The knee is turned by 45 degrees about z. The foot has grown to the value in the
    // middle of 1 and 3 without tangents, 2; everything is doubled.
    let worlds = go.worlds(1.0);
    let h = 2.0 * 0.5f64.sqrt();
    assert!(near(&worlds[hip], [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0], [0.0; 3]]));
    assert!(near(&worlds[knee], [[h, h, 0.0], [-h, h, 0.0], [0.0, 0.0, 2.0], [0.0, -2.0, 0.0]]));
    let (x, y) = (h, -2.0 - h);
    assert!(near(&worlds[foot], [[2.0 * h, 2.0 * h, 0.0], [-2.0 * h, 2.0 * h, 0.0], [0.0, 0.0, 4.0], [x, y, 0.0]]));
    // Past the end it stays in the last pose: moved by 3, a quarter turn, three times as large.
    let worlds = go.worlds(7.0);
    assert!(near(&worlds[foot], [[0.0, 6.0, 0.0], [-6.0, 0.0, 0.0], [0.0, 0.0, 6.0], [8.0, -2.0, 0.0]]));
    // The pose of the file has hip, knee and foot one below the other.
    assert!(near(&go.rest_worlds()[foot], [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0], [0.0, -6.0, 0.0]]));
}

#[test]
fn unit_and_axis_are_those_of_the_import() {
    let folder = tempfile::tempdir().unwrap();
    let options = ImportOptions { unit: 0.01, up: super::super::Up::Z, ..ImportOptions::default() };
    let go = Character::read(&file(folder.path()), "go", &options).unwrap();
    // (8, -2, 0) in centimetres; z up becomes y up, and y becomes -z.
    let foot = go.worlds(2.0)[go.node("foot").unwrap()];
    assert!((0..3).all(|c| (foot[12 + c] - [0.08, 0.0, 0.02][c]).abs() < 1e-9), "{foot:?}");
}

#[test]
fn animations_that_are_absent_or_make_no_sense_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(folder.path());
    let fails = |name: &str| Character::read(&path, name, &ImportOptions::default()).unwrap_err().to_string();
    let absent = fails("run");
    assert!(absent.contains("no animation `run`") && absent.contains("\"stand\", \"go\""), "{absent}");
    assert!(fails("boots").contains("placed by a matrix"));
    assert!(fails("gone").contains("node 9 does not exist"));
    let center = ImportOptions { center: true, ..ImportOptions::default() };
    assert!(Character::read(&path, "go", &center).unwrap_err().to_string().contains("--center"));
    // An animation without channels is a pose.
    let stand = Character::read(&path, "stand", &ImportOptions::default()).unwrap();
    assert_eq!((stand.seconds(), stand.worlds(3.0)), (0.0, stand.rest_worlds()));
}

#[test]
fn all_animations_that_can_be_read_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(folder.path());
    let all = |path: &Path, options: &ImportOptions| {
        let mut all = Vec::new();
        Character::each(path, options, |character| all.push(character));
        all
    };
    let plain = ImportOptions::default();
    // Two of the four cannot.
    let read = all(&path, &plain);
    assert_eq!(read.iter().map(Character::name).collect::<Vec<_>>(), ["stand", "go"]);
    assert_eq!(read[1].worlds(1.0), Character::read(&path, "go", &plain).unwrap().worlds(1.0));
    let center = ImportOptions { center: true, ..plain.clone() };
    assert!(all(&path, &center).is_empty() && all(&folder.path().join("none.glb"), &plain).is_empty());
}

/// The same file with a skin whose joints are at `worlds` where it is bound.
fn skinned(folder: &Path, joints: &[usize], worlds: &[Matrix]) -> std::path::PathBuf {
    let path = file(folder);
    let mut root: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    let binds: Vec<u8> =
        worlds.iter().flat_map(|m| matrix::inverse(m).unwrap()).flat_map(|x| (x as f32).to_le_bytes()).collect();
    let uri = base64::engine::general_purpose::STANDARD.encode(&binds);
    let buffer = json!({"byteLength": binds.len(), "uri": format!("data:application/octet-stream;base64,{uri}")});
    root["buffers"].as_array_mut().unwrap().push(buffer);
    let views = root["bufferViews"].as_array_mut().unwrap();
    views.push(json!({"buffer": 1, "byteLength": binds.len()}));
    let accessor = json!({"bufferView": views.len() - 1, "componentType": 5126, "count": worlds.len(), "type": "MAT4"});
    let accessors = root["accessors"].as_array_mut().unwrap();
    accessors.push(accessor);
    root["skins"] = json!([{"joints": joints, "inverseBindMatrices": accessors.len() - 1}]);
    std::fs::write(&path, root.to_string()).unwrap();
    path
}

#[test]
fn among_nodes_of_one_name_a_joint_of_a_skin_that_moves_is_the_joint() {
    let folder = tempfile::tempdir().unwrap();
    let path = skinned(folder.path(), &[1, 2, 3], &[matrix::IDENTITY; 3]);
    let mut root: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    // Before the chain of the file: a mesh named like its knee, and a copy of its foot that rests, a joint of a second skin.
    let nodes = root["nodes"].as_array_mut().unwrap();
    nodes[4]["name"] = json!("knee");
    nodes.push(json!({"name": "foot"}));
    nodes.swap(4, 2);
    nodes.swap(5, 3);
    nodes[1]["children"] = json!([4]);
    nodes[4]["children"] = json!([5]);
    root["skins"][0]["joints"] = json!([1, 4, 5]);
    root["skins"].as_array_mut().unwrap().push(json!({"joints": [3]}));
    for channel in root["animations"][1]["channels"].as_array_mut().unwrap() {
        let target = &mut channel["target"]["node"];
        *target = json!(target.as_u64().unwrap() + if *target == json!(1) { 0 } else { 2 });
    }
    std::fs::write(&path, root.to_string()).unwrap();
    let go = Character::read(&path, "go", &ImportOptions::default()).unwrap();
    assert_eq!(["hip", "knee", "foot"].map(|name| go.node(name).unwrap()), [1, 4, 5]);
}

#[test]
fn a_character_starts_as_its_skin_is_bound() {
    let folder = tempfile::tempdir().unwrap();
    let h = 0.5f64.sqrt();
    // The skin has a space of its own, turned, moved, and in another unit; the knee is bound with a quarter turn about z.
    let space = matrix::from_trs([3.0, 1.0, -2.0], [0.0, h, 0.0, h], [10.0; 3]);
    let down = matrix::from_trs([0.0, -1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [1.0; 3]);
    let bent = matrix::from_trs([0.0, -1.0, 0.0], [0.0, 0.0, h, h], [1.0; 3]);
    let hip = matrix::mul(&space, &down);
    let knee = matrix::mul(&hip, &bent);
    let foot = matrix::mul(&knee, &down);
    let go = Character::read(&skinned(folder.path(), &[3, 1, 2], &[foot, hip, knee]), "go", &ImportOptions::default());
    let go = go.unwrap();
    let start = go.worlds_between(0.0, 0.0);
    let [hip, knee, foot] = ["hip", "knee", "foot"].map(|name| start[go.node(name).unwrap()]);
    assert!(near(&hip, [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0], [0.0, -2.0, 0.0]]), "{hip:?}");
    assert!(near(&knee, [[0.0, 2.0, 0.0], [-2.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0, -4.0, 0.0]]), "{knee:?}");
    assert!(near(&foot, [[0.0, 2.0, 0.0], [-2.0, 0.0, 0.0], [0.0, 0.0, 2.0], [2.0, -4.0, 0.0]]), "{foot:?}");
    assert_eq!(go.worlds_between(1.0, 1.0), go.worlds(1.0));
}

#[test]
fn a_skin_that_is_bound_in_the_pose_of_its_nodes_or_makes_no_sense_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let start = |joints: &[usize], worlds: &[Matrix]| {
        let go = Character::read(&skinned(folder.path(), joints, worlds), "go", &ImportOptions::default()).unwrap();
        (go.worlds_between(0.0, 0.0), go.rest_worlds())
    };
    let down = |y: f64, x: f64| matrix::from_trs([x, -y, 0.0], [0.0, 0.0, 0.0, 1.0], [2.0; 3]);
    // Rounded.
    let (own, rest) = start(&[1, 2, 3], &[down(2.0, 0.0), down(4.000_1, 0.000_2), down(6.0, 0.0)]);
    assert_eq!(own, rest);
    // A root that an exporter added, of another size than the mesh that the other joints move.
    let small = |y: f64| matrix::from_trs([0.0, -y, 0.0], [0.0, 0.0, 0.0, 1.0], [0.5; 3]);
    let (own, rest) = start(&[1, 2, 3], &[down(2.0, 0.0), small(1.0), small(1.5)]);
    assert_eq!(own, rest);
    // Sheared, and joints that the file has not.
    let mut sheared = down(4.0, 0.0);
    sheared[4] = 1.0;
    let (own, rest) = start(&[1, 2, 90], &[down(2.0, 0.0), sheared, down(6.0, 0.0)]);
    assert_eq!(own, rest);
}
