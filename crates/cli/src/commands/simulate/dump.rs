//! Positions of a frame as images, one a piece.

use std::fs;
use std::path::{Path, PathBuf};

use gimage_bundle::{Image, check_size, encode_exr, file_stems};
use gimage_runtime::Stepper;

use crate::commands::engine::Engine;
use crate::exit::Failure;
use crate::files::Pending;
use crate::output::{Output, Tone};

/// A directory, and the file stems of all grids.
pub struct Dump {
    dir: PathBuf,
    stems: Vec<String>,
}

impl Dump {
    /// Makes the directory. Refuses grids that no image holds, and a directory with frames of an older run, whose files
    /// would mix with these; with `force` these frames are removed.
    pub fn new(dir: &Path, stepper: &Stepper, force: bool, out: &Output) -> Result<Self, Failure> {
        let grids = || stepper.scene().cloths.iter().flat_map(|c| c.grids());
        for grid in grids() {
            check_size(&grid.name, grid.width, grid.height)
                .map_err(|e| Failure::refused(format!("--dump: {e}; make the grid smaller, or leave out --dump")))?;
        }
        fs::create_dir_all(dir).map_err(|e| Failure::io(dir, &e))?;
        let older = frames(dir)?;
        if !older.is_empty() && !force {
            return Err(Failure::refused(format!(
                "{}: there are {} frames of an older run, such as {}; give another directory, or --force to remove them",
                dir.display(),
                older.len(),
                older[0].file_name().unwrap_or_default().to_string_lossy()
            )));
        }
        for path in &older {
            fs::remove_file(path).map_err(|e| Failure::io(path, &e))?;
        }
        if !older.is_empty() {
            let text = format!("{}: {} frames of an older run removed", dir.display(), older.len());
            out.remark(Tone::Note, "note", &text);
        }
        Ok(Dump { dir: dir.into(), stems: file_stems(grids().map(|g| g.name.as_str())) })
    }

    /// Writes `frame_NNNNN.<piece>.position.exr` for every grid: x, y, z in metres and the particle code. A file is there
    /// as a whole or not at all.
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
                Pending::write(&path, &encode_exr(&image)?)?.commit()?;
            }
        }
        Ok(())
    }
}

/// The files of frames in a directory, in the order of their names.
fn frames(dir: &Path) -> Result<Vec<PathBuf>, Failure> {
    Ok(files(dir)?.into_iter().map(|file| file.path).collect())
}

/// A file of one frame and one grid.
pub struct FrameFile {
    /// Number of the frame.
    pub frame: u32,
    /// The stem of the grid's name.
    pub stem: String,
    /// Where it is.
    pub path: PathBuf,
}

/// The files in a directory that [`Dump::write`] has written, in the order of their names.
pub fn files(dir: &Path) -> Result<Vec<FrameFile>, Failure> {
    let failed = |e: std::io::Error| Failure::io(dir, &e);
    let mut found = Vec::new();
    for entry in fs::read_dir(dir).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = entry.file_name();
        if let Some((frame, stem)) = name.to_str().and_then(parts) {
            found.push(FrameFile { frame, stem: stem.into(), path: entry.path() });
        }
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(found)
}

/// Frame and stem of a file that is named as [`Dump::write`] names files.
fn parts(name: &str) -> Option<(u32, &str)> {
    let rest = name.strip_prefix("frame_").and_then(|n| n.strip_suffix(".position.exr"));
    let digits = |n: &str| n.len() >= 5 && n.bytes().all(|b| b.is_ascii_digit());
    let (number, stem) = rest?.split_once('.').filter(|(number, stem)| digits(number) && !stem.is_empty())?;
    Some((number.parse().ok()?, stem))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_frames_count_as_frames() {
        assert_eq!(parts("frame_00012.shirt.position.exr"), Some((12, "shirt")));
        assert_eq!(parts("frame_123456.a.b.position.exr"), Some((123_456, "a.b")));
        for name in [
            "frame_12.shirt.position.exr",
            "frame_00012.position.exr",
            "frame_99999999999.a.position.exr",
            "my_frame_00012.a.position.exr",
            "x.exr",
        ] {
            assert_eq!(parts(name), None, "{name}");
        }
    }
}
