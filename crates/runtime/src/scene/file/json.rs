//! The fields of a scene file, as SCENE.md has them. Every struct refuses fields that it does not know.

use serde::Deserialize;

use super::error::{Error, Result};

const FORMAT: &str = "gimage-scene";
const VERSION: u32 = 1;

type V3 = [f32; 3];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct File {
    #[serde(rename = "format")]
    _format: String,
    #[serde(rename = "version")]
    _version: u32,
    #[serde(default)]
    pub name: String,
    #[serde(default = "ten")]
    pub duration: f64,
    #[serde(default = "earth")]
    pub gravity: V3,
    pub wind: Option<Wind>,
    #[serde(default)]
    pub solver: Solver,
    #[serde(default)]
    pub thickness: f32,
    pub clear_start: Option<bool>,
    pub cloths: Vec<Cloth>,
    #[serde(default)]
    pub colliders: Vec<Collider>,
    #[serde(default)]
    pub cuts: Vec<Cut>,
    pub character: Option<Character>,
    pub camera: Option<Camera>,
    pub background: Option<V3>,
    pub collider_color: Option<V3>,
}

fn ten() -> f64 {
    10.0
}

fn earth() -> V3 {
    [0.0, -9.81, 0.0]
}

fn one() -> f32 {
    1.0
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wind {
    pub velocity: V3,
    #[serde(default)]
    pub gust_degrees: f32,
    #[serde(default = "one")]
    pub gust_size: f32,
    pub force: Force,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Force {
    Push { response: f32 },
    Triangles { density: f32, drag: f32, lift: f32 },
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Solver {
    pub name: Option<String>,
    pub substeps: Option<u32>,
    pub budget: Option<f64>,
    pub error: Option<f64>,
    pub iterations: Option<u32>,
    pub tethers: Option<u32>,
    pub pyramid: Option<u32>,
    pub polish: Option<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Character {
    pub file: String,
    pub animation: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cloth {
    #[serde(default)]
    pub name: String,
    pub from: From,
    #[serde(default)]
    pub position: V3,
    #[serde(default)]
    pub rotation: Rotation,
    #[serde(default)]
    pub pins: Vec<Pins>,
    pub mass: Option<f64>,
    pub damping: Option<f32>,
    pub thickness: Option<f32>,
    pub friction: Option<f32>,
    pub collision_groups: Option<Vec<u32>>,
    pub contact: Option<Contact>,
    pub compliance: Option<f32>,
    pub backstop: Option<Backstop>,
    pub material: Option<Material>,
    #[serde(default)]
    pub velocity: V3,
    pub speed_limit: Option<f32>,
    pub skinning: Option<Skinning>,
    pub front: Option<V3>,
    pub back: Option<V3>,
    pub checker: Option<[f32; 2]>,
}

/// How points between joints move.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Skinning {
    Linear,
    DualQuaternion,
}

/// How far all particles of a cloth may go behind where they rest.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Backstop {
    pub distance: f32,
    pub radius: f32,
}

/// Contact of cloth with cloth.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Contact {
    Particles(Touch),
    Safe(Touch),
}

/// The numbers of contact.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Touch {
    pub distance: Option<f32>,
    pub friction: Option<f32>,
    pub layer: Option<i32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    pub fabric: Option<String>,
    pub warp: Option<f64>,
    pub weft: Option<f64>,
    pub shear: Option<f64>,
    pub bend: Option<f64>,
    pub density: Option<f64>,
    pub damping: Option<f64>,
    pub thickness: Option<f64>,
    pub friction: Option<f64>,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum From {
    Bundle(String),
    Garment {
        file: String,
        texels: u32,
    },
    Flat {
        width: u32,
        height: u32,
        #[serde(default)]
        origin: V3,
        right: V3,
        down: V3,
    },
}

/// Where a cloth that is not flat comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A bundle by its path, relative to the scene file.
    Bundle(String),
    /// A garment mesh, to be built into a bundle. A host without the preprocessor refuses it.
    Garment {
        /// Its path, relative to the scene file.
        file: String,
        /// Texels of the whole bundle.
        texels: u32,
    },
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rotation {
    pub axis: V3,
    pub degrees: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pins {
    pub select: Select,
    #[serde(default)]
    pub motion: Vec<PinKey>,
    pub pivot: Option<V3>,
    pub release: Option<f64>,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Select {
    Box {
        low: V3,
        high: V3,
    },
    Sphere {
        center: V3,
        radius: f32,
    },
    Texels {
        piece: Option<String>,
        from: [u32; 2],
        to: [u32; 2],
    },
    /// Those that the bundle has pinned already.
    Pinned {},
    Loop {
        index: usize,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PinKey {
    pub time: f64,
    #[serde(default)]
    pub offset: V3,
    #[serde(default)]
    pub rotation: Rotation,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Collider {
    pub shape: Shape,
    #[serde(default)]
    pub position: V3,
    #[serde(default)]
    pub rotation: Rotation,
    #[serde(default)]
    pub friction: f32,
    pub collision_groups: Option<Vec<u32>>,
    pub joint: Option<String>,
    #[serde(default)]
    pub motion: Vec<ColliderKey>,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    HalfSpace {},
    Sphere {
        radius: f32,
    },
    Capsule {
        half_height: f32,
        radius: f32,
    },
    TaperedCapsule {
        half_height: f32,
        radii: [f32; 2],
    },
    Box {
        half: V3,
    },
    Ellipsoid {
        radii: V3,
        #[serde(default)]
        closest: bool,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColliderKey {
    pub time: f64,
    pub position: V3,
    #[serde(default)]
    pub rotation: Rotation,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cut {
    pub time: f64,
    pub eye: V3,
    pub a: V3,
    pub b: V3,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    pub eye: V3,
    pub target: V3,
    #[serde(default = "lens")]
    pub fov_degrees: f32,
}

fn lens() -> f32 {
    35.0
}

/// Reads the text. Format and version are judged first, so that a newer scene is reported as newer.
pub fn read(bytes: &[u8]) -> Result<File> {
    #[derive(Deserialize)]
    struct Probe {
        #[serde(default)]
        format: serde_json::Value,
        #[serde(default)]
        version: serde_json::Value,
    }
    if bytes.len() > super::MAX_BYTES {
        return Err(syntax(".", format!("{} bytes, more than {}", bytes.len(), super::MAX_BYTES)));
    }
    let probe: Probe = serde_json::from_slice(bytes).map_err(|e| syntax(".", e.to_string()))?;
    let other = |field, found: &serde_json::Value, known: String| {
        let found = found.to_string().chars().take(40).collect();
        Err(Error::Version { field, found, known })
    };
    if probe.format != FORMAT {
        return other("format", &probe.format, format!("{FORMAT:?}"));
    }
    if probe.version != VERSION {
        return other("version", &probe.version, VERSION.to_string());
    }
    let mut text = serde_json::Deserializer::from_slice(bytes);
    let file = serde_path_to_error::deserialize(&mut text);
    file.map_err(|e| syntax(&e.path().to_string(), e.inner().to_string()))
}

fn syntax(field: &str, problem: String) -> Error {
    let field = if field == "." { "the scene".into() } else { field.into() };
    Error::Syntax { field, problem }
}
