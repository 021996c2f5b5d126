//! Who makes the pictures: the GPU where the cloth is, else the CPU, which also has a ground with its shadow.

use gimage_runtime::draw::{SheetView, Software, View};
use gimage_runtime::scene::file::SceneFile;

use super::offscreen::Offscreen;
use super::shown::Shown;
use crate::commands::engine::Engine;
use crate::exit::Failure;

/// Most pixels of a picture: 8192 x 8192 would be 256 MiB, which is also what a WebGPU buffer may have.
const MOST: u64 = 8192 * 8192;

/// One of the two.
pub enum Painter {
    Gpu(Box<Offscreen>),
    Cpu(Box<Software>),
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
    /// The one that goes with the engine, or the one of the CPU.
    pub fn new(engine: &Engine, size: (u32, u32), file: &SceneFile, on_cpu: bool) -> Result<Self, Failure> {
        if let Some((device, queue)) = engine.gpu().filter(|_| !on_cpu) {
            let mut offscreen = Offscreen::new(device, queue, size)?;
            offscreen.draw.set_solid_look(file.solid_look.clone());
            file.looks.iter().enumerate().for_each(|(c, look)| offscreen.draw.set_look(c, look.clone()));
            return Ok(Painter::Gpu(Box::new(offscreen)));
        }
        let mut software = Software::new(size.0, size.1, engine.stepper.options().threads)?;
        software.solid_look = file.solid_look.clone();
        file.looks.iter().enumerate().for_each(|(c, look)| software.set_look(c, look.clone()));
        Ok(Painter::Cpu(Box::new(software)))
    }

    /// Leaves out cloths and colliders that triangles stand for, and takes their paints.
    pub fn wear(&mut self, shown: &Shown, engine: &Engine) {
        let (hidden, scene) = (self.hidden(), engine.stepper.scene());
        hidden.cloths.extend((0..scene.cloths.len()).filter(|cloth| shown.has_cloth(*cloth)));
        let animated = engine.animated();
        hidden.colliders.extend((0..scene.colliders.len()).filter(|index| shown.hides_collider(*index, animated)));
        match self {
            Painter::Gpu(offscreen) => offscreen.draw.set_paints(shown.paints.list()),
            Painter::Cpu(software) => software.set_paints(shown.paints.list()),
        }
    }

    fn hidden(&mut self) -> &mut gimage_runtime::draw::Hidden {
        match self {
            Painter::Gpu(offscreen) => &mut offscreen.draw.hidden,
            Painter::Cpu(software) => &mut software.hidden,
        }
    }

    /// A picture of the scene and these triangles, as rows of sRGB pixels from the top.
    pub fn paint(
        &mut self,
        engine: &Engine,
        shown: &mut Shown,
        view: &View,
        fraction: f32,
    ) -> Result<Vec<[u8; 4]>, Failure> {
        let facets = if shown.is_empty() { Vec::new() } else { shown.facets(engine, fraction)? };
        match self {
            Painter::Gpu(offscreen) => {
                offscreen.draw.set_surface(&facets);
                offscreen.paint(&engine.stepper, view, fraction)
            }
            Painter::Cpu(software) => {
                software.set_surface(facets);
                if engine.gpu().is_none() {
                    return Ok(software.picture(&engine.stepper, view, fraction)?);
                }
                let read =
                    |c: usize| Ok((engine.positions(c)?, engine.previous(c)?, engine.normals(c)?, engine.holes(c)?));
                let count = engine.stepper.scene().cloths.len();
                let lists = (0..count).map(read).collect::<Result<Vec<_>, Failure>>()?;
                let sheets: Vec<_> = lists
                    .iter()
                    .map(|(now, before, normals, holes)| {
                        let holes = Some(holes.as_slice()).filter(|holes| !holes.is_empty());
                        SheetView { now, before, normals, holes }
                    })
                    .collect();
                Ok(software.picture_of(&engine.stepper, &sheets, view, fraction)?)
            }
        }
    }
}
