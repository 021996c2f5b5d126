//! Dumped frames, read back.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use gimage_bundle::{Image, decode_exr, decode_exr_sized, file_stems};
use gimage_runtime::{Cloth, Grid, Mass, Particle, Parts, Rest};

use crate::commands::simulate::dump::files;
use crate::exit::Failure;

/// The largest distance \[m\] between duplicates of a seam point in a frame: they move alike, up to the end of a step.
const LARGEST_GAP: f32 = 1e-3;

/// A directory of frames.
pub struct Frames {
    dir: PathBuf,
    /// The cloths of the scene, or one per image.
    pub cloths: Vec<Cloth>,
    /// The stems of the grids of all cloths.
    stems: Vec<String>,
    files: BTreeMap<u32, BTreeMap<String, PathBuf>>,
}

impl Frames {
    /// Lists the frames of a directory. Without the cloths of a scene each image of the first frame is a cloth. Refuses a directory without
    /// frames, and images whose seams lead to other images.
    pub fn open(dir: &Path, scene: Option<&[Cloth]>) -> Result<Self, Failure> {
        let mut found: BTreeMap<u32, BTreeMap<String, PathBuf>> = BTreeMap::new();
        for file in files(dir)? {
            found.entry(file.frame).or_default().insert(file.stem, file.path);
        }
        let Some((_, first)) = found.first_key_value() else {
            let hint = "give a directory of `gimage simulate --dump`, or a bundle";
            return Err(Failure::refused(format!("{}: neither frames nor a manifest.json; {hint}", dir.display())));
        };
        let (cloths, stems) = match scene {
            Some(cloths) => {
                let grids = cloths.iter().flat_map(Cloth::grids);
                (cloths.to_vec(), file_stems(grids.map(|grid| grid.name.as_str())))
            }
            None => {
                let cloths = first.iter().map(|(stem, path)| alone(stem, path)).collect::<Result<_, _>>()?;
                (cloths, first.keys().cloned().collect())
            }
        };
        Ok(Frames { dir: dir.into(), cloths, stems, files: found })
    }

    /// The frames, in order.
    pub fn numbers(&self) -> impl Iterator<Item = u32> {
        self.files.keys().copied()
    }

    /// Positions \[m\] of all cloths in a frame. Refuses a frame whose images are not those of the cloths.
    pub fn read(&self, frame: u32) -> Result<Vec<Vec<[f32; 4]>>, Failure> {
        let none = BTreeMap::new();
        let files = self.files.get(&frame).unwrap_or(&none);
        let refused = |problem: String| {
            let dir = self.dir.display();
            Failure::refused(format!("{dir}: frame {frame}: {problem}; give the simulated scene by --scene and --n"))
        };
        let known: BTreeSet<_> = self.stems.iter().collect();
        if let Some(other) = files.keys().find(|stem| !known.contains(stem)) {
            return Err(refused(format!("there is an image of {other}, which is not a piece of the scene")));
        }
        let mut stems = self.stems.iter();
        let mut all = Vec::new();
        for cloth in &self.cloths {
            let mut positions = Vec::with_capacity(cloth.len());
            for (grid, stem) in cloth.grids().iter().zip(&mut stems) {
                let path =
                    files.get(stem).ok_or_else(|| refused(format!("the frame lacks an image of piece {stem}")))?;
                let name = path.display().to_string();
                let image = decode_exr_sized(&name, &bytes(path)?, grid.width, grid.height, &[4]);
                let texels = texels(&image.map_err(|e| refused(e.to_string()))?);
                // Pins, which are the sign of a code, may change from frame to frame.
                let code = |k: usize| cloth.particles()[k].code().unwrap_or(0.0).abs();
                if let Some(k) = grid.range().zip(&texels).find(|(k, t)| code(*k) != t[3].abs()).map(|(k, _)| k) {
                    let k = k - grid.range().start;
                    return Err(refused(format!("particle {k} of piece {stem} is not that of the scene")));
                }
                positions.extend(texels);
            }
            all.push(positions);
        }
        Ok(all)
    }
}

fn bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    fs::read(path).map_err(|e| Failure::io(path, &e))
}

fn texels(image: &Image) -> Vec<[f32; 4]> {
    image.data.chunks_exact(4).map(|t| [t[0], t[1], t[2], t[3]]).collect()
}

/// A cloth of one image. Its seams must lead from point to point of the image, and to points at the same place.
fn alone(stem: &str, path: &Path) -> Result<Cloth, Failure> {
    let name = path.display().to_string();
    let refused = |problem: String| Failure::refused(format!("{name}: {problem}"));
    let image = decode_exr(&name, &bytes(path)?)?;
    if image.channels != 4 {
        return Err(refused(format!("{} channels; an image of positions has 4", image.channels)));
    }
    let texels = texels(&image);
    let particles = texels.iter().map(|t| Particle::from_code(t[3])).collect::<Result<Vec<_>, _>>();
    let particles = particles.map_err(|e| refused(e.to_string()))?;
    let elsewhere = || refused("its seams lead to other images; give the simulated scene by --scene".into());
    let apart = |k: usize, next: u32| {
        let other = texels.get(next as usize).copied().unwrap_or([f32::INFINITY; 4]);
        (0..3).any(|c| (texels[k][c] - other[c]).abs() > LARGEST_GAP)
    };
    if particles.iter().enumerate().any(|(k, p)| p.next().is_some_and(|next| apart(k, next))) {
        return Err(elsewhere());
    }
    let (width, height) = (image.width, image.height);
    let cloth = Cloth::new(Parts {
        name: stem.into(),
        grids: vec![Grid { name: stem.into(), first: 0, width, height }],
        // Frames have the positions, some of which may not be finite.
        positions: vec![[0.0; 3]; texels.len()],
        particles,
        rest: Rest::None,
        mass: Mass::Constant(1.0),
    });
    cloth.map_err(|error| if matches!(error, gimage_runtime::Error::Seam { .. }) { elsewhere() } else { error.into() })
}
