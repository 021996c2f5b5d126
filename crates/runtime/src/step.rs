//! The numbers of one step, as shaders and twins read them.

use crate::number::real::{Real, cast};
use crate::wind::{Wind, WindForce};

/// One step of one cloth; the same fields as `Step` in shaders/part/step.wgsl.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step<T> {
    /// Acceleration \[m/s^2\].
    pub gravity: [T; 3],
    /// Share of the last displacement that goes on: damping times dt / dt_old.
    pub keep: T,
    /// Velocity of the air \[m/s\].
    pub wind: [T; 3],
    /// dt * dt_old \[s^2\].
    pub scale: T,
    /// How far the noise has drifted, in cells.
    pub drift: [T; 3],
    /// Rate \[1/s\] at which particles take up the wind.
    pub response: T,
    /// tan of half the largest turn of the heading.
    pub turn: T,
    /// Cells of noise in a metre.
    pub fineness: T,
    /// Square of the longest displacement \[m^2\] that goes on.
    pub longest: T,
    /// Length of the step \[s\].
    pub dt: T,
    /// 1 / dt_old \[1/s\].
    pub rate: T,
    /// Half the air's density times the drag coefficient \[kg/m^3\].
    pub drag: T,
    /// Half the air's density times the lift coefficient \[kg/m^3\].
    pub lift: T,
    /// From the end of this step to that of the frame \[s\]: so far back moving colliders are, and joints.
    pub left: T,
}

/// Inputs of one step of a cloth.
pub struct StepInput<'a> {
    /// Acceleration \[m/s^2\].
    pub gravity: [f32; 3],
    /// Moving air.
    pub wind: Option<&'a Wind>,
    /// 1/s.
    pub damping: f32,
    /// m/s.
    pub speed_limit: f32,
    /// This step \[s\].
    pub dt: f64,
    /// The step before \[s\].
    pub dt_old: f64,
    /// Since the start \[s\].
    pub time: f64,
}

/// Cells after which the noise repeats. The drift is kept below it, so f32 stays exact however long a scene runs.
pub const NOISE_PERIOD: f64 = 1024.0;

impl Step<f64> {
    /// Works the numbers out once for all particles.
    pub fn new(input: &StepInput) -> Self {
        let longest = (f64::from(input.speed_limit) * input.dt_old).powi(2);
        let mut step = Step {
            gravity: cast(input.gravity),
            keep: (-f64::from(input.damping) * input.dt).exp() * input.dt / input.dt_old,
            scale: input.dt * input.dt_old,
            // WGSL has no infinity.
            longest: longest.min(f64::from(f32::MAX)),
            dt: input.dt,
            rate: 1.0 / input.dt_old,
            ..Step::default()
        };
        if let Some(wind) = input.wind {
            step.wind = cast(wind.velocity);
            step.turn = (f64::from(wind.gust) / 2.0).tan();
            step.fineness = 1.0 / f64::from(wind.gust_size);
            step.drift = step.wind.map(|v| (v * input.time * step.fineness).rem_euclid(NOISE_PERIOD));
            match wind.force {
                WindForce::Push { response } => step.response = f64::from(response),
                WindForce::Triangles { density, drag, lift } => {
                    step.drag = 0.5 * f64::from(density) * f64::from(drag);
                    step.lift = 0.5 * f64::from(density) * f64::from(lift);
                }
            }
        }
        step
    }

    /// The same in another precision.
    pub fn cast<T: Real>(&self) -> Step<T> {
        let of = T::of;
        Step {
            gravity: cast(self.gravity),
            keep: of(self.keep),
            wind: cast(self.wind),
            scale: of(self.scale),
            drift: cast(self.drift),
            response: of(self.response),
            turn: of(self.turn),
            fineness: of(self.fineness),
            longest: of(self.longest),
            dt: of(self.dt),
            rate: of(self.rate),
            drag: of(self.drag),
            lift: of(self.lift),
            left: of(self.left),
        }
    }
}
