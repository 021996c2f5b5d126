//! Files to meshes: glTF 2.0 (`.glb`, `.gltf`) and Wavefront OBJ.
//!
//! Positions of every node instance are placed in the world of the file, skinned or not: a skinned mesh is taken in its
//! bind shape, placed by its node's world transform, or where its joints pose it (`stand.rs`: glTF viewers ignore that transform when they skin; the joints'
//! inverse bind matrices are changed accordingly, as [`crate::base::mesh::Joint`] says).
//!
//! Nothing here trusts the file: counts are checked against the bytes that are there before anything is reserved, indices
//! before they are used, and node graphs before they are walked.

mod accessor;
mod animation;
mod attributes;
mod bones;
mod bound;
mod buffers;
mod builder;
mod character;
mod color;
mod document;
pub(crate) mod draco;
mod embed;
mod extension;
mod findings;
mod glb;
mod gltf;
mod grid;
mod instancing;
mod local;
mod matrix;
mod meshopt;
mod moving;
mod nodes;
mod obj;
mod obj_parse;
mod origin;
mod pieces;
mod place;
mod polygon;
mod primitive;
mod rehang;
mod roots;
mod scene;
mod shapes;
mod skin;
mod sniff;
mod source;
mod stand;
mod weights;

use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

pub(crate) use bones::bones;
pub use character::Character;
pub use color::{BaseColor, base_colors};
pub(crate) use embed::embed;
pub(crate) use glb::split as split_glb;
pub use matrix::inverse;
pub(crate) use matrix::{IDENTITY, Matrix, mul, point};
pub use origin::Origin;
pub use place::Up;
pub use scene::{Animation, Scene, Skin};
pub use shapes::{FileCollider, FileShape};
pub use source::{OutsideFile, Source};

use crate::base::mesh::{Mesh, Part};
use crate::error::{Error, Result};
use crate::options::{Range, stage_options};
use crate::record::{Finding, Severity};
use findings::Findings;

stage_options! {
    /// Options of the import: selection, units, axes and limits.
    pub struct ImportOptions of "import" {
        /// Import only the node, mesh, object, group or material of this name; may be repeated. Names are compared exactly.
        pub pieces: Vec<String> = Vec::new() => "piece" [""] Range::Any;
        /// Metres per unit of the file, 0.01 for centimetres.
        pub unit: f64 = 1.0 => "unit" ["m"] Range::Above(0.0);
        /// The up axis of the file: X, Y, Z, -X, -Y or -Z. The garment, its normals and its skin are rotated to Y up.
        pub up: Up = Up::Y => "up" [""] Range::Any;
        /// Move the garment, after --unit and --up: the middle of its bounding box to x = 0 and z = 0, its lowest point to
        /// y = 0. Pin expressions refer to the moved garment.
        pub center: bool = false => "center" [""] Range::Any;
        /// Largest number of bytes to read, including external files and decompressed data.
        pub max_bytes: u64 = 2 << 30;
        /// Largest number of vertices of the mesh, including instances.
        pub max_vertices: usize = 1 << 24;
        /// Largest number of triangles of the mesh, including instances.
        pub max_triangles: usize = 1 << 25;
    }
}

/// A mesh as it stands in its file, turned and moved as [`ImportOptions`] says, with what is known about where it came from.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// The mesh; every vertex is used by a triangle.
    pub mesh: Mesh,
    /// The file.
    pub source: Source,
    /// Skins, animations and colliders, which the mesh does not have.
    pub scene: Scene,
    /// Where each part of the mesh came from; empty for OBJ.
    pub origins: Vec<Origin>,
    /// Takes a position in the world of the file to the space of the mesh, column by column: unit, up axis and centring.
    pub transform: [f64; 16],
    /// Elements that were left out or repaired.
    pub findings: Vec<Finding>,
}

/// Reads the file that stands beside the one being imported, by its relative path with `/` between folders.
pub type Resolver<'a> = dyn Fn(&str) -> std::io::Result<Vec<u8>> + 'a;

/// Reads a `.glb`, `.gltf` or `.obj` file. The content determines the format, not the name.
pub fn import(path: &Path, options: &ImportOptions) -> Result<Imported> {
    options.check()?;
    let bytes = source::read_capped(path, options.max_bytes)?;
    let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
    let resolver = |name: &str| source::read_beside(&folder, name, options.max_bytes);
    import_bytes(path, &bytes, &resolver, options)
}

/// Tells parts whether others have their node and mesh with another material.
fn mark_siblings(parts: &mut [Part]) {
    let mut materials: BTreeMap<[&str; 2], BTreeSet<&str>> = BTreeMap::new();
    for part in parts.iter() {
        materials.entry([&part.node, &part.mesh]).or_default().insert(&part.material);
    }
    let several: Vec<bool> = parts.iter().map(|part| materials[&[&*part.node, &*part.mesh]].len() > 1).collect();
    parts.iter_mut().zip(several).for_each(|(part, several)| part.has_siblings = several);
}

/// Like [`import()`], from memory. `name` stands for the file in messages and tells an OBJ by its extension; `resolver` is
/// asked for outside buffers.
pub fn import_bytes(name: &Path, bytes: &[u8], resolver: &Resolver, options: &ImportOptions) -> Result<Imported> {
    options.check()?;
    // Every read below is checked. Should a decoder still panic on a damaged file, its caller gets an error all the same.
    catch_unwind(AssertUnwindSafe(|| dispatch(name, bytes, resolver, options))).unwrap_or_else(|_| {
        Err(Error::Malformed {
            path: name.to_path_buf(),
            element: "file".into(),
            problem: "it is damaged in a way that stopped the reader".into(),
            hint: "export it again, and report the file as a fault of the importer".into(),
        })
    })
}

fn dispatch(name: &Path, bytes: &[u8], resolver: &Resolver, options: &ImportOptions) -> Result<Imported> {
    let mut findings = Findings::default();
    let format = sniff::sniff(name, bytes)?;
    let mut source = Source::new(name, bytes);
    if let Some(said) = format.contradicts(name) {
        let message = "The file extension does not match the content; the file was read by its content.";
        findings.add(Severity::Note, "wrong-extension", 1, message, || said);
    }
    let loaded = match format {
        sniff::Format::Obj => gltf::Loaded {
            mesh: obj::load(name, bytes, options, &mut source, &mut findings)?,
            scene: Scene::default(),
            origins: Vec::new(),
        },
        sniff::Format::Glb => {
            let chunks = glb::split(name, bytes)?;
            gltf::load(name, chunks.json, chunks.bin, resolver, options, &mut source, &mut findings)?
        }
        sniff::Format::Gltf => gltf::load(name, bytes, None, resolver, options, &mut source, &mut findings)?,
    };
    let gltf::Loaded { mut mesh, mut scene, origins } = loaded;
    mark_siblings(&mut mesh.parts);
    let transform = place::place(&mut mesh, options, &mut findings);
    scene.colliders.iter_mut().for_each(|c| c.world = matrix::mul(&transform, &c.world));
    Ok(Imported { mesh, source, scene, origins, transform, findings: findings.into_vec() })
}

/// Short for [`Error::Malformed`].
pub(crate) fn malformed(
    path: &Path,
    element: impl Into<String>,
    problem: impl Into<String>,
    hint: impl Into<String>,
) -> Error {
    Error::Malformed { path: path.to_path_buf(), element: element.into(), problem: problem.into(), hint: hint.into() }
}

/// The hint where only the program that wrote the file can help.
pub(crate) const EXPORT_AGAIN: &str = "export the file again";
