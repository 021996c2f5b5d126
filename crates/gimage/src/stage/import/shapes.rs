//! Colliders that a file brings along: shapes of `KHR_physics_rigid_bodies` and `KHR_implicit_shapes`, and those of the spring bones of
//! VRM 1.0 (`VRMC_springBone`) and VRM 0.x (`VRM`).

use serde::Serialize;
use serde_json::Value;

use super::findings::Findings;
use crate::record::Severity;

/// A collider of a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FileCollider {
    /// The extension that has it.
    pub source: &'static str,
    /// Name of its node.
    pub node: String,
    /// The joint of the mesh's skeleton that moves it: its node's, or that of the nearest ancestor.
    pub joint: Option<u32>,
    /// Its shape, in the space of its node.
    pub shape: FileShape,
    /// Takes the space of its node to that of the mesh, in the pose of the file; column-major.
    pub world: [f64; 16],
}

/// A shape in the space of a node, in units of the file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FileShape {
    /// A ball.
    Sphere {
        /// Its centre.
        center: [f64; 3],
        /// Its radius.
        radius: f64,
    },
    /// The hull of two balls.
    Capsule {
        /// Their centres.
        ends: [[f64; 3]; 2],
        /// Their radii.
        radii: [f64; 2],
    },
    /// A frustum about the y axis, its middle in the origin.
    Cylinder {
        /// Half its height.
        half_height: f64,
        /// Its radii at the top and at the bottom.
        radii: [f64; 2],
    },
    /// A box around the origin.
    Box {
        /// Half its sides.
        half: [f64; 3],
    },
}

/// A collider before nodes have their places.
pub(super) struct Given {
    pub source: &'static str,
    pub node: usize,
    /// Or what it is instead of a shape that is read.
    pub shape: Result<FileShape, &'static str>,
}

const RIGID: &str = "KHR_physics_rigid_bodies";
const SHAPES: &str = "KHR_implicit_shapes";
const SPRINGS: &str = "VRMC_springBone";
const VRM_0: &str = "VRM";
/// Most colliders of a file that are looked at.
const MOST: usize = 1 << 14;

/// The colliders of a file, given its extensions and its nodes. Triggers, which stop nothing, are not among them.
pub(super) fn given(extensions: &Value, nodes: &[Value]) -> Vec<Given> {
    let shapes = list(&extensions[SHAPES]["shapes"]);
    let rigid = nodes.iter().enumerate().filter_map(|(node, n)| {
        // Drafts of the extension had the shape beside the collider's material.
        let collider = n.get("extensions")?.get(RIGID)?.get("collider")?;
        let geometry = collider.get("geometry").unwrap_or(collider);
        let index = geometry["shape"].as_u64().and_then(|k| usize::try_from(k).ok());
        let shape = match index {
            Some(k) => shapes.get(k).map_or(Err("a shape that is not in the file"), implicit),
            None => Err("a mesh"),
        };
        Some(Given { source: RIGID, node, shape })
    });
    let springs = list(&extensions[SPRINGS]["colliders"]).iter().filter_map(|c| {
        // A shape of an extension of the extension, such as the inside of a ball, has a substitute here that is not the shape.
        let shape = if c.get("extensions").is_some() { Err("an extended shape") } else { spring(&c["shape"]) };
        Some(Given { source: SPRINGS, node: index(&c["node"])?, shape })
    });
    let groups = list(&extensions[VRM_0]["secondaryAnimation"]["colliderGroups"]).iter().filter_map(|group| {
        let node = index(&group["node"])?;
        Some(list(&group["colliders"]).iter().map(move |c| Given { source: VRM_0, node, shape: ball_0(c) }))
    });
    rigid.chain(springs).chain(groups.flatten()).take(MOST).collect()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn index(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|k| usize::try_from(k).ok())
}

/// A number of a shape, or what it is where it is absent.
fn size(value: &Value, default: f64) -> f64 {
    if value.is_null() { default } else { value.as_f64().unwrap_or(f64::NAN) }
}

/// Three of them.
fn triple(value: &Value, default: f64) -> [f64; 3] {
    if value.is_null() {
        [default; 3]
    } else {
        [0, 1, 2].map(|k| value.get(k).and_then(Value::as_f64).unwrap_or(f64::NAN))
    }
}

/// The shape, if it is of sizes above 0 and at a place.
fn sound(shape: FileShape, place: &[[f64; 3]], sizes: &[f64]) -> Result<FileShape, &'static str> {
    let there = place.iter().flatten().all(|x| x.is_finite());
    let sized = sizes.iter().all(|x| x.is_finite() && *x > 0.0);
    if there && sized { Ok(shape) } else { Err("a shape with sizes that are not above 0") }
}

/// A shape of `KHR_implicit_shapes`.
fn implicit(shape: &Value) -> Result<FileShape, &'static str> {
    match shape["type"].as_str() {
        Some("sphere") => {
            let radius = size(&shape["sphere"]["radius"], 0.5);
            sound(FileShape::Sphere { center: [0.0; 3], radius }, &[], &[radius])
        }
        Some("box") => {
            let half = triple(&shape["box"]["size"], 1.0).map(|s| 0.5 * s);
            sound(FileShape::Box { half }, &[], &half)
        }
        Some(kind @ ("capsule" | "cylinder")) => {
            let of = &shape[kind];
            let half_height = 0.5 * size(&of["height"], 0.5);
            let radii = [size(&of["radiusTop"], 0.25), size(&of["radiusBottom"], 0.25)];
            if kind == "cylinder" {
                return sound(FileShape::Cylinder { half_height, radii }, &[], &[half_height, radii[0], radii[1]]);
            }
            let ends = [[0.0, half_height, 0.0], [0.0, -half_height, 0.0]];
            // A capsule without a height is a ball.
            sound(FileShape::Capsule { ends, radii }, &ends, &radii)
        }
        Some("plane") => Err("a plane"),
        _ => Err("a shape of an unknown type"),
    }
}

