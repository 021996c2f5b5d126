//! A crowd in shawls: actors come and go while the others move, the game is saved and loaded, and its device is lost once. Both
//! disturbances leave the end of the game as it is, bit for bit. The number of frames is an argument, 1,000 by default.
// An example speaks for itself.
#![allow(clippy::print_stdout)]

use std::collections::VecDeque;

use gimage_runtime::{Cloth, ClothHandle, Collider, Flat, Options, Scene, Shape};
use gimage_runtime::{Snapshot, Stepper, device_limits, wgpu};

const DT: f64 = 1.0 / 60.0;
/// Actors that are there at once, and frames from one entrance to the next.
const ACTORS: usize = 3;
const PERIOD: u32 = 4;

type Device = (wgpu::Device, wgpu::Queue);
type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// An actor: a capsule that walks, and a shawl on its shoulders.
struct Actor {
    entered: u32,
    shawl: ClothHandle,
}

/// The contents of a save file.
struct Save {
    frame: u32,
    entered: Vec<u32>,
    cloths: Vec<u8>,
}

struct Game {
    /// None on machines without an adapter, where the CPU steps.
    device: Option<Device>,
    stepper: Stepper,
    shawl: Cloth,
    actors: VecDeque<Actor>,
    frame: u32,
}

/// Reads the number of frames and runs them.
pub fn main() -> Outcome<()> {
    run(std::env::args().nth(1).map_or(Ok(1000), |frames| frames.parse())?)
}

/// Plays the game twice, undisturbed and disturbed, and compares the ends.
pub fn run(frames: u32) -> Outcome<()> {
    let mut undisturbed = Game::new()?;
    undisturbed.play(frames)?;
    let mut game = Game::new()?;
    game.play(frames / 2)?;
    let saved = game.save()?;
    game.play(frames * 5 / 8)?;
    game.load(&saved)?;
    game.play(frames * 3 / 4)?;
    let saved = game.save()?;
    game.play(frames * 7 / 8)?;
    if let Some((device, _)) = &game.device {
        device.destroy();
        let error = game.step().expect_err("the device is lost");
        println!("frame {}: {error}", game.frame);
        let device = request()?.ok_or("there was an adapter before")?;
        game.stepper.recover(&device.0, &device.1)?;
        game.device = Some(device);
        game.load(&saved)?;
    }
    game.play(frames)?;
    println!("frame {}: {} shawls, {} came and went", game.frame, game.actors.len(), frames / PERIOD);
    if game.save()?.cloths == undisturbed.save()?.cloths { Ok(()) } else { Err("the games differ at the end".into()) }
}

fn request() -> Outcome<Option<Device>> {
    let adapter = pollster::block_on(wgpu::Instance::default().request_adapter(&Default::default())).ok();
    let device = |adapter: wgpu::Adapter| {
        let required_limits = device_limits(&adapter);
        pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor { required_limits, ..Default::default() }))
    };
    Ok(adapter.map(device).transpose()?)
}

impl Game {
    fn new() -> Outcome<Self> {
        let device = request()?;
        // Motion shall not depend on who else is there, so the number of substeps is fixed.
        let options = Options { substeps: Some(4), ..Options::default() };
        let scene = Scene { colliders: vec![body(0, 0)], ..Scene::new("crowd") };
        let stepper = Stepper::new(scene, options, device.as_ref().map(|(d, q)| (d, q)))?;
        let (origin, right, down) = ([-0.35, 0.0, -0.35], [0.7, 0.0, 0.0], [0.0, 0.0, 0.7]);
        let shawl = Flat { origin, right, down, ..Flat::square("shawl", 11) }.cloth()?;
        Ok(Game { device, stepper, shawl, actors: VecDeque::new(), frame: 0 })
    }

    fn play(&mut self, until: u32) -> Outcome<()> {
        (self.frame..until).try_for_each(|_| self.step())
    }

    fn step(&mut self) -> Outcome<()> {
        if self.frame.is_multiple_of(PERIOD) {
            let gone = if self.actors.len() == ACTORS { self.actors.pop_front() } else { None };
            gone.map(|actor| self.stepper.remove_cloth(actor.shawl)).transpose()?;
            self.enter(self.frame)?;
        }
        let bodies = self.actors.iter().map(|actor| body(actor.entered, self.frame));
        self.stepper.set_colliders(bodies.collect())?;
        match &self.device {
            None => _ = self.stepper.advance(DT)?,
            Some((device, queue)) => {
                let mut encoder = device.create_command_encoder(&Default::default());
                self.stepper.record(&mut encoder, DT)?;
                queue.submit([encoder.finish()]);
            }
        }
        self.frame += 1;
        Ok(())
    }

    /// Puts a shawl on the shoulders of an actor that entered at a frame.
    fn enter(&mut self, entered: u32) -> Outcome<()> {
        let mut shawl = self.shawl.clone();
        let [x, y, z] = body(entered, entered).center;
        shawl.place(shawl.positions().iter().map(|p| [p[0] + x, p[1] + y + 0.62, p[2] + z]).collect())?;
        let shawl = self.stepper.add_cloth(shawl)?;
        self.actors.push_back(Actor { entered, shawl });
        Ok(())
    }

    fn save(&mut self) -> Outcome<Save> {
        let entered = self.actors.iter().map(|actor| actor.entered).collect();
        Ok(Save { frame: self.frame, entered, cloths: self.stepper.snapshot()?.to_bytes() })
    }

    /// Brings the same cloths back in the same order, then their states.
    fn load(&mut self, save: &Save) -> Outcome<()> {
        for actor in std::mem::take(&mut self.actors) {
            self.stepper.remove_cloth(actor.shawl)?;
        }
        save.entered.iter().try_for_each(|entered| self.enter(*entered))?;
        self.stepper.restore(&Snapshot::from_bytes(&save.cloths)?)?;
        self.frame = save.frame;
        Ok(())
    }
}

/// The capsule of an actor at a frame: it walks along z, each actor on a way of its own.
fn body(entered: u32, frame: u32) -> Collider {
    let (lane, seconds) = ((entered / PERIOD % 5) as f32, (frame - entered) as f32 * DT as f32);
    let capsule = Collider::new(Shape::Capsule { half_height: 0.4, radius: 0.2 }, [lane, 0.0, 0.5 * seconds]);
    Collider { friction: 0.6, velocity: [0.0, 0.0, 0.5], ..capsule }
}
