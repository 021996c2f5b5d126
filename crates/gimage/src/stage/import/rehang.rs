//! Moves nodes of the JSON of a file to the top of its scenes.

use std::collections::HashMap;

use serde_json::{Map, Value, json};

use super::matrix::Matrix;

/// The properties that place a node.
const PLACING: [&str; 4] = ["matrix", "translation", "rotation", "scale"];

/// Gives nodes with meshes these transforms to world space, at the top of the scenes that show them. A node in their place, without a
/// mesh, then does all else that they did, such as moving other nodes.
pub(super) fn rehang(json: &mut Value, to: &HashMap<usize, Matrix>) {
    let mut nodes: Vec<(&usize, &Matrix)> = to.iter().collect();
    nodes.sort_unstable_by_key(|(node, _)| **node);
    for (node, world) in nodes {
        if !json["nodes"][*node].is_object() {
            continue;
        }
        let parent = parent(json, *node);
        let scenes = scenes(json, *node);
        let stays = stand_in(json, *node);
        if let Some(parent) = parent {
            replace(&mut json["nodes"][parent], "children", *node, stays);
        }
        for (scene, is_root) in scenes {
            let scene = &mut json["scenes"][scene];
            match (is_root, stays) {
                (true, Some(stays)) => push(scene, "nodes", stays),
                (true, None) => {}
                (false, _) => push(scene, "nodes", *node),
            }
        }
        let entry = &mut json["nodes"][*node];
        PLACING.iter().for_each(|key| _ = remove(entry, key));
        entry["matrix"] = json!(world);
    }
}

/// A new node that does what a node does beside having a mesh, if it does anything.
fn stand_in(json: &mut Value, node: usize) -> Option<usize> {
    let number = json["nodes"].as_array()?.len();
    let refers = refer(json, node, number);
    let entry = &mut json["nodes"][node];
    let children = remove(entry, "children");
    if children.is_none() && !refers {
        return None;
    }
    let mut new = Map::new();
    let kept = PLACING.iter().chain(refers.then_some(&"name"));
    kept.for_each(|key| new.extend(entry.get(*key).map(|value| (String::from(*key), value.clone()))));
    new.extend(children.map(|children| ("children".into(), children)));
    json["nodes"].as_array_mut()?.push(Value::Object(new));
    Some(number)
}

/// Has skins, and animations that move the node, refer to another one; whether any did.
fn refer(json: &mut Value, node: usize, to: usize) -> bool {
    let mut any = false;
    let mut change = |value: &mut Value| {
        if value.as_u64() == Some(node as u64) {
            (*value, any) = (json!(to), true);
        }
    };
    for skin in list(json, "skins") {
        list(skin, "joints").for_each(&mut change);
        skin.get_mut("skeleton").into_iter().for_each(&mut change);
    }
    for channel in list(json, "animations").flat_map(|animation| list(animation, "channels")) {
        let target = channel.get_mut("target").filter(|target| target["path"] != "weights");
        target.and_then(|target| target.get_mut("node")).into_iter().for_each(&mut change);
    }
    any
}

/// The node that has another one for a child.
fn parent(json: &Value, node: usize) -> Option<usize> {
    json["nodes"].as_array()?.iter().position(|parent| has(parent, "children", node))
}

/// The scenes that show a node, and whether they list it.
fn scenes(json: &Value, node: usize) -> Vec<(usize, bool)> {
    let mut above = vec![node];
    while let Some(parent) = above.last().and_then(|n| parent(json, *n)).filter(|n| !above.contains(n)) {
        above.push(parent);
    }
    let all = json["scenes"].as_array().into_iter().flatten().enumerate();
    let shown = all.filter(|(_, scene)| above.iter().any(|n| has(scene, "nodes", *n)));
    shown.map(|(number, scene)| (number, has(scene, "nodes", node))).collect()
}

