//! Motion that a scene gives to pins, colliders and gravity from frame to frame.

use gimage_runtime::scene::Pose;
use gimage_runtime::{Scene, Stepper};

use super::Failure;

/// A part of a scene that moves. Times are in seconds from the start.
pub enum Action {
    /// Pins that turn around an axis.
    Turn(Turn),
    /// Pins that move along a line.
    Carry(Carry),
    /// A collider that moves along a line.
    Slide(Slide),
    /// Gravity \[m/s^2\] from a time on.
    Gravity { from_s: f64, to: [f32; 3] },
}

/// Particles of the first cloth that turn around an axis.
pub struct Turn {
    /// The particles, and where they are at the start \[m\].
    pub pins: Vec<u32>,
    pub start: Vec<[f32; 3]>,
    /// Which coordinate the axis runs along; it passes through the origin.
    pub axis: usize,
    /// \[rad/s\]
    pub rate: f64,
    /// They stop here.
    pub until_s: f64,
}

/// Particles of a cloth that move at constant velocity and then stop.
pub struct Carry {
    pub cloth: usize,
    pub pins: Vec<u32>,
    pub start: Vec<[f32; 3]>,
    pub way: Line,
}

/// A collider that moves at constant velocity and then stops.
pub struct Slide {
    pub collider: usize,
    pub start: [f32; 3],
    pub way: Line,
}

/// Motion at constant velocity \[m/s\] for some time.
#[derive(Clone, Copy)]
pub struct Line {
    pub velocity: [f32; 3],
    pub from_s: f64,
    pub until_s: f64,
}

impl Line {
    /// The way \[m\] after `seconds`.
    fn at(&self, seconds: f64) -> [f32; 3] {
        let time = (seconds.clamp(self.from_s, self.until_s) - self.from_s) as f32;
        self.velocity.map(|v| v * time)
    }
}

impl Turn {
    /// Where the pins are after `seconds`.
    fn at(&self, seconds: f64) -> Vec<[f32; 3]> {
        let (s, c) = (self.rate * seconds.min(self.until_s)).sin_cos();
        let (a, b) = ((self.axis + 1) % 3, (self.axis + 2) % 3);
        let turned = |p: &[f32; 3]| {
            let (mut to, [x, y]) = (*p, [f64::from(p[a]), f64::from(p[b])]);
            (to[a], to[b]) = ((c * x - s * y) as f32, (s * x + c * y) as f32);
            to
        };
        self.start.iter().map(turned).collect()
    }
}

impl Action {
    /// Has a stepper make it in the next frame, which ends after `seconds`.
    pub fn lead(&self, stepper: &mut Stepper, seconds: f64) -> Result<(), Failure> {
        match self {
            Action::Turn(turn) => stepper.set_pins(0, &turn.pins, &turn.at(seconds))?,
            Action::Carry(carry) => {
                let way = carry.way.at(seconds);
                let at: Vec<[f32; 3]> = carry.start.iter().map(|p| [0, 1, 2].map(|c| p[c] + way[c])).collect();
                stepper.set_pins(carry.cloth, &carry.pins, &at)?;
            }
            Action::Slide(slide) => {
                let way = slide.way.at(seconds);
                let rotation = stepper.scene().colliders[slide.collider].rotation;
                let pose = Pose { position: [0, 1, 2].map(|c| slide.start[c] + way[c]), rotation };
                stepper.move_collider(slide.collider, &pose)?;
            }
            Action::Gravity { from_s, to } => {
                if seconds > *from_s && stepper.scene().gravity != *to {
                    stepper.set_gravity(*to)?;
                }
            }
        }
        Ok(())
    }
}

/// Pins particles of a cloth of a scene, which move.
pub fn carry(scene: &mut Scene, cloth: usize, pins: Vec<u32>, way: Line) -> Result<Action, Failure> {
    let of = &mut scene.cloths[cloth];
    pins.iter().try_for_each(|k| of.set_pinned(*k as usize, true))?;
    let start = pins.iter().map(|k| of.positions()[*k as usize]).collect();
    Ok(Action::Carry(Carry { cloth, pins, start, way }))
}
