//! A stepper on a device that other steppers share, and what it leaves as bits.

use gimage_runtime::*;

use super::alike::{Bits, nudged, tolerates};
use super::rig::FRAME;

pub type Device = (wgpu::Device, wgpu::Queue);

pub struct Run<'a> {
    pub stepper: Stepper,
    pub device: &'a Device,
}

impl<'a> Run<'a> {
    pub fn new(scene: &Scene, options: &Options, device: &'a Device) -> Self {
        let options = Options { backend: Backend::Gpu, ..options.clone() };
        let scene = nudged(scene.clone(), options.fused);
        let stepper = Stepper::new(scene, options, Some((&device.0, &device.1))).unwrap();
        Run { stepper, device }
    }

    /// Makes frames. Where results are compared within bounds, these are two at most, of four steps at most: what rounding leaves doubles
    /// every few steps where cloth crumples or meets edges.
    pub fn frames(self, count: u32) -> Self {
        if !tolerates(self.device) {
            return self.whole_frames(count);
        }
        let share = (4.0 / f64::from(self.stepper.substeps())).min(1.0);
        self.frames_of(count.min(2), FRAME * share)
    }

    /// Makes frames, as many on every adapter.
    pub fn whole_frames(self, count: u32) -> Self {
        self.frames_of(count, FRAME)
    }

    fn frames_of(mut self, count: u32, dt: f64) -> Self {
        for _ in 0..count {
            let mut encoder = self.device.0.create_command_encoder(&Default::default());
            self.stepper.record(&mut encoder, dt).unwrap();
            self.device.1.submit([encoder.finish()]);
            // Asks for the speeds of this frame, waits for them, and takes them in.
            self.stepper.settle().unwrap();
            self.device.0.poll(wgpu::PollType::wait_indefinitely()).unwrap();
            self.stepper.settle().unwrap();
        }
        self
    }

    /// Positions now and before and normals of a cloth, as bits.
    pub fn bits(&self, cloth: usize) -> Bits {
        let buffers = self.stepper.buffers(cloth).unwrap();
        let list = |span| read_back(&self.device.0, &self.device.1, span).unwrap();
        Bits::new([&buffers.now, &buffers.before, &buffers.normals].map(list), self.device)
    }

    /// Holds of the passes that run whole frames in one dispatch.
    pub fn holds(&self) -> Vec<Hold> {
        let of = |p: &PlannedPass| if let Form::Whole(f) = &p.form { Some(f.hold) } else { None };
        self.stepper.plan().passes.iter().filter_map(of).collect()
    }

    /// Tiles that run, and how often per frame.
    pub fn tiles(&self) -> Vec<(Tile, u32)> {
        let of = |p: &PlannedPass| if let Form::Tile(t) = &p.form { Some((t.clone(), p.dispatches)) } else { None };
        self.stepper.plan().passes.iter().filter_map(of).collect()
    }
}
