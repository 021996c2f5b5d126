//! The meshes that benchmarks of builds start from: the sample garments, and clean ones of the shared folder.

use std::path::{Path, PathBuf};

/// Clean meshes among the shared garments.
const CLEAN: [&str; 8] = [
    "skirt_evening.obj",
    "tshirt_1900.obj",
    "hat_fedora.obj",
    "suit_male06.obj",
    "models/spot.obj",
    "models/camel.obj",
    "models/feline.obj",
    "models/stanford-bunny.obj",
];

/// The repository.
fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// The sample garments in `assets`, by name, then the clean ones that [`shared`] finds.
pub fn clean() -> Vec<PathBuf> {
    let mut out: Vec<PathBuf> = std::fs::read_dir(root().join("assets"))
        .map(|entries| entries.flatten().map(|e| e.path()).collect())
        .unwrap_or_default();
    out.retain(|p| p.extension().is_some_and(|e| e == "glb"));
    out.sort();
    out.extend(shared(&CLEAN));
    out
}

/// The file of this name in `assets`, if it is there.
pub fn asset(name: &str) -> Option<PathBuf> {
    Some(root().join("assets").join(name)).filter(|p| p.is_file())
}

/// Those of the named files that are in `$GIMAGE_SHARED/garments`, or in `shared/garments` beside the repository.
pub fn shared(names: &[&str]) -> Vec<PathBuf> {
    let folder = std::env::var_os("GIMAGE_SHARED").map_or_else(|| root().join("../shared"), PathBuf::from);
    names.iter().map(|name| folder.join("garments").join(name)).filter(|p| p.is_file()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sample_garments_come_first() {
        let names: Vec<_> = clean().iter().take(7).map(|p| p.file_name().unwrap().to_owned()).collect();
        let garments = ["cape.glb", "dress.glb", "figure.glb", "skirt.glb", "sleeve.glb", "trousers.glb", "tshirt.glb"];
        assert_eq!(names, garments);
    }
}
