//! The host of a stepper: it owns the device, submits and waits.

use std::sync::Arc;
use std::time::Instant;

use gimage_runtime::scene::Script;
use gimage_runtime::wgpu;
use gimage_runtime::{
    Backend, ClearedStart, Health, Options, PassTime, Progress, Scene, Stepper, read_back, read_back_u32,
};
use serde_json::{Value, json};

use crate::commands::character::Animated;
use crate::commands::device::Device;
use crate::commands::faults::Faults;
use crate::commands::scene::Loaded;
use crate::exit::Failure;
use crate::output::{Output, Tone};

/// A frame of the time before an animation \[s\].
const LEAD_FRAME_S: f64 = 1.0 / 60.0;

/// A particle deeper \[m\] inside than this after clearing is warned of.
const LEFT_M: f64 = 0.005;

/// A stepper and, on the GPU, what it runs on.
pub struct Engine {
    pub stepper: Stepper,
    /// Name of the device that computes, in words.
    pub adapter: String,
    gpu: Option<(wgpu::Device, wgpu::Queue)>,
    script: Script,
    animated: Option<Arc<Animated>>,
    /// How its cloths were cleared of what they began in.
    pub cleared: Arc<[ClearedStart]>,
    /// Of the host \[s\] since the start.
    time: f64,
}

impl Engine {
    /// Looks for an adapter unless the CPU is asked for. Auto takes no software adapter, because the CPU backend is quicker,
    /// and none that fails its self-check.
    pub fn new(scene: Scene, script: Script, mut options: Options) -> Result<Self, Failure> {
        let mut found = None;
        if options.backend != Backend::Cpu {
            match Device::fastest() {
                Ok(device) => found = Some(device).filter(|d| options.backend == Backend::Gpu || !d.is_software()),
                Err(words) if options.backend == Backend::Gpu => {
                    let hint =
                        "install a Vulkan driver (Debian: libvulkan1 and that of the card, or mesa-vulkan-drivers)";
                    return Err(Failure::refused(format!("{words}; {hint}, or use --backend cpu")));
                }
                Err(_) => {}
            }
        }
        if found.is_none() {
            options.backend = Backend::Cpu;
        }
        let stepper = Stepper::new(scene, options, found.as_ref().map(|d| (&d.device, &d.queue)))?;
        let found = found.filter(|_| stepper.backend() == Backend::Gpu);
        let adapter = found.as_ref().map_or_else(|| "this machine's cores".to_owned(), |d| d.info.name.clone());
        let gpu = found.map(|d| (d.device, d.queue));
        Ok(Engine { stepper, adapter, gpu, script, animated: None, cleared: Arc::default(), time: 0.0 })
    }

    /// The engine of a scene, with what moves its joints.
    pub fn of(loaded: &Loaded) -> Result<Self, Failure> {
        let file = &loaded.file;
        let engine = Engine::new(file.scene.clone(), file.script.clone(), file.options.clone())?;
        let mut engine = Engine { animated: loaded.animated.clone(), cleared: loaded.cleared.clone(), ..engine };
        engine.lead()?;
        Ok(engine)
    }

    /// Steps through the time before an animation; a script begins after it.
    fn lead(&mut self) -> Result<(), Failure> {
        let Some(animated) = self.animated.clone() else { return Ok(()) };
        let frames = (animated.lead() / LEAD_FRAME_S).round() as u32;
        for left in (0..frames).rev() {
            animated.frame(&mut self.stepper, -f64::from(left) * LEAD_FRAME_S)?;
            self.step(LEAD_FRAME_S)?;
        }
        Ok(())
    }

    /// The character that moves its joints.
    pub fn animated(&self) -> Option<&Animated> {
        self.animated.as_deref()
    }

    /// Says which settings were beyond the solver's limits, and were changed, and whether the GPU failed its self-check.
    pub fn warn(&self, out: &Output) {
        let each = self.stepper.warnings();
        each.iter().for_each(|warning| out.remark(Tone::Warning, "warning", &warning.to_string()));
        self.animated.iter().for_each(|animated| animated.remark(out));
        for cleared in self.cleared.iter().filter(|cleared| cleared.inside > 0 || cleared.left > 0) {
            let late = cleared.left_depth > LEFT_M;
            let (tone, label) = if late { (Tone::Warning, "warning") } else { (Tone::Note, "note") };
            let hint =
                if late { ": pin fewer particles inside of the body there, or leave those parts out" } else { "" };
            out.remark(tone, label, &format!("{cleared}{hint}"));
        }
    }

    /// How its cloths were cleared, for `--json`.
    pub fn start_json(&self) -> Value {
        let entry = |c: &ClearedStart| {
            json!({"cloth": c.cloth, "inside": c.inside, "depth_mean_m": c.depth[0], "depth_max_m": c.depth[1],
                   "moved": c.moved, "moved_max_m": c.farthest, "left": c.left, "left_max_m": c.left_depth,
                   "pins_inside": c.pins, "pins_max_m": c.pins_depth,
                   "stretch_max": c.stretch.map(|s| [s[0].max, s[1].max])})
        };
        self.cleared.iter().map(entry).collect()
    }

    /// The same as [`Engine::frame`], with a time for each shader; these are empty on a device without timestamps and on the CPU. The frame
    /// takes longer than others.
    pub fn timed_frame(&mut self, dt: f64) -> Result<Vec<PassTime>, Failure> {
        let times = self.stepper.time_passes(true);
        self.frame(dt)?;
        if !times {
            return Ok(Vec::new());
        }
        self.stepper.time_passes(false);
        Ok(self.stepper.pass_times().to_vec())
    }