fn has(of: &Value, name: &str, number: usize) -> bool {
    of[name].as_array().into_iter().flatten().any(|n| n.as_u64() == Some(number as u64))
}

/// Replaces a number of a list, or removes it; a list without numbers goes.
fn replace(of: &mut Value, name: &str, number: usize, by: Option<usize>) {
    let Some(numbers) = of[name].as_array_mut() else { return };
    let new =
        numbers.drain(..).filter_map(|n| if n.as_u64() == Some(number as u64) { by.map(Value::from) } else { Some(n) });
    let new: Vec<Value> = new.collect();
    match new.is_empty() {
        true => _ = remove(of, name),
        false => of[name] = Value::Array(new),
    }
}

fn push(of: &mut Value, name: &str, number: usize) {
    match of[name].as_array_mut() {
        Some(numbers) => numbers.push(json!(number)),
        None => of[name] = json!([number]),
    }
}

fn list<'a>(of: &'a mut Value, name: &str) -> impl Iterator<Item = &'a mut Value> {
    of.get_mut(name).and_then(Value::as_array_mut).into_iter().flatten()
}

fn remove(of: &mut Value, name: &str) -> Option<Value> {
    of.as_object_mut().and_then(|object| object.remove(name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::import::matrix::IDENTITY;

    #[test]
    fn a_node_goes_to_the_top_and_what_hangs_on_it_stays() {
        let mut json = json!({
            "scenes": [{"nodes": [0]}, {"nodes": [4]}],
            "nodes": [
                {"scale": [0.01, 0.01, 0.01], "children": [1, 3]},
                {"name": "Shirt", "mesh": 0, "skin": 0, "translation": [1.0, 2.0, 3.0], "children": [2]},
                {"name": "Hat", "mesh": 1},
                {"name": "Trousers", "mesh": 2, "skin": 0, "rotation": [0.0, 0.0, 0.0, 1.0]},
                {"name": "Lamp"},
            ],
            "skins": [{"joints": [1], "skeleton": 1}],
            "animations": [{"channels": [
                {"target": {"node": 1, "path": "rotation"}},
                {"target": {"node": 1, "path": "weights"}},
            ]}],
        });
        rehang(&mut json, &HashMap::from([(1, IDENTITY), (3, IDENTITY)]));
        assert_eq!(json["scenes"], json!([{"nodes": [0, 1, 3]}, {"nodes": [4]}]));
        assert_eq!(json["nodes"][0], json!({"scale": [0.01, 0.01, 0.01], "children": [5]}));
        assert_eq!(json["nodes"][1], json!({"name": "Shirt", "mesh": 0, "skin": 0, "matrix": IDENTITY}));
        assert_eq!(json["nodes"][3], json!({"name": "Trousers", "mesh": 2, "skin": 0, "matrix": IDENTITY}));
        assert_eq!(json["nodes"][5], json!({"name": "Shirt", "translation": [1.0, 2.0, 3.0], "children": [2]}));
        assert_eq!(json["skins"], json!([{"joints": [5], "skeleton": 5}]));
        let channels = json["animations"][0]["channels"].as_array().unwrap();
        assert_eq!((&channels[0]["target"]["node"], &channels[1]["target"]["node"]), (&json!(5), &json!(1)));
    }

    #[test]
    fn the_last_child_leaves_no_empty_list_and_a_root_stays_listed() {
        let nodes = json!([{"children": [1]}, {"mesh": 0, "skin": 0}, {"mesh": 0, "skin": 0, "children": [3]}, {}]);
        let mut json = json!({"scenes": [{"nodes": [0, 2]}], "nodes": nodes});
        rehang(&mut json, &HashMap::from([(1, IDENTITY), (2, IDENTITY)]));
        assert_eq!(json["nodes"][0], json!({}));
        assert_eq!(json["scenes"][0]["nodes"], json!([0, 2, 1, 4]));
        assert_eq!(json["nodes"][4], json!({"children": [3]}));
    }
}
