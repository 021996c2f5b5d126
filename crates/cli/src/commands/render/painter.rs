//! Who makes the pictures: the GPU where the cloth is, else the CPU.

use gimage_runtime::draw::{Facet, Software, View};
use gimage_runtime::scene::file::SceneFile;

use super::body::Body;
use super::offscreen::Offscreen;
use crate::commands::engine::Engine;
use crate::exit::Failure;

/// Most pixels of a picture: 8192 x 8192 would be 256 MiB, which is also what a WebGPU buffer may have.
const MOST: u64 = 8192 * 8192;

/// One of the two.
pub enum Painter {
    Gpu(Box<Offscreen>),
    Cpu(Software),
}

/// Refuses sizes that no painter takes, before anything is done.
pub fn check_size((width, height): (u32, u32)) -> Result<(), Failure> {
    let side = |s: u32| (1..=8192).contains(&s);
    if side(width) && side(height) && u64::from(width) * u64::from(height) <= MOST {
        return Ok(());
    }
    Err(Failure::refused(format!("--size {width}x{height}: give sides of 1 to 8192 pixels")))
}

impl Painter {
    /// The one that goes with the engine.
    pub fn new(engine: &Engine, size: (u32, u32), file: &SceneFile) -> Result<Self, Failure> {
        if let Some((device, queue)) = engine.gpu() {
            let mut offscreen = Offscreen::new(device, queue, size)?;
            offscreen.draw.set_solid_look(file.solid_look.clone());
            file.looks.iter().enumerate().for_each(|(c, look)| offscreen.draw.set_look(c, look.clone()));
            return Ok(Painter::Gpu(Box::new(offscreen)));
        }
        let mut software = Software::new(size.0, size.1, engine.stepper.options().threads)?;
        software.solid_look = file.solid_look.clone();
        file.looks.iter().enumerate().for_each(|(c, look)| software.set_look(c, look.clone()));
        Ok(Painter::Cpu(software))
    }

    /// Leaves a collider out of pictures.
    pub fn hide_collider(&mut self, index: usize) {
        match self {
            Painter::Gpu(offscreen) => offscreen.draw.hide_collider(index, true),
            Painter::Cpu(software) => software.hide_collider(index, true),
        }
    }

    /// Leaves out the cloths that a character wears in the colours of its file.
    pub fn wear(&mut self, body: &Body, cloths: usize) {
        for cloth in (0..cloths).filter(|cloth| body.wears(*cloth)) {
            match self {
                Painter::Gpu(offscreen) => offscreen.draw.hide_cloth(cloth, true),
                Painter::Cpu(software) => software.hide_cloth(cloth, true),
            }
        }
    }

    /// Draws these triangles beside the scene.
    pub fn set_surface(&mut self, facets: Vec<Facet>) {
        match self {
            Painter::Gpu(offscreen) => offscreen.draw.set_surface(&facets),
            Painter::Cpu(software) => software.set_surface(facets),
        }
    }

    /// A picture as rows of sRGB pixels from the top.
    pub fn paint(&mut self, engine: &Engine, view: &View, fraction: f32) -> Result<Vec<[u8; 4]>, Failure> {
        match self {
            Painter::Gpu(offscreen) => offscreen.paint(&engine.stepper, view, fraction),
            Painter::Cpu(software) => Ok(software.picture(&engine.stepper, view, fraction)?),
        }
    }
}
