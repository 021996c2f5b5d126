//! Measuring which sizes of workgroups and of tiles suit a device.

use web_time::Instant;

use super::Stepper;
use crate::cloth::Flat;
use crate::error::Result;
use crate::fused::Room;
#[cfg(not(target_family = "wasm"))]
use crate::gpu::block_on;
use crate::gpu::{Pipelines, Span, guard_async, read_back_async};
use crate::options::{Backend, Options};
use crate::scene::Scene;
use crate::tuning::Tuning;

/// Length \[s\] of a frame, and its steps.
const FRAME: f64 = 1.0 / 60.0;
const STEPS: u32 = 8;
/// Frames of a measurement, which are submitted together, and measurements, of which the shortest counts.
const FRAMES: u32 = 8;
const REPEATS: u32 = 3;
/// Sizes that are tried: threads of a workgroup, and particles of a tile.
const THREADS: [u32; 5] = [1024, 512, 256, 128, 64];
const PARTICLES: [u32; 4] = [512, 1024, 2304, 4096];
/// Particles along each side of a cloth that is alone, in ascending order.
const SIDES: [u32; 3] = [32, 48, 64];
/// Share of the time that another size has to save, beside noise.
const GAIN: f64 = 0.03;

/// A device and its queue.
type Handles<'a> = (&'a wgpu::Device, &'a wgpu::Queue);

impl Stepper {
    /// Measures which sizes of workgroups and of tiles suit a device: whole frames of many cloths and tiles of a large one, with each of
    /// up to 14 sizes, and both forms of three cloths that are alone. Submits to the queue and waits: up to some seconds, most of it compilation; a host does it once per
    /// device and driver, and keeps the result. Wall clock, so other work on the device disturbs it. Errors on a device that is lost or has
    /// no memory left.
    ///
    /// A size stays `None` if no other one saves 3 % of the time. A page in a browser cannot wait, and awaits
    /// [`Stepper::tune_async`].
    #[cfg(not(target_family = "wasm"))]
    pub fn tune(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Tuning> {
        block_on(device, Stepper::tune_async(device, queue))
    }

    /// [`Stepper::tune`] without waiting. Elsewhere than in a browser the host polls the device meanwhile ([`wgpu::Device::poll`]).
    pub async fn tune_async(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Tuning> {
        let (room, handles) = (Room::of(device), (device, queue));
        let pipelines = Pipelines::new(device, None);
        let mut best = Tuning::default();
        let whole = crowd(&room)?;
        let sizes = THREADS.iter().filter(|n| **n <= room.threads).map(|n| Tuning { whole_threads: Some(*n), ..best });
        best = fastest((handles, &pipelines), &whole, best, sizes.collect()).await?;
        let large = sheet(&room)?;
        let most = room.memory / 16;
        let sizes = PARTICLES.iter().filter(|n| **n <= most).map(|n| Tuning { tile_particles: Some(*n), ..best });
        best = fastest((handles, &pipelines), &large, best, sizes.collect()).await?;
        let sizes = THREADS.iter().filter(|n| **n <= room.threads).map(|n| Tuning { tile_threads: Some(*n), ..best });
        best = fastest((handles, &pipelines), &large, best, sizes.collect()).await?;
        whole_of((handles, &pipelines), best, &room).await
    }
}

/// With the largest cloth that one workgroup runs faster than tiles do, where it is not the usual one.
async fn whole_of(on: (Handles<'_>, &Pipelines), best: Tuning, room: &Room) -> Result<Tuning> {
    let (mut usual, mut most, mut faster) = (0, 0, true);
    for side in SIDES {
        let (particles, mut scene) = (side * side, Scene::new("tuning"));
        scene.cloths.push(hung("alone", side)?);
        if !room.holds(&scene.cloths[0]) {
            break;
        }
        let of = |most| Tuning { whole_particles: Some(most), ..best };
        let [whole, tiled] = [measure(on, &scene, of(particles)).await?, measure(on, &scene, of(0)).await?];
        let is_usual = particles <= room.whole;
        faster &= if is_usual { whole * (1.0 - GAIN) < tiled } else { whole < tiled * (1.0 - GAIN) };
        (usual, most) = (if is_usual { particles } else { usual }, if faster { particles } else { most });
    }
    Ok(Tuning { whole_particles: (most != usual).then_some(most), ..best })
}

/// The sizes with which a scene takes the least time; those of before unless others are quicker.
async fn fastest(on: (Handles<'_>, &Pipelines), scene: &Scene, before: Tuning, sizes: Vec<Tuning>) -> Result<Tuning> {
    // A single size is what limits lead to.
    if sizes.len() < 2 {
        return Ok(before);
    }
    let mut best = (before, measure(on, scene, before).await? * (1.0 - GAIN));
    for tuning in sizes {
        let ms = measure(on, scene, tuning).await?;
        if ms < best.1 {
            best = (tuning, ms);
        }
    }
    Ok(best.0)
}

/// Time \[ms\] of some frames of a scene.
async fn measure((handles, pipelines): (Handles<'_>, &Pipelines), scene: &Scene, tuning: Tuning) -> Result<f64> {
    let backend = Backend::Gpu;
    let options = Options { backend, substeps: Some(STEPS), tuning: Some(tuning), ..Options::default() };
    let make = || Stepper::unchecked(scene.clone(), options, Some(handles), Some(pipelines.share()));
    let mut stepper = guard_async(handles.0, make).await?;
    let mut least = f64::INFINITY;
    // The first time counts for nothing: buffers are made.
    for repeat in 0..=REPEATS {
        let start = Instant::now();
        let end = frames(&mut stepper, handles)?;
        read_back_async(handles.0, handles.1, &end).await?;
        if repeat > 0 {
            least = least.min(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    Ok(least)
}

/// Submits frames, and returns a part of their result.
fn frames(stepper: &mut Stepper, (device, queue): Handles<'_>) -> Result<Span> {
    let mut encoder = device.create_command_encoder(&Default::default());
    for _ in 0..FRAMES {
        stepper.record(&mut encoder, FRAME)?;
    }
    queue.submit([encoder.finish()]);
    let now = stepper.buffers(0).map(|buffers| buffers.now.clone());
    now.map(|span| Span { size: 16, ..span }).ok_or(crate::Error::NoGpu("Stepper::tune"))
}

/// Cloths that run whole frames, as large as the memory of a workgroup holds and enough to keep a device busy.
fn crowd(room: &Room) -> Result<Scene> {
    let side = f64::from(room.memory / 12).sqrt() as u32;
    let mut scene = Scene::new("tuning");
    let cloth = hung("cloth", side.clamp(8, 64))?;
    scene.cloths = vec![cloth; room.busy.clamp(1, 64) as usize];
    Ok(scene)
}

/// A cloth that runs by tiles.
fn sheet(room: &Room) -> Result<Scene> {
    let mut scene = Scene::new("tuning");
    scene.cloths.push(hung("sheet", if room.busy < 64 { 128 } else { 512 })?);
    Ok(scene)
}

fn hung(name: &str, side: u32) -> Result<crate::Cloth> {
    let mut cloth = Flat { down: [0.0, -1.0, 0.0], ..Flat::square(name, side) }.cloth()?;
    cloth.set_pinned(0, true)?;
    cloth.set_pinned(side as usize - 1, true)?;
    Ok(cloth)
}