/// A shape of `VRMC_springBone`.
fn spring(shape: &Value) -> Result<FileShape, &'static str> {
    if let Some(ball) = shape.get("sphere") {
        let (center, radius) = (triple(&ball["offset"], 0.0), size(&ball["radius"], 0.0));
        return sound(FileShape::Sphere { center, radius }, &[center], &[radius]);
    }
    let Some(capsule) = shape.get("capsule") else { return Err("a shape of an unknown type") };
    let ends = [triple(&capsule["offset"], 0.0), triple(&capsule["tail"], 0.0)];
    let radius = size(&capsule["radius"], 0.0);
    sound(FileShape::Capsule { ends, radii: [radius; 2] }, &ends, &[radius])
}

/// A ball of VRM 0.x, whose offsets have z the other way round than glTF has.
fn ball_0(ball: &Value) -> Result<FileShape, &'static str> {
    let [x, y, z] = ["x", "y", "z"].map(|c| size(&ball["offset"][c], 0.0));
    let (center, radius) = ([x, y, -z], size(&ball["radius"], 0.0));
    sound(FileShape::Sphere { center, radius }, &[center], &[radius])
}

/// Notes colliders that are not read, by what they are.
pub(super) fn note_unread(given: &[&Given], name: impl Fn(usize) -> String, findings: &mut Findings) {
    for g in given {
        if let Err(what) = g.shape {
            let message = "Colliders of the file are of shapes that are not read.";
            findings.add(Severity::Note, "collider-shape", 1, message, || {
                format!("node {} `{}`: {what}", g.node, name(g.node))
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn shapes_of_all_extensions_are_read() {
        let extensions = json!({
            SHAPES: {"shapes": [
                {"type": "capsule", "capsule": {"height": 2, "radiusTop": 0.5}},
                {"type": "box"},
                {"type": "plane"},
                {"type": "sphere", "sphere": {"radius": -1}},
                {"type": "cylinder", "cylinder": {"height": 1, "radiusTop": 0.1, "radiusBottom": 0.2}},
            ]},
            SPRINGS: {"colliders": [
                {"node": 3, "shape": {"sphere": {"offset": [1, 2, 3], "radius": 0.1}}},
                {"node": 4, "shape": {"capsule": {"radius": 0.2, "tail": [0, 1, 0]}}},
                {"node": 4, "shape": {"sphere": {"radius": 1}}, "extensions": {"VRMC_springBone_extended_collider": {}}},
                {"shape": {"sphere": {"radius": 1}}},
            ]},
            VRM_0: {"secondaryAnimation": {"colliderGroups": [
                {"node": 5, "colliders": [{"offset": {"x": 0.1, "y": 0.2, "z": 0.3}, "radius": 0.4}]},
            ]}},
        });
        let rigid = |geometry: Value| json!({"extensions": {RIGID: {"collider": {"geometry": geometry}}}});
        let nodes = [
            rigid(json!({"shape": 0})),
            rigid(json!({"shape": 1})),
            rigid(json!({"shape": 2})),
            rigid(json!({"shape": 3})),
            rigid(json!({"shape": 9})),
            rigid(json!({"mesh": 0, "convexHull": true})),
            json!({"extensions": {RIGID: {"trigger": {"geometry": {"shape": 0}}}}}),
            json!({"extensions": {RIGID: {"collider": {"shape": 4}}}}),
            json!({}),
        ];
        let found: Vec<_> = given(&extensions, &nodes).into_iter().map(|g| (g.node, g.shape)).collect();
        let expected = [
            (0, Ok(FileShape::Capsule { ends: [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]], radii: [0.5, 0.25] })),
            (1, Ok(FileShape::Box { half: [0.5; 3] })),
            (2, Err("a plane")),
            (3, Err("a shape with sizes that are not above 0")),
            (4, Err("a shape that is not in the file")),
            (5, Err("a mesh")),
            (7, Ok(FileShape::Cylinder { half_height: 0.5, radii: [0.1, 0.2] })),
            (3, Ok(FileShape::Sphere { center: [1.0, 2.0, 3.0], radius: 0.1 })),
            (4, Ok(FileShape::Capsule { ends: [[0.0; 3], [0.0, 1.0, 0.0]], radii: [0.2; 2] })),
            (4, Err("an extended shape")),
            (5, Ok(FileShape::Sphere { center: [0.1, 0.2, -0.3], radius: 0.4 })),
        ];
        assert_eq!(found, expected);
        // Nothing else is a collider, and nothing panics.
        for odd in [json!(null), json!(3), json!({SPRINGS: {"colliders": 3}, VRM_0: [], SHAPES: "x"})] {
            assert!(given(&odd, &[json!(7), json!({"extensions": []})]).is_empty());
        }
    }
}
