//! Which frames of a run are kept.

use crate::args::ExportArgs;
use crate::commands::engine::Engine;
use crate::commands::faults::Faults;
use crate::exit::Failure;

/// The kept frames of a run.
#[derive(Debug)]
pub struct Schedule {
    /// Of a frame of the run \[s\].
    step: f64,
    /// First and last frame of the run that may be kept.
    frames: [u32; 2],
    /// Frames of the run per kept frame; `None` where the rate does not divide theirs.
    every: Option<u32>,
    rate: f64,
}

impl Schedule {
    /// The frames that the arguments keep of a scene with `frames` frames of `step` \[s\]. Refuses a first frame after the last one.
    pub fn new(args: &ExportArgs, frames: u32, step: f64) -> Result<Self, Failure> {
        let last = args.frames.unwrap_or(frames);
        if args.from > last || last == 0 {
            let hint = "give more --frames, or a smaller --from";
            return Err(Failure::refused(format!("--from {}: the motion ends at frame {last}; {hint}", args.from)));
        }
        let whole = |fps: f64| {
            let every = (1.0 / (fps * step)).round();
            ((every * fps * step - 1.0).abs() < 1e-9 && every >= 1.0).then_some(every as u32)
        };
        let every = args.fps.map_or(Some(args.every), whole);
        let exact = every.map_or(args.fps.unwrap_or(1.0), |every| 1.0 / (f64::from(every) * step));
        // 1 / (1 / 60) is 60 only to rounding.
        let rate = if (exact - exact.round()).abs() < 1e-9 { exact.round() } else { exact };
        Ok(Schedule { step, frames: [args.from, last], every, rate })
    }

    /// Number of kept frames, at least 1.
    pub fn kept(&self) -> usize {
        let frames = self.frames[1] - self.frames[0];
        match self.every {
            Some(every) => (frames / every) as usize + 1,
            None => (f64::from(frames) * self.step * self.rate + 1e-6) as usize + 1,
        }
    }

    /// Kept frames per second.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// From the first kept frame to the last one \[s\].
    pub fn seconds(&self) -> f64 {
        (self.kept() - 1) as f64 / self.rate
    }

    /// Steps through the run, and calls `keep` for each kept frame: the engine, the time \[s\] since the first kept frame, and the fraction of
    /// the last step to draw.
    pub fn run(
        &self,
        engine: &mut Engine,
        faults: &mut Faults,
        mut keep: impl FnMut(&mut Engine, f64, f32) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let [first, last] = self.frames;
        let Some(every) = self.every else {
            for k in 0..self.kept() {
                let time = k as f64 / self.rate;
                let fraction = engine.go_to(f64::from(first) * self.step + time, faults)?;
                keep(engine, time, fraction)?;
            }
            return Ok(());
        };
        for frame in 0..=last {
            if frame > 0 {
                engine.frame(self.step)?;
                faults.after_frame(engine);
            }
            if frame >= first && (frame - first).is_multiple_of(every) {
                keep(engine, f64::from((frame - first) / every) / self.rate, 1.0)?;
            }
        }
        Ok(())
    }
}
