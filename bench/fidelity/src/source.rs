//! The meshes, as the peers and the measurement of the peers see them.

use std::path::Path;

use gimage::Mesh;
use gimage::component::{ComponentOptions, split};
use gimage::import::{ImportOptions, import};
use gimage::repair::{RepairOptions, repair};

use crate::Failure;

/// The name of a mesh in the table: its file's name without folders and extension.
pub fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().replace([',', '"', '\n'], "_")
}

/// A mesh after import and repair, and without accessories.
pub struct Reference {
    /// Vertices \[m\].
    pub positions: Vec<[f64; 3]>,
    /// Triangles of the pieces.
    pub triangles: Vec<[u32; 3]>,
}

impl Reference {
    /// Reads it as the pipeline does, so that the peers start from the very triangles that a build starts from.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let mesh: Mesh = import(path, &ImportOptions::default())?.mesh;
        let mesh = repair(mesh, &RepairOptions::default())?.mesh;
        let pieces = split(&mesh, &ComponentOptions::default()).pieces;
        let triangles = pieces.iter().flat_map(|p| &p.triangles).map(|&t| mesh.triangles[t as usize]).collect();
        Ok(Self { positions: mesh.positions, triangles })
    }

    /// As an OBJ file; every digit is kept.
    pub fn obj(&self) -> String {
        let mut index = vec![0u32; self.positions.len()];
        let (mut out, mut used) = (String::new(), 0);
        for &v in self.triangles.iter().flatten() {
            if index[v as usize] == 0 {
                used += 1;
                index[v as usize] = used;
                let [x, y, z] = self.positions[v as usize];
                out += &format!("v {x} {y} {z}\n");
            }
        }
        for t in &self.triangles {
            let [a, b, c] = t.map(|v| index[v as usize]);
            out += &format!("f {a} {b} {c}\n");
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_obj_holds_only_what_triangles_use_and_counts_from_one() {
        let positions = vec![[9.0; 3], [0.1, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let text = Reference { positions, triangles: vec![[1, 2, 3]] }.obj();
        assert_eq!(text, "v 0.1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    }

    #[test]
    fn names_hold_no_folders_and_no_commas() {
        assert_eq!(stem(Path::new("a/b,c.obj")), "b_c");
    }
}