    /// Does what the script has for the next `dt` seconds, steps through them and waits.
    pub fn frame(&mut self, dt: f64) -> Result<Progress, Failure> {
        self.script.frame(&mut self.stepper, self.time, dt)?;
        if let Some(animated) = &self.animated {
            animated.frame(&mut self.stepper, self.time + dt)?;
        }
        self.time += dt;
        let start = Instant::now();
        let progress = self.step(dt)?;
        self.stepper.took(progress.steps, start.elapsed().as_secs_f64() * 1e3);
        // The CPU backend looks for itself.
        if self.gpu.is_some() && (2.0 * self.time).floor() > (2.0 * (self.time - dt)).floor() {
            self.examine()?;
        }
        Ok(progress)
    }

    /// Steps to a time \[s\] in frames of [`Options::step`], and returns the fraction of a step that is left over; 1 without a step.
    pub fn go_to(&mut self, time: f64, faults: &mut Faults) -> Result<f32, Failure> {
        let step = self.stepper.options().step;
        let mut fraction = 1.0;
        while time - self.time > step * 1e-6 {
            fraction = self.frame(step.min(time - self.time))?.fraction;
            faults.after_frame(self);
        }
        Ok(fraction)
    }

    fn step(&mut self, dt: f64) -> Result<Progress, Failure> {
        let Some((device, queue)) = &self.gpu else {
            let progress = self.stepper.advance(dt)?;
            // Whoever draws reads normals, and the time is that of a drawn frame.
            (0..self.stepper.scene().cloths.len()).for_each(|cloth| _ = self.stepper.normals(cloth));
            return Ok(progress);
        };
        let mut encoder = device.create_command_encoder(&Default::default());
        let progress = self.stepper.record(&mut encoder, dt)?;
        queue.submit([encoder.finish()]);
        let wait = device.poll(wgpu::PollType::wait_indefinitely());
        wait.map_err(|e| Failure::refused(format!("the GPU stopped: {e}")))?;
        self.stepper.settle()?;
        Ok(progress)
    }

    /// Time \[s\] of the last frame.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Device and queue on the GPU backend.
    pub fn gpu(&self) -> Option<&(wgpu::Device, wgpu::Queue)> {
        self.gpu.as_ref()
    }

    /// Frames of a cloth that the solver took back on the GPU so far, and the last particle at fault. `None` on the CPU,
    /// where [`Stepper::take_faults`] has them, and for the classic solver, which takes none back.
    pub fn taken_back(&self, cloth: usize) -> Result<Option<(u64, usize)>, Failure> {
        let faults = self.stepper.buffers(cloth).and_then(|b| b.faults.as_ref());
        let (Some((device, queue)), Some(faults)) = (&self.gpu, faults) else { return Ok(None) };
        let words = read_back_u32(device, queue, faults)?;
        Ok(Some((u64::from(words[1]), (words[2] as usize).saturating_sub(1))))
    }

    /// Figures of every cloth as it is now.
    pub fn examine(&mut self) -> Result<Vec<Health>, Failure> {
        let cloths = self.stepper.scene().cloths.len();
        let mut each = |cloth| {
            let (now, before) = (self.positions(cloth)?, self.previous(cloth)?);
            Ok(self.stepper.examine(cloth, &now, &before)?)
        };
        (0..cloths).map(&mut each).collect()
    }

    /// Positions of a cloth one step before.
    pub fn previous(&self, cloth: usize) -> Result<Vec<[f32; 4]>, Failure> {
        match (&self.gpu, self.stepper.buffers(cloth)) {
            (Some((device, queue)), Some(buffers)) => Ok(read_back(device, queue, &buffers.before)?),
            _ => Ok(self.stepper.previous(cloth).unwrap_or_default().to_vec()),
        }
    }

    /// Positions of a cloth as they are now.
    pub fn positions(&self, cloth: usize) -> Result<Vec<[f32; 4]>, Failure> {
        match (&self.gpu, self.stepper.buffers(cloth)) {
            (Some((device, queue)), Some(buffers)) => Ok(read_back(device, queue, &buffers.now)?),
            _ => Ok(self.stepper.positions(cloth).unwrap_or_default().to_vec()),
        }
    }

    /// Unit normals of a cloth at its positions; 0 where there is none.
    pub fn normals(&self, cloth: usize) -> Result<Vec<[f32; 4]>, Failure> {
        match (&self.gpu, self.stepper.buffers(cloth)) {
            (Some((device, queue)), Some(buffers)) => Ok(read_back(device, queue, &buffers.normals)?),
            _ => Ok(self.stepper.normals(cloth).unwrap_or_default().to_vec()),
        }
    }

    /// Triangles of a cloth that cuts have taken away so far, as [`Stepper::holes`]; empty for cloth that is whole.
    pub fn holes(&self, cloth: usize) -> Result<Vec<u32>, Failure> {
        match (&self.gpu, self.stepper.buffers(cloth).and_then(|buffers| buffers.holes.as_ref())) {
            (Some((device, queue)), Some(holes)) => Ok(read_back_u32(device, queue, holes)?),
            _ => Ok(self.stepper.holes(cloth).unwrap_or_default().to_vec()),
        }
    }
}
