//! A stepper on a device that other steppers share, and what it leaves as bits.

use gimage_runtime::*;

use super::rig::FRAME;

pub type Device = (wgpu::Device, wgpu::Queue);

pub struct Run<'a> {
    pub stepper: Stepper,
    pub device: &'a Device,
}

impl<'a> Run<'a> {
    pub fn new(scene: &Scene, options: &Options, device: &'a Device) -> Self {
        let options = Options { backend: Backend::Gpu, ..options.clone() };
        let stepper = Stepper::new(scene.clone(), options, Some((&device.0, &device.1))).unwrap();
        Run { stepper, device }
    }

    pub fn frames(mut self, count: u32) -> Self {
        for _ in 0..count {
            let mut encoder = self.device.0.create_command_encoder(&Default::default());
            self.stepper.record(&mut encoder, FRAME).unwrap();
            self.device.1.submit([encoder.finish()]);
            // Asks for the speeds of this frame, waits for them, and takes them in.
            self.stepper.settle().unwrap();
            self.device.0.poll(wgpu::PollType::wait_indefinitely()).unwrap();
            self.stepper.settle().unwrap();
        }
        self
    }

    /// Positions now and before and normals of a cloth, as bits.
    pub fn bits(&self, cloth: usize) -> [Vec<[u32; 4]>; 3] {
        let buffers = self.stepper.buffers(cloth).unwrap();
        let list = |span| read_back(&self.device.0, &self.device.1, span).unwrap();
        [&buffers.now, &buffers.before, &buffers.normals].map(|s| list(s).iter().map(|p| p.map(f32::to_bits)).collect())
    }

    /// What runs whole frames in one dispatch.
    pub fn holds(&self) -> Vec<Hold> {
        let of = |p: &PlannedPass| if let Form::Whole(f) = &p.form { Some(f.hold) } else { None };
        self.stepper.plan().passes.iter().filter_map(of).collect()
    }

    /// What runs by tiles, and how often a frame.
    pub fn tiles(&self) -> Vec<(Tile, u32)> {
        let of = |p: &PlannedPass| if let Form::Tile(t) = &p.form { Some((t.clone(), p.dispatches)) } else { None };
        self.stepper.plan().passes.iter().filter_map(of).collect()
    }
}
