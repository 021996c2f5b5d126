//! Skins, animations and colliders of a file: the mesh of an import does not have them.

use serde::Serialize;
use serde_json::Value;

use super::document::Document;
use super::shapes::FileCollider;

/// Skins, animations and colliders of a file; empty for OBJ.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Scene {
    /// The skins, in the order of the file.
    pub skins: Vec<Skin>,
    /// The animations, in the order of the file.
    pub animations: Vec<Animation>,
    /// The colliders that are read, in the order of the file's extensions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub colliders: Vec<FileCollider>,
}

/// A skin of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Skin {
    /// Its name, `skin N` if it has none.
    pub name: String,
    /// Number of its joints.
    pub joints: usize,
}

/// An animation of a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Animation {
    /// Its name, `animation N` if it has none.
    pub name: String,
    /// Time of its last key frame \[s\]; `None` if the file does not state it.
    pub seconds: Option<f64>,
}

/// The skins of a document, and its animations.
pub(super) fn scene(doc: &Document) -> Scene {
    let skin = |(k, skin): (usize, &gltf::json::Skin)| Skin {
        name: skin.name.clone().unwrap_or_else(|| format!("skin {k}")),
        joints: skin.joints.len(),
    };
    let skins = doc.root.skins.iter().enumerate().map(skin).collect();
    Scene { skins, animations: doc.animations.clone(), colliders: Vec::new() }
}

/// Names and durations. glTF demands the largest time of each accessor of times; nothing else of them is read.
pub(super) fn animations(list: &[Value], accessors: Option<&Value>) -> Vec<Animation> {
    let last = |sampler: &Value| {
        let accessor = usize::try_from(sampler["input"].as_u64()?).ok()?;
        accessors?.get(accessor)?["max"].get(0)?.as_f64().filter(|t| t.is_finite())
    };
    let animation = |(k, animation): (usize, &Value)| Animation {
        name: animation["name"].as_str().map_or_else(|| format!("animation {k}"), String::from),
        seconds: animation["samplers"].as_array().into_iter().flatten().filter_map(last).reduce(f64::max),
    };
    list.iter().enumerate().map(animation).collect()
}
