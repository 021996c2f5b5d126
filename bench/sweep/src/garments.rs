//! The meshes that a sweep starts from: those of a folder, and the clean garments.

use std::path::{Path, PathBuf};

use gimage::component::{ComponentOptions, split};
use gimage::import::{ImportOptions, import};
use gimage::repair::{RepairOptions, repair};

use crate::Failure;
use crate::shape::Shape;

/// Dirty ones with garments among their parts, for damage only.
const DRESSED: [&str; 3] = ["outfit_skinned.glb", "mage_skinned.glb", "jacket_fleece.glb"];

/// Triangles of the smallest and of the largest part that is damaged.
const DAMAGED: std::ops::RangeInclusive<usize> = 300..=16_000;

/// Deepest folder below the one given.
const DEEPEST: usize = 16;

/// Every mesh file under a folder, in the order of its path; a file stands for itself.
pub fn under(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut out = Vec::new();
    collect(path, 0, &mut out).map_err(|e| format!("{}: {e}; give a folder or a mesh", path.display()))?;
    out.sort();
    Ok(out)
}

fn collect(path: &Path, depth: usize, out: &mut Vec<PathBuf>) -> std::io::Result<()> {
    let meta = std::fs::metadata(path)?;
    if meta.is_dir() && depth <= DEEPEST {
        for entry in std::fs::read_dir(path)? {
            let entry = entry?;
            // A link to a folder may lead in a circle.
            if !(entry.file_type()?.is_symlink() && entry.path().is_dir()) {
                collect(&entry.path(), depth + 1, out)?;
            }
        }
    } else if meta.is_file() {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        if depth == 0 || ["obj", "glb", "gltf"].iter().any(|e| extension == *e) {
            out.push(path.to_path_buf());
        }
    }
    Ok(())
}

/// The parts to damage, with their names: components of 300 to 16,000 triangles.
pub fn parts() -> Result<Vec<(String, Shape)>, Failure> {
    let mut out = Vec::new();
    for path in gimage_bench_meshes::clean().into_iter().chain(gimage_bench_meshes::shared(&DRESSED)) {
        let mesh = repair(import(&path, &ImportOptions::default())?.mesh, &RepairOptions::default())?.mesh;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let found = split(&mesh, &ComponentOptions::default()).pieces;
        for (k, part) in found.iter().filter(|c| DAMAGED.contains(&c.triangles.len())).take(4).enumerate() {
            let triangles = part.triangles.iter().map(|&t| mesh.triangles[t as usize]).collect();
            let shape = Shape { positions: mesh.positions.clone(), triangles }.compacted();
            out.push((format!("{stem}.{k}"), shape));
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sample_garments_are_among_the_parts() {
        let parts = parts().unwrap();
        for name in ["tshirt.0", "dress.0", "cape.0"] {
            let (_, shape) = parts.iter().find(|p| p.0 == name).unwrap();
            assert!(DAMAGED.contains(&shape.triangles.len()), "{name}");
        }
    }

    #[test]
    fn a_folder_gives_its_meshes_in_order_and_a_missing_one_is_named() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.obj", "a.GLB", "c.txt", "sub/d.gltf"] {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "x").unwrap();
        }
        let names: Vec<_> = under(folder.path()).unwrap();
        let names: Vec<_> = names.iter().map(|p| p.strip_prefix(folder.path()).unwrap().to_str().unwrap()).collect();
        assert_eq!(names, ["a.GLB", "b.obj", "sub/d.gltf"]);
        assert!(under(&folder.path().join("none")).unwrap_err().to_string().contains("none"));
    }
}
