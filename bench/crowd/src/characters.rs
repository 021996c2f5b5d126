//! Measures the time of dressed characters that walk, one alone and many together.

use std::path::Path;
use std::time::Instant;

use gimage::colliders::{ColliderOptions, Tier};
use gimage::import::{Character, ImportOptions};
use gimage::options::{BuildOptions, ImageSize};
use gimage::pipeline::dress;
use gimage::progress::Quiet;
use gimage_bench_host::FRAME;
use gimage_runtime::{BodyCollider, Cloth, Options, Scene, Skin, Stepper};
use rayon::prelude::*;

type Error = Box<dyn std::error::Error>;

/// Seconds in which a character goes from the pose of its file into the animation.
const LEAD: f64 = 1.0;
/// Names of the timed variants, and whether joints move and colliders are there.
const VARIANTS: [(&str, [bool; 2]); 3] =
    [("whole", [true, true]), ("no contact", [true, false]), ("no joints", [false, true])];

/// A character file, dressed, and the joints of its animation over time.
struct Model {
    cloth: Cloth,
    skin: Skin,
    body: Vec<BodyCollider>,
    character: Character,
    nodes: Vec<usize>,
}

/// A character with a stepper of its own, some seconds ahead of others.
struct Actor<'a> {
    model: &'a Model,
    stepper: Stepper,
    ahead: f64,
    frame: u32,
    moves: bool,
}

impl Model {
    fn new(file: &Path, animation: &str, size: ImageSize) -> Result<Self, Error> {
        let mut options = BuildOptions::default();
        options.image.size = size;
        let solids = ColliderOptions { tier: Tier::Capsules, ..ColliderOptions::default() };
        let bundle = dress(file, &options, &solids, &Quiet)?.bundle;
        let cloth = Cloth::from_bundle("clothes", &bundle)?;
        let skin = cloth.skin().ok_or("the file has no joints")?.clone();
        let character = Character::read(file, animation, &ImportOptions::default())?;
        let nodes = skin.joints().iter().map(|j| character.node(&j.name)).collect::<Result<_, _>>()?;
        Ok(Model { cloth, skin, body: BodyCollider::of_bundle(&bundle), character, nodes })
    }

    /// Joint matrices at a time before 0, on the way into the animation, or after it.
    fn joints(&self, time: f64, ahead: f64) -> gimage_runtime::Result<Vec<[f32; 16]>> {
        let worlds = self.character.worlds_between(time + ahead, (1.0 + time / LEAD).clamp(0.0, 1.0));
        self.skin.matrices(&self.nodes.iter().map(|n| worlds[*n].map(|x| x as f32)).collect::<Vec<_>>())
    }

    fn actor(&self, ahead: f64, [joints, contact]: [bool; 2], threads: usize) -> gimage_runtime::Result<Actor<'_>> {
        let mut cloth = self.cloth.clone();
        cloth.follow_joints(&self.joints(-LEAD, ahead)?)?;
        let colliders = if contact { self.body.iter().map(|part| part.collider).collect() } else { Vec::new() };
        let scene = Scene { cloths: vec![cloth], colliders, ..Scene::new("character") };
        let stepper = Stepper::on_cpu(scene, Options { threads, ..Options::default() })?;
        let mut actor = Actor { model: self, stepper, ahead, frame: 0, moves: true };
        (0..(LEAD / FRAME) as u32).try_for_each(|_| actor.frame())?;
        actor.moves = joints;
        Ok(actor)
    }
}

impl Actor<'_> {
    fn frame(&mut self) -> gimage_runtime::Result<()> {
        self.frame += 1;
        let matrices = self.model.joints(f64::from(self.frame) * FRAME - LEAD, self.ahead)?;
        if self.moves {
            self.stepper.set_joints(0, &matrices)?;
        }
        if !self.stepper.scene().colliders.is_empty() {
            self.stepper.move_body(0, 0, &self.model.body, &matrices)?;
        }
        self.stepper.advance(FRAME)?;
        // They are drawn.
        _ = self.stepper.normals(0);
        Ok(())
    }
}

/// Prints the times of one character on one core, whole and with parts turned off, and of a number of them on all cores. CSV to stdout.
#[allow(clippy::print_stdout)]
pub fn print(file: &Path, animation: &str, counts: &[u32], frames: u32) -> Result<(), Error> {
    println!(
        "size,particles,colliders,substeps,polish,characters,threads,variant,frames,ms_min,ms_median,ms_per_character"
    );
    let sizes = [("64x64 per piece", ImageSize::Exact(64, 64)), ("16384 texels", ImageSize::Texels(16_384))];
    for (name, size) in sizes {
        let model = Model::new(file, animation, size)?;
        let row = |stepper: &Stepper, count: usize, threads: usize, variant: &str, mut times: Vec<f64>| {
            times.sort_by(f64::total_cmp);
            let (least, median) = (times[0], times[times.len() / 2]);
            let (particles, colliders) = (stepper.scene().cloths[0].len(), stepper.scene().colliders.len());
            println!(
                "{name},{particles},{colliders},{},{},{count},{threads},{variant},{},{least:.3},{median:.3},{:.4}",
                stepper.substeps(),
                stepper.polish(),
                times.len(),
                least / count as f64
            );
        };
        let mut alone = VARIANTS
            .iter()
            .map(|(_, parts)| model.actor(0.0, *parts, 1))
            .collect::<gimage_runtime::Result<Vec<_>>>()?;
        let mut times = vec![Vec::new(); alone.len()];
        // The variants take turns frame by frame, so that other programs slow all of them alike.
        for _ in 0..frames.max(1) {
            for (actor, times) in alone.iter_mut().zip(&mut times) {
                let start = Instant::now();
                actor.frame()?;
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
        for ((actor, (variant, _)), times) in alone.iter().zip(VARIANTS).zip(times) {
            row(&actor.stepper, 1, 1, variant, times);
        }
        for &count in counts {
            let seconds = model.character.seconds();
            let ahead = |k: u32| seconds * f64::from(k) / f64::from(count);
            let mut all = (0..count)
                .into_par_iter()
                .map(|k| model.actor(ahead(k), [true, true], 1))
                .collect::<gimage_runtime::Result<Vec<_>>>()?;
            let mut times = Vec::new();
            for _ in 0..frames.clamp(1, 20) {
                let start = Instant::now();
                all.par_iter_mut().try_for_each(Actor::frame)?;
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
            if let Some(actor) = all.first() {
                row(&actor.stepper, all.len(), rayon::current_num_threads(), "whole", times);
            }
        }
    }
    Ok(())
}
