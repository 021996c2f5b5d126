//! One scene under one solver, frame by frame, so that runs can take turns.

use std::fs;
use std::path::PathBuf;

use gimage_bench_host::{FRAME, Gpu, Host};
use gimage_bundle::{Image, encode_exr};
use gimage_runtime::scene::builtin;
use gimage_runtime::{Backend, Cloth, Options, Scene};

use crate::Failure;
use crate::row::Row;
use crate::score::Score;
use crate::variant::Variant;

/// Which run.
#[derive(Clone)]
pub struct Setting {
    /// A built-in scene.
    pub scene: String,
    /// Particles along a side.
    pub n: u32,
    /// The solver.
    pub variant: Variant,
    /// Steps per frame.
    pub substeps: u32,
}

/// A run under way.
pub struct Run<'a> {
    setting: Setting,
    scene: Scene,
    gpu: Option<&'a Gpu>,
    host: Host<'a>,
    score: Score,
    frame: u32,
    times: Vec<f64>,
    dump: Option<PathBuf>,
}

impl<'a> Run<'a> {
    /// A run at its start. Positions of its first pass go to `dump`, in a folder of its own.
    pub fn new(setting: Setting, gpu: Option<&'a Gpu>, dump: Option<&PathBuf>) -> Result<Self, Failure> {
        let Setting { scene: name, n, variant, substeps } = &setting;
        let scene = builtin(name, *n)?;
        let host = Host::new(scene.clone(), options(&setting, gpu), gpu)?;
        let score = Score::new(name, *n, scene.frames, &scene.cloths[0]);
        let dump = dump.map(|d| d.join(format!("{name}-{n}-{}-{substeps}", variant.name)));
        if let Some(dir) = &dump {
            fs::create_dir_all(dir)?;
        }
        let mut run = Run { setting, scene, gpu, host, score, frame: 0, times: Vec::new(), dump };
        run.look()?;
        Ok(run)
    }

    /// Whether the solver makes as many steps as were asked for, and not more.
    pub fn is_as_asked(&self) -> bool {
        self.host.stepper.substeps() == self.setting.substeps
    }

    /// Frames of the scene.
    pub fn length(&self) -> u32 {
        self.scene.frames
    }

    /// Makes `count` more frames. Past the end it starts again, for the clock alone.
    pub fn go_on(&mut self, count: u32) -> Result<(), Failure> {
        for _ in 0..count {
            if self.frame > 0 && self.frame.is_multiple_of(self.scene.frames) {
                self.host = Host::new(self.scene.clone(), options(&self.setting, self.gpu), self.gpu)?;
            }
            self.times.push(self.host.timed(FRAME)?);
            self.frame += 1;
            self.look()?;
        }
        Ok(())
    }

    /// Takes the figures of a frame and writes it out.
    fn look(&mut self) -> Result<(), Failure> {
        let frame = self.frame;
        if frame > self.scene.frames || !self.score.wants(frame) {
            return Ok(());
        }
        let positions = self.host.now()?;
        self.score.push(frame, &positions);
        if let Some(dir) = &self.dump {
            let cloth = &self.scene.cloths[0];
            let file = dir.join(format!("frame_{frame:05}.{}.position.exr", self.setting.scene));
            fs::write(file, encode_exr(&image(cloth, &positions))?)?;
        }
        Ok(())
    }

    /// The row of the table.
    pub fn row(&mut self) -> Row {
        self.times.sort_by(f64::total_cmp);
        let Setting { scene, n, variant, substeps } = &self.setting;
        Row {
            scene: scene.clone(),
            n: *n,
            solver: variant.name.clone(),
            substeps: *substeps,
            backend: if self.gpu.is_some() { "gpu" } else { "cpu" },
            frames: self.times.len(),
            ms_min: self.times[0],
            ms_median: self.times[self.times.len() / 2],
            figures: self.score.figures(),
        }
    }
}

fn options(setting: &Setting, gpu: Option<&Gpu>) -> Options {
    let backend = if gpu.is_some() { Backend::Gpu } else { Backend::Cpu };
    let base = Options { backend, threads: 1, normals: false, ..Options::default() };
    setting.variant.options(setting.substeps, &base)
}

fn image(cloth: &Cloth, positions: &[[f32; 4]]) -> Image {
    let grid = &cloth.grids()[0];
    let mut image = Image::zeros(grid.width, grid.height, 4);
    for (k, texel) in image.data.chunks_exact_mut(4).enumerate() {
        texel[..3].copy_from_slice(&positions[k][..3]);
        // Checked when the cloth was made.
        texel[3] = cloth.particles()[k].code().unwrap_or(0.0);
    }
    image
}
