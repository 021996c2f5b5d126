//! One run of a scene.

use std::fmt;
use std::time::Instant;

use gimage_bench_host::{Gpu, Host};
use gimage_runtime::crossings::{self, Drawn};
use gimage_runtime::{ClothContact, ContactTier, Options, Scene};

use crate::scenes::{self, Set};
use crate::{Cli, Tier};

/// An error of the runtime, or an unknown scene.
pub type Failure = Box<dyn std::error::Error>;

/// Frames after which the figures of cloths on the GPU are taken.
const EXAMINED: u32 = 10;

/// The figures of a run.
pub struct Row {
    scene: String,
    n: u32,
    /// Contact distance over the mean distance of neighbours, 0 for none.
    distance: f32,
    tier: Tier,
    cloths: usize,
    substeps: u32,
    frames: u32,
    /// Mean, largest and least time of a frame \[ms\].
    ms: [f64; 3],
    /// Mean and largest by the clock of the device, where it has one \[ms\].
    device_ms: Option<[f64; 2]>,
    /// Frames in which crossings were counted, and those in which there were some.
    counted: [u32; 2],
    /// Mean, largest and last number of crossings.
    crossings: [f64; 3],
    deepest_mm: f64,
    /// Largest 99th percentile of stretch, and the largest speed in the last second \[m/s\].
    stretch: f64,
    speed: f64,
    /// Length of the way of the mean position of all particles, from frame to frame \[m\], and the height at which it ends.
    way: f64,
    height: f64,
    /// Findings of the stepper.
    findings: usize,
}

impl Row {
    pub const HEAD: &'static str = "scene,n,distance,tier,cloths,substeps,frames,ms_mean,ms_max,ms_min,counted,crossed,\
        crossings_mean,crossings_max,crossings_last,deepest_mm,stretch_p99_worst,speed_rms_end,way_m,height_end_m,findings,\
        device_ms_mean,device_ms_max";
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Row { scene, n, distance, tier, cloths, substeps, frames, ms, counted, crossings, .. } = self;
        let tier = if *distance > 0.0 { format!("{tier:?}").to_lowercase() } else { "off".into() };
        write!(
            f,
            "{scene},{n},{distance},{tier},{cloths},{substeps},{frames},{:.4},{:.4},{:.4},",
            ms[0], ms[1], ms[2]
        )?;
        write!(f, "{},{},{:.1},{},{},", counted[0], counted[1], crossings[0], crossings[1], crossings[2])?;
        write!(f, "{:.2},{:.4},{:.4},", self.deepest_mm, self.stretch, self.speed)?;
        write!(f, "{:.4},{:.4},{},", self.way, self.height, self.findings)?;
        match self.device_ms {
            Some([mean, largest]) => write!(f, "{mean:.4},{largest:.4}"),
            None => write!(f, ","),
        }
    }
}

