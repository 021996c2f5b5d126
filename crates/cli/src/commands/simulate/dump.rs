//! Positions of a frame as images, one a piece.

use std::fs;
use std::path::{Path, PathBuf};

use gimage_bundle::{Image, encode_exr, file_stems};
use gimage_runtime::Stepper;

use crate::commands::engine::Engine;
use crate::exit::Failure;

/// A directory, and the file stems of all grids.
pub struct Dump {
    dir: PathBuf,
    stems: Vec<String>,
}

impl Dump {
    /// Makes the directory; files of the same names in it will be replaced.
    pub fn new(dir: &Path, stepper: &Stepper) -> Result<Self, Failure> {
        fs::create_dir_all(dir).map_err(|e| Failure::io(dir, &e))?;
        let grids = stepper.scene().cloths.iter().flat_map(|c| c.grids());
        Ok(Dump { dir: dir.into(), stems: file_stems(grids.map(|g| g.name.as_str())) })
    }

    /// Writes `frame_NNNNN.<piece>.position.exr` for every grid: x, y, z in metres and the particle code.
    pub fn write(&self, frame: u32, engine: &mut Engine) -> Result<(), Failure> {
        let mut stems = self.stems.iter();
        for (index, cloth) in engine.stepper.scene().cloths.iter().enumerate() {
            let positions = engine.positions(index)?;
            for (grid, stem) in cloth.grids().iter().zip(&mut stems) {
                let mut image = Image::zeros(grid.width, grid.height, 4);
                for (texel, k) in image.data.chunks_exact_mut(4).zip(grid.range()) {
                    texel[..3].copy_from_slice(&positions[k][..3]);
                    // Checked when the cloth was made.
                    texel[3] = cloth.particles()[k].code().unwrap_or(0.0);
                }
                let path = self.dir.join(format!("frame_{frame:05}.{stem}.position.exr"));
                fs::write(&path, encode_exr(&image)?).map_err(|e| Failure::io(&path, &e))?;
            }
        }
        Ok(())
    }
}
