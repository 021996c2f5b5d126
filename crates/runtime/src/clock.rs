//! Converts frames of any length to steps of a fixed length.

use crate::choose::Settings;

/// The progress of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Steps made.
    pub steps: u32,
    /// Weight with which a vertex shader mixes the previous positions (0) and the current ones (1). In 0..=1.
    pub fraction: f32,
}

/// A fixed step and the time left over.
#[derive(Clone, Debug)]
pub struct Clock {
    /// Length of a step \[s\].
    pub dt: f64,
    /// Length of the step before \[s\].
    pub dt_old: f64,
    /// Time of the last step \[s\] since the start.
    pub time: f64,
    left: f64,
    most: u32,
}

/// Frames whose length is a multiple of the step shall not lose one to rounding.
const ROUNDING: f64 = 1e-4;

impl Clock {
    pub fn new(options: &Settings) -> Self {
        let dt = options.step / f64::from(options.substeps);
        Clock { dt, dt_old: dt, time: 0.0, left: 0.0, most: options.max_catch_up.saturating_mul(options.substeps) }
    }

    /// Other steps from here on. Velocities go on: the next step is scaled by the ratio.
    pub fn change(&mut self, options: &Settings) {
        let next = Clock::new(options);
        (self.dt, self.most) = (next.dt, next.most);
    }

    /// Time, length of the last step and time left over \[s\].
    pub fn numbers(&self) -> [f64; 3] {
        [self.time, self.dt_old, self.left]
    }

    /// Takes them over from another clock.
    pub fn resume(&mut self, [time, dt_old, left]: [f64; 3]) {
        (self.time, self.dt_old, self.left) = (time, dt_old, left);
    }

    /// Takes in `dt` \[s\] of the host's time and returns what is due. Negative time and NaN count as 0.
    pub fn frame(&mut self, dt: f64) -> Progress {
        self.left += if dt.is_finite() { dt.max(0.0) } else { 0.0 };
        let due = (self.left / self.dt + ROUNDING).floor();
        let steps = due.min(f64::from(self.most));
        // Beyond the most, time is dropped: else a slow frame makes the next one slower.
        self.left = if due > steps { 0.0 } else { self.left - due * self.dt };
        Progress { steps: steps as u32, fraction: (self.left / self.dt).clamp(0.0, 1.0) as f32 }
    }

    /// Time \[s\] of the host after the last step of the frame; 0 where that is rounding, or time was dropped.
    pub fn rest(&self) -> f64 {
        if self.left > ROUNDING * self.dt { self.left } else { 0.0 }
    }

    /// To be called after every step.
    pub fn tick(&mut self) {
        self.time += self.dt;
        self.dt_old = self.dt;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Options;
    use crate::scene::Scene;

    fn clock(substeps: u32) -> Clock {
        let options = Options { substeps: Some(substeps), ..Options::default() };
        Clock::new(&Settings::new(options, &Scene::new("empty")).0)
    }

    #[test]
    fn frames_of_any_length_add_up() {
        let mut clock = clock(8);
        assert!((0..6000).all(|_| clock.frame(1.0 / 60.0).steps == 8));
        let steps: u32 = (0..1000).map(|_| clock.frame(0.001_234).steps).sum();
        assert!((592..=593).contains(&steps), "{steps}");
        assert_eq!(clock.frame(f64::NAN).steps + clock.frame(-1.0).steps, 0);
        assert_eq!(clock.frame(100.0), Progress { steps: 32, fraction: 0.0 });
    }

    #[test]
    fn the_fraction_is_of_a_step() {
        let mut clock = clock(1);
        let p = clock.frame(1.5 / 60.0);
        assert_eq!((p.steps, (p.fraction - 0.5).abs() < 1e-6), (1, true));
        assert!((clock.rest() - 0.5 / 60.0).abs() < 1e-12);
        assert_eq!(clock.frame(0.5 / 60.0).steps, 1);
        assert_eq!(clock.rest(), 0.0);
    }
}