/// Steps a scene with a contact distance that is a multiple of the distance of neighbours.
pub fn run(cli: &Cli, name: &str, [n, layers]: [u32; 2], (distance, tier): (f32, Tier)) -> Result<Row, Failure> {
    let Set { mut scene, spacing, frame_s, friction, actions } = scenes::scene(name, n, layers)?;
    for (layer, cloth) in scene.cloths.iter_mut().enumerate() {
        let of = if tier == Tier::Safe { ContactTier::Safe } else { ContactTier::Particles };
        let layer = if cli.layered { layer as i32 } else { 0 };
        let contact = ClothContact { tier: of, distance: Some(distance * spacing), layer, friction };
        cloth.contact = (distance > 0.0).then_some(contact);
    }
    let frames = cli.frames.unwrap_or(scene.frames);
    let options = Options { threads: 1, substeps: cli.substeps, step: frame_s, normals: false, ..Options::default() };
    let gpu = if cli.gpu { Some(Gpu::new()?) } else { None };
    let mut host = Host::new(scene.clone(), options, gpu.as_ref())?;
    let (mut times, mut device_times, mut counts, mut deepest) = (Vec::<f64>::new(), Vec::new(), Vec::new(), 0.0f64);
    if cli.trace {
        eprintln!("{name} {n}: at the start, {} crossings", count(&scene, &positions(&host)?)?.total());
    }
    let (mut center, mut way) = (mean_position(&positions(&host)?), 0.0);
    for frame in 1..=frames {
        actions.iter().try_for_each(|action| action.lead(&mut host.stepper, f64::from(frame) * frame_s))?;
        let start = Instant::now();
        match gpu {
            Some(_) => host.frame(frame_s)?,
            // Without normals.
            None => _ = host.stepper.advance(frame_s)?,
        }
        let stepped = start.elapsed();
        let now = positions(&host)?;
        // The device steps until they are read back.
        let time = if cli.gpu { start.elapsed() } else { stepped };
        times.push(time.as_secs_f64() * 1e3);
        device_times.extend(host.device_ms());
        let middle = mean_position(&now);
        way += (0..3).map(|c| (middle[c] - center[c]).powi(2)).sum::<f64>().sqrt();
        center = middle;
        if frame.is_multiple_of(EXAMINED) || frame == frames {
            examine(&mut host, &now, cli.gpu)?;
        }
        if cli.every > 0 && frame.is_multiple_of(cli.every) {
            let found = count(&scene, &now)?;
            counts.push(found.total() as f64);
            if cli.trace {
                let ms = times.last().copied().unwrap_or(0.0);
                eprintln!("{name} {n}: frame {frame}, {} crossings, {ms:.1} ms", found.total());
            }
            deepest = deepest.max(found.deepest);
        }
    }
    let stepper = &host.stepper;
    stepper.findings().iter().for_each(|finding| eprintln!("{name} {n}: {finding}"));
    let health = (0..scene.cloths.len()).filter_map(|c| stepper.health(c));
    let (stretch, speed) = health.fold((0.0f64, 0.0f64), |most, (h, worst)| (most.0.max(worst), most.1.max(h.speed)));
    // The sum of nothing is -0.
    let mean = |list: &[f64]| list.iter().fold(0.0, |sum, x| sum + x) / list.len().max(1) as f64;
    let largest = |list: &[f64]| list.iter().copied().fold(0.0, f64::max);
    Ok(Row {
        scene: name.into(),
        n,
        distance,
        tier,
        cloths: scene.cloths.len(),
        substeps: stepper.substeps(),
        frames,
        device_ms: (!device_times.is_empty()).then(|| [mean(&device_times), largest(&device_times)]),
        ms: [mean(&times), largest(&times), times.iter().copied().fold(f64::INFINITY, f64::min)],
        counted: [counts.len() as u32, counts.iter().filter(|c| **c > 0.0).count() as u32],
        crossings: [mean(&counts), largest(&counts), counts.last().copied().unwrap_or(0.0)],
        deepest_mm: 1e3 * deepest,
        stretch,
        speed,
        way,
        height: center[1],
        findings: stepper.findings().len(),
    })
}

/// Where all cloths are.
fn positions(host: &Host) -> Result<Vec<Vec<[f32; 4]>>, Failure> {
    (0..host.stepper.scene().cloths.len()).map(|cloth| Ok(host.positions(cloth)?)).collect()
}

/// Has the stepper take the figures of all cloths; the CPU backend does so by itself.
fn examine(host: &mut Host, now: &[Vec<[f32; 4]>], on_gpu: bool) -> Result<(), Failure> {
    for (cloth, now) in now.iter().enumerate().filter(|_| on_gpu) {
        let before = host.previous(cloth)?;
        host.stepper.examine(cloth, now, &before)?;
    }
    Ok(())
}

/// Mean position \[m\] of the particles of all cloths.
fn mean_position(now: &[Vec<[f32; 4]>]) -> [f64; 3] {
    let (sum, count) = now
        .iter()
        .flatten()
        .fold(([0.0; 3], 0.0), |(sum, count), p| ([0, 1, 2].map(|c| sum[c] + f64::from(p[c])), count + 1.0));
    sum.map(|x| x / count)
}

fn count(scene: &Scene, now: &[Vec<[f32; 4]>]) -> Result<crossings::Crossings, Failure> {
    let drawn: Vec<Drawn> = scene.cloths.iter().zip(now).map(|(cloth, now)| Drawn::at(cloth, now)).collect();
    Ok(crossings::find(&drawn, 0)?)
}
