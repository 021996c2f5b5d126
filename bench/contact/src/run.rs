//! One run of a scene.

use std::fmt;
use std::time::Instant;

use gimage_runtime::crossings::{self, Drawn};
use gimage_runtime::{ClothContact, Options, Scene, Stepper};

use crate::{Cli, scenes};

/// An error of the runtime, or an unknown scene.
pub type Failure = Box<dyn std::error::Error>;

/// The figures of a run.
pub struct Row {
    scene: String,
    n: u32,
    /// Contact distance over the mean distance of neighbours, 0 for none.
    distance: f32,
    substeps: u32,
    frames: u32,
    /// Mean, largest and least time of a frame \[ms\].
    ms: [f64; 3],
    /// Frames in which crossings were counted, and those in which there were some.
    counted: [u32; 2],
    /// Mean, largest and last number of crossings.
    crossings: [f64; 3],
    deepest_mm: f64,
    /// Largest 99th percentile of stretch, and the largest speed in the last second \[m/s\].
    stretch: f64,
    speed: f64,
}

impl Row {
    pub const HEAD: &'static str = "scene,n,distance,substeps,frames,ms_mean,ms_max,ms_min,counted,crossed,\
        crossings_mean,crossings_max,crossings_last,deepest_mm,stretch_p99_worst,speed_rms_end";
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Row { scene, n, distance, substeps, frames, ms, counted, crossings, .. } = self;
        write!(f, "{scene},{n},{distance},{substeps},{frames},{:.4},{:.4},{:.4},", ms[0], ms[1], ms[2])?;
        write!(f, "{},{},{:.1},{},{},", counted[0], counted[1], crossings[0], crossings[1], crossings[2])?;
        write!(f, "{:.2},{:.4},{:.4}", self.deepest_mm, self.stretch, self.speed)
    }
}

/// Steps a scene with a contact distance that is a multiple of the distance of neighbours.
pub fn run(cli: &Cli, name: &str, n: u32, distance: f32) -> Result<Row, Failure> {
    let (mut scene, spacing) = scenes::scene(name, n)?;
    for cloth in &mut scene.cloths {
        let contact = ClothContact { distance: Some(distance * spacing), ..ClothContact::default() };
        cloth.contact = (distance > 0.0).then_some(contact);
    }
    let frames = cli.frames.unwrap_or(scene.frames);
    let options = Options { threads: 1, substeps: cli.substeps, normals: false, ..Options::default() };
    let mut stepper = Stepper::on_cpu(scene.clone(), options)?;
    let (mut times, mut counts, mut deepest) = (Vec::new(), Vec::new(), 0.0f64);
    for frame in 1..=frames {
        let start = Instant::now();
        stepper.advance(1.0 / 60.0)?;
        times.push(start.elapsed().as_secs_f64() * 1e3);
        if cli.every > 0 && frame.is_multiple_of(cli.every) {
            let found = count(&scene, &stepper)?;
            counts.push(found.total() as f64);
            deepest = deepest.max(found.deepest);
        }
    }
    let health = (0..scene.cloths.len()).filter_map(|c| stepper.health(c));
    let (stretch, speed) = health.fold((0.0f64, 0.0f64), |most, (h, worst)| (most.0.max(worst), most.1.max(h.speed)));
    let mean = |list: &[f64]| list.iter().sum::<f64>() / list.len().max(1) as f64;
    let largest = |list: &[f64]| list.iter().copied().fold(0.0, f64::max);
    Ok(Row {
        scene: name.into(),
        n,
        distance,
        substeps: stepper.substeps(),
        frames,
        ms: [mean(&times), largest(&times), times.iter().copied().fold(f64::INFINITY, f64::min)],
        counted: [counts.len() as u32, counts.iter().filter(|c| **c > 0.0).count() as u32],
        crossings: [mean(&counts), largest(&counts), counts.last().copied().unwrap_or(0.0)],
        deepest_mm: 1e3 * deepest,
        stretch,
        speed,
    })
}

fn count(scene: &Scene, stepper: &Stepper) -> Result<crossings::Crossings, Failure> {
    let drawn: Vec<Drawn> = scene
        .cloths
        .iter()
        .enumerate()
        .filter_map(|(c, cloth)| Some(Drawn::at(cloth, stepper.positions(c)?)))
        .collect();
    Ok(crossings::find(&drawn, 0)?)
}
