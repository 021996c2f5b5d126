//! The JSON of a glTF file.
//!
//! Only the JSON layer of the `gltf` crate is used: its readers of buffers trust counts and offsets, and panic on some
//! damaged files. Parts that this importer never reads (images, textures, samplers, cameras, the look of materials) are
//! removed first, so that faults in them do no harm.

use std::path::Path;

use gltf::json;
use serde_json::Value;

use super::matrix::{self, Matrix};
use super::scene::{self, Animation};
use super::shapes::{self, Given};
use super::source::Source;
use super::{EXPORT_AGAIN, extension, glb, malformed};
use crate::error::{Error, Result};

/// A parsed file; nothing in it is checked beyond its types and its node transforms.
pub(crate) struct Document<'a> {
    pub path: &'a Path,
    pub root: json::Root,
    /// Transform of each node to its parent's space.
    pub locals: Vec<Matrix>,
    /// Name of each material.
    pub materials: Vec<String>,
    /// The animations; their key frames are not read.
    pub animations: Vec<Animation>,
    /// Channels and samplers of each, as the file has them.
    pub clips: Vec<Value>,
    /// The colliders of its extensions.
    pub colliders: Vec<Given>,
}

impl<'a> Document<'a> {
    pub fn parse(path: &'a Path, text: &[u8], source: &mut Source) -> Result<Self> {
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        // Some exporters fill the JSON chunk up with zeros instead of spaces.
        let end = text.iter().rposition(|&b| b != 0).map_or(0, |p| p + 1);
        let bad = |e: serde_json::Error| malformed(path, "JSON", e.to_string(), EXPORT_AGAIN);
        let mut value: Value = serde_json::from_slice(&text[..end]).map_err(bad)?;
        let Some(object) = value.as_object_mut() else {
            return Err(malformed(path, "JSON", "it is not an object", EXPORT_AGAIN));
        };
        let mut section = |name: &str| match object.remove(name) {
            Some(Value::Array(items)) => items,
            _ => Vec::new(),
        };
        for unused in ["textures", "images", "samplers", "cameras"] {
            section(unused);
        }
        let clips = section("animations");
        let name = |(i, m): (usize, &Value)| m["name"].as_str().map_or(format!("material {i}"), String::from);
        let materials = section("materials").iter().enumerate().map(name).collect();
        let extensions = object.remove("extensions").unwrap_or_default();
        let animations = scene::animations(&clips, object.get("accessors"));
        check_version(path, object.get("asset"))?;
        source.extras = credits(object.get("asset"));
        let nodes = object.get("nodes").and_then(Value::as_array).map_or(&[][..], |n| n);
        let colliders = shapes::given(&extensions, nodes);
        let locals = nodes.iter().enumerate().map(|(i, n)| local(path, i, n)).collect::<Result<_>>()?;
        fill_scenes(object);
        // As text again: gltf's own reader of text is compiled once, in its crate; one of values would be compiled here.
        let text = serde_json::to_vec(&value).map_err(bad)?;
        let root = json::Root::from_slice(&text).map_err(|e| {
            // The place is one in the shortened text, which nobody sees.
            let what = e.to_string();
            let what = what.split(" at line ").next().unwrap_or_default();
            malformed(path, "JSON", what, EXPORT_AGAIN)
        })?;
        extension::check_required(path, &root.extensions_required)?;
        Ok(Self { path, root, locals, materials, animations, clips, colliders })
    }

    /// Name of a node, or its number.
    pub fn node_name(&self, index: usize) -> String {
        let name = self.root.nodes.get(index).and_then(|n| n.name.clone());
        name.unwrap_or_else(|| format!("node {index}"))
    }

    /// Name of a mesh, or its number.
    pub fn mesh_name(&self, index: usize) -> String {
        let name = self.root.meshes.get(index).and_then(|m| m.name.clone());
        name.unwrap_or_else(|| format!("mesh {index}"))
    }

    /// An error about one element of this file.
    pub fn bad(&self, element: impl Into<String>, problem: impl Into<String>) -> Error {
        malformed(self.path, element, problem, EXPORT_AGAIN)
    }
}

/// Gives every scene a list of nodes: glTF lets it be absent, the JSON types do not.
fn fill_scenes(object: &mut serde_json::Map<String, Value>) {
    let scenes = object.get_mut("scenes").and_then(Value::as_array_mut);
    for scene in scenes.into_iter().flatten().filter_map(Value::as_object_mut) {
        scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
    }
}

fn check_version(path: &Path, asset: Option<&Value>) -> Result<()> {
    let text = |key: &str| asset.and_then(|a| a.get(key)).and_then(Value::as_str);
    match text("version") {
        None => {
            let problem = "it has no asset.version, so it is not glTF 2.0";
            Err(malformed(path, "JSON", problem, "give a glTF 2.0 file"))
        }
        Some(v) if v.starts_with("1.") || v.starts_with("0.") => Err(glb::gltf_1(path)),
        Some(v) if !v.starts_with("2.") || text("minVersion").is_some_and(|m| m != "2.0") => Err(Error::Unsupported {
            path: path.to_path_buf(),
            feature: format!("glTF {}", text("minVersion").unwrap_or(v)),
            hint: "export it as glTF 2.0".into(),
        }),
        Some(_) => Ok(()),
    }
}

/// Who made the file, as `key: value`.
fn credits(asset: Option<&Value>) -> Vec<String> {
    let text = |v: &Value| match v {
        Value::String(s) => Some(s.clone()),
        Value::Number(n) => Some(n.to_string()),
        _ => None,
    };
    let Some(asset) = asset else { return Vec::new() };
    let mut out = Vec::new();
    for key in ["copyright", "generator"] {
        out.extend(asset.get(key).and_then(text).map(|s| format!("{key}: {s}")));
    }
    match asset.get("extras") {
        Some(Value::Object(all)) => out.extend(all.iter().filter_map(|(k, v)| Some(format!("{k}: {}", text(v)?)))),
        Some(other) => out.extend(text(other).map(|s| format!("extras: {s}"))),
        None => {}
    }
    out
}

/// The transform of a node, in double precision.
fn local(path: &Path, index: usize, node: &Value) -> Result<Matrix> {
    if node.get("matrix").is_some() {
        return numbers(path, index, node, "matrix", matrix::IDENTITY);
    }
    let t = numbers(path, index, node, "translation", [0.0; 3])?;
    let q = numbers(path, index, node, "rotation", [0.0, 0.0, 0.0, 1.0])?;
    let s = numbers(path, index, node, "scale", [1.0; 3])?;
    Ok(matrix::from_trs(t, q, s))
}

fn numbers<const N: usize>(path: &Path, index: usize, node: &Value, key: &str, default: [f64; N]) -> Result<[f64; N]> {
    let Some(value) = node.get(key) else { return Ok(default) };
    let list: Option<Vec<f64>> = value.as_array().and_then(|a| a.iter().map(Value::as_f64).collect());
    list.and_then(|l| l.try_into().ok()).ok_or_else(|| {
        let name = node.get("name").and_then(Value::as_str).unwrap_or_default();
        malformed(path, format!("node {index} `{name}`"), format!("{key} is not {N} numbers"), EXPORT_AGAIN)
    })
}
