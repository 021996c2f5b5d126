//! A stepper on either backend, with everything at hand that tests look at.

use gimage_runtime::*;

pub use super::FRAME;

pub struct Rig {
    pub stepper: Stepper,
    device: Option<(wgpu::Device, wgpu::Queue)>,
}

impl Rig {
    pub fn cpu(scene: Scene, options: &Options) -> Self {
        let options = Options { backend: Backend::Cpu, ..options.clone() };
        Rig { stepper: Stepper::new(scene, options, None).unwrap(), device: None }
    }

    pub fn gpu(scene: Scene, options: &Options, device: &(wgpu::Device, wgpu::Queue)) -> Self {
        Rig::on(Backend::Gpu, scene, options, device)
    }

    /// A backend with buffers of a device.
    pub fn on(backend: Backend, scene: Scene, options: &Options, device: &(wgpu::Device, wgpu::Queue)) -> Self {
        let options = Options { backend, ..options.clone() };
        let stepper = Stepper::new(scene, options, Some((&device.0, &device.1))).unwrap();
        Rig { stepper, device: Some(device.clone()) }
    }

    /// The CPU and, where there is an adapter, the GPU.
    pub fn both(scene: &Scene, options: &Options) -> Vec<Rig> {
        let gpu = super::device().map(|d| Rig::gpu(scene.clone(), options, &d));
        [Some(Rig::cpu(scene.clone(), options)), gpu].into_iter().flatten().collect()
    }

    /// Another stepper with the same options, on the same device, which compiles nothing that this one has.
    pub fn another(&self, scene: &Scene) -> Self {
        let stepper = self.stepper.another(scene.clone(), self.stepper.options().clone()).unwrap();
        Rig { stepper, device: self.device.clone() }
    }

    /// Goes on with another device.
    pub fn recover(&mut self, device: &(wgpu::Device, wgpu::Queue)) {
        self.stepper.recover(&device.0, &device.1).unwrap();
        self.device = Some(device.clone());
    }

    /// The device that it runs on, if it does.
    pub fn device(&self) -> Option<&(wgpu::Device, wgpu::Queue)> {
        self.device.as_ref()
    }

    pub fn name(&self) -> &'static str {
        if self.device.is_some() { "gpu" } else { "cpu" }
    }

    pub fn frame(&mut self, dt: f64) {
        match &self.device {
            None => assert!(self.stepper.advance(dt).is_ok()),
            Some((device, queue)) => {
                let mut encoder = device.create_command_encoder(&Default::default());
                self.stepper.record(&mut encoder, dt).unwrap();
                queue.submit([encoder.finish()]);
                self.stepper.settle().unwrap();
            }
        }
    }

    pub fn frames(&mut self, count: u32) {
        (0..count).for_each(|_| self.frame(FRAME));
    }

    /// As [`Rig::frame`], with everything measured before it returns.
    pub fn frame_to_its_end(&mut self, dt: f64) {
        let Some((device, queue)) = &self.device else { return self.frame(dt) };
        let mut encoder = device.create_command_encoder(&Default::default());
        self.stepper.record(&mut encoder, dt).unwrap();
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        self.stepper.settle().unwrap();
    }

    fn list(&self, cloth: usize, which: fn(&ClothBuffers) -> &Span) -> Vec<[f32; 4]> {
        let (device, queue) = self.device.as_ref().unwrap();
        read_back(device, queue, which(self.stepper.buffers(cloth).unwrap())).unwrap()
    }

    pub fn positions(&self, cloth: usize) -> Vec<[f32; 4]> {
        self.stepper.positions(cloth).map_or_else(|| self.list(cloth, |b| &b.now), <[_]>::to_vec)
    }

    pub fn previous(&self, cloth: usize) -> Vec<[f32; 4]> {
        self.stepper.previous(cloth).map_or_else(|| self.list(cloth, |b| &b.before), <[_]>::to_vec)
    }

    pub fn normals(&self, cloth: usize) -> Vec<[f32; 4]> {
        self.stepper.normals(cloth).map_or_else(|| self.list(cloth, |b| &b.normals), <[_]>::to_vec)
    }

    pub fn holes(&self, cloth: usize) -> Option<Vec<u32>> {
        let Some((device, queue)) = &self.device else { return self.stepper.holes(cloth).map(<[u32]>::to_vec) };
        let holes = self.stepper.buffers(cloth).unwrap().holes.as_ref()?;
        Some(read_back_u32(device, queue, holes).unwrap())
    }

    pub fn pick(&mut self, origin: [f32; 3], direction: [f32; 3]) -> Option<Hit> {
        let Some((device, queue)) = &self.device else { return self.stepper.pick(origin, direction).unwrap() };
        let mut encoder = device.create_command_encoder(&Default::default());
        let ticket = self.stepper.record_pick(&mut encoder, origin, direction).unwrap();
        queue.submit([encoder.finish()]);
        ticket.wait(device).unwrap()
    }
}

pub fn largest(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    assert_eq!(a.len(), b.len());
    let difference = |(a, b): (&[f32; 4], &[f32; 4])| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
    a.iter().zip(b).map(difference).fold(0.0, f32::max)
}

/// The mean of some positions.
pub fn center(positions: &[[f32; 4]], which: impl Fn(usize) -> bool) -> [f64; 3] {
    let chosen: Vec<_> = (0..positions.len()).filter(|k| which(*k)).map(|k| positions[k]).collect();
    [0, 1, 2].map(|c| chosen.iter().map(|p| f64::from(p[c])).sum::<f64>() / chosen.len() as f64)
}
