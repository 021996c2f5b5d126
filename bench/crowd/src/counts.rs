//! Counts that depend on no clock, of scenes with many cloths on a device with WebGPU's default limits.

use std::time::Instant;

use gimage_bench_host::{FRAME, Gpu, Host};
use gimage_runtime::{Cloth, Collider, Flat, Form, Options, Result, Scene, Shape};

use crate::garment;

/// Frames before counting: pipelines are compiled, and buffers grow to their sizes.
const WARM_UP: u32 = 2;
/// Frames that are recorded.
const FRAMES: u32 = 5;

/// Changes of a scene before each frame.
#[derive(Clone, Copy)]
enum Change {
    None,
    /// One collider moves.
    Collider,
    /// All pins of the first cloth move.
    Pins,
}

/// A scene of the table.
struct Row {
    name: &'static str,
    scene: Scene,
    tethers: u32,
    pyramid: u32,
    change: Change,
}

/// Prints the table as CSV: dispatches of a frame, queue writes of a frame, host time of the change and of the recording [ms, least],
/// bytes of device memory per particle, and bytes that a step by tiles moves per particle of the first cloth.
#[allow(clippy::print_stdout)]
pub fn print(gpu: &Gpu, substeps: u32) -> Result<()> {
    println!(
        "scene,cloths,particles,dispatches,writes_per_frame,ms_change,ms_record,device_bytes_per_particle,tile_bytes_per_step"
    );
    for Row { name, scene, tethers, pyramid, change } in rows()? {
        let options = Options { substeps: Some(substeps), polish: Some(0), tethers, pyramid, ..Options::default() };
        let (cloths, particles) = (scene.cloths.len(), scene.cloths.iter().map(Cloth::len).sum::<usize>());
        let mut host = Host::new(scene, options, Some(gpu))?;
        for _ in 0..WARM_UP {
            host.timed(FRAME)?;
        }
        let writes = |host: &Host| host.stepper.uploads().map_or(0, |u| u.writes);
        let before = writes(&host);
        let mut least = [f64::INFINITY; 2];
        for n in 0..FRAMES {
            let start = Instant::now();
            apply(&mut host, change, n)?;
            least[0] = least[0].min(milliseconds(start));
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let start = Instant::now();
            host.stepper.record(&mut encoder, FRAME)?;
            least[1] = least[1].min(milliseconds(start));
            gpu.queue.submit([encoder.finish()]);
            host.stepper.settle()?;
            // A lost device shows in the next call.
            let _ = gpu.device.poll(gimage_runtime::wgpu::PollType::wait_indefinitely());
        }
        let memory = host.stepper.memory();
        let bytes = (memory.device_images + memory.device_states) as f64 / particles as f64;
        let (dispatches, each) =
            (host.stepper.plan().dispatches(), (writes(&host) - before) as f64 / f64::from(FRAMES));
        let moved = tile_bytes(&host).map_or(String::new(), |bytes| format!("{bytes:.1}"));
        let [change, record] = least;
        println!("{name},{cloths},{particles},{dispatches},{each},{change:.3},{record:.3},{bytes:.0},{moved}");
    }
    Ok(())
}

/// The sum of [`gimage_runtime::Tile::traffic`] over the tiles of a step of the first cloth; none where whole frames run.
fn tile_bytes(host: &Host) -> Option<f64> {
    let sides: Vec<_> = host.stepper.scene().cloths[0].grids().iter().map(|g| [g.width, g.height]).collect();
    let passes = host.stepper.plan().passes.into_iter().filter(|p| p.cloth == 0);
    let tiles = passes.filter_map(|p| if let Form::Tile(tile) = p.form { Some(tile.traffic(&sides)) } else { None });
    tiles.reduce(|a, b| a + b)
}

fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

fn rows() -> Result<Vec<Row>> {
    let row = |name, scene, tethers| Row { name, scene, tethers, pyramid: 0, change: Change::None };
    let flat = |n, count| -> Result<Scene> { Ok(Scene { cloths: vec![sheet(n)?; count], ..Scene::new("flat") }) };
    let capsules = |count| -> Vec<Collider> {
        let shape = Shape::Capsule { radius: 0.1, half_height: 0.2 };
        (0..count).map(|k| Collider { friction: 0.3, ..Collider::new(shape, [0.2 * k as f32, 0.3, 0.2]) }).collect()
    };
    let worn = |count| -> Result<Scene> {
        Ok(Scene { cloths: vec![garment::skirt(64)?; count], colliders: capsules(4), ..Scene::new("worn") })
    };
    let met = |n, count| -> Result<Scene> { Ok(Scene { colliders: capsules(8), ..flat(n, count)? }) };
    let held = |name, scene| Row { pyramid: 4, ..row(name, scene, 0) };
    let sewn = |count| -> Result<Scene> { Ok(Scene { colliders: Vec::new(), ..worn(count)? }) };
    let mut rows = vec![
        row("flat 32 x 32", flat(32, 1000)?, 0),
        row("flat 32 x 32 with 8 capsules", met(32, 1000)?, 0),
        Row { change: Change::Collider, ..row("flat 32 x 32 and a collider that moves", met(32, 1000)?, 0) },
        row("garment of 4096 texels with a seam and 4 capsules", worn(1)?, 2),
        row("garments of 4096 texels with a seam and 4 capsules", worn(100)?, 2),
        Row { change: Change::Pins, ..row("garment whose pins move", worn(1)?, 2) },
        row("flat 128 x 128", flat(128, 10)?, 0),
        row("flat 128 x 128, more", flat(128, 16)?, 0),
        row("flat 256 x 256", flat(256, 1)?, 0),
        row("flat 256 x 256 with two tethers per particle", flat(256, 1)?, 2),
        row("flat 256 x 256 with 8 capsules", met(256, 1)?, 0),
        row("flat 256 x 256 with 8 capsules and two tethers per particle", met(256, 1)?, 2),
    ];
    for count in [1, 10, 100] {
        rows.push(held("flat 32 x 32 with a pyramid", flat(32, count)?));
        rows.push(held("flat 64 x 64 with a pyramid", flat(64, count)?));
        rows.push(held("garment of 4096 texels with a seam and a pyramid", sewn(count)?));
    }
    Ok(rows)
}

/// A sheet of `n` x `n` particles that two corners hold.
fn sheet(n: u32) -> Result<Cloth> {
    let mut cloth = Flat::square("flat", n).cloth()?;
    cloth.pin(&[0, n - 1])?;
    Ok(cloth)
}

fn apply(host: &mut Host, change: Change, frame: u32) -> Result<()> {
    match change {
        Change::None => Ok(()),
        Change::Collider => {
            let mut colliders = host.stepper.scene().colliders.clone();
            colliders[0].center[1] += 0.001 * frame as f32;
            host.stepper.set_colliders(colliders)
        }
        Change::Pins => {
            let cloth = &host.stepper.scene().cloths[0];
            let pins: Vec<u32> =
                (0..cloth.len() as u32).filter(|k| cloth.particles()[*k as usize].is_pinned()).collect();
            let lift = 0.001 * (frame + 1) as f32;
            let at: Vec<_> =
                pins.iter().map(|k| cloth.positions()[*k as usize]).map(|[x, y, z]| [x, y + lift, z]).collect();
            host.stepper.set_pins(0, &pins, &at)
        }
    }
}
