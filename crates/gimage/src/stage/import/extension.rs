//! Which glTF extensions a file may require.

use std::path::Path;

use crate::error::{Error, Result};

/// Extensions that change the geometry, and are read.
const READ: &[&str] = &[
    "KHR_mesh_quantization",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "EXT_mesh_gpu_instancing",
    "KHR_draco_mesh_compression",
];

/// Extensions that leave the geometry as it is: how it looks, is lit, moves or sounds.
const HARMLESS: &[&str] = &[
    "KHR_materials_",
    "EXT_materials_",
    "ADOBE_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_xmp",
    "KHR_animation_",
    "KHR_audio",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_node_visibility",
    "KHR_interactivity",
    "KHR_techniques_webgl",
    "EXT_structural_metadata",
    "EXT_mesh_features",
    "EXT_instance_features",
    "AGI_",
    "VRM",
    "KHR_implicit_shapes",
    "KHR_physics_rigid_bodies",
];

/// Refuses a file that requires what is neither read nor harmless.
pub(crate) fn check_required(path: &Path, required: &[String]) -> Result<()> {
    let unknown = |e: &&String| !READ.contains(&e.as_str()) && !HARMLESS.iter().any(|h| e.starts_with(h));
    match required.iter().find(unknown) {
        None => Ok(()),
        Some(name) => Err(Error::Unsupported {
            path: path.to_path_buf(),
            feature: format!("the required extension {name}"),
            hint: "export without it, or open the file in Blender and export it as .glb".into(),
        }),
    }
}
