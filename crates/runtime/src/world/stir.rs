//! Hanging cloth is stirred by pins that the host moves or frees, and by its frame of reference; it then has more substeps.

use super::World;
use crate::cloth::Cloth;
use crate::moving_frame::{FrameMotion, Inertia};
use crate::number::real::{cast, dot, sub};

/// Speed \[m/s\] of a pin that stirs.
const PIN_M_S: f64 = 0.5;
/// Acceleration \[m/s^2\] and speed of turning \[1/s\] of a frame of reference that stir.
const FRAME_M_S2: f64 = 2.0;
const FRAME_TURN_PER_S: f64 = 1.0;
/// Steps of the host after which the last place of a pin no longer tells its speed: a pin that jumps after a while is fast.
const MOST_STEPS: f64 = 2.0;

/// Where the host has put the pins of a cloth \[m\], and when \[s\]; empty until it has put any.
#[derive(Clone, Debug, Default)]
pub struct PinPlaces(Vec<([f32; 3], f64)>);

impl PinPlaces {
    /// Takes in where pins are at a time; whether any of them is fast. `step` \[s\] is that of the host.
    fn put(&mut self, of: &Cloth, rows: impl Iterator<Item = (u32, [f32; 3])>, time: f64, step: f64) -> bool {
        // Another level of the cloth has other particles.
        if self.0.len() != of.len() {
            self.0 = of.positions().iter().map(|p| (*p, time - step)).collect();
        }
        let mut fast = false;
        for (k, at) in rows.filter(|(k, _)| of.particles()[*k as usize].is_pinned()) {
            let (last, then) = &mut self.0[k as usize];
            // A host may move pins several times before a step is due.
            if time > *then {
                let way = sub(cast(at), cast::<_, f64, 3>(*last));
                fast |= dot(way, way).sqrt() > PIN_M_S * (time - *then).min(MOST_STEPS * step);
                (*last, *then) = (at, time);
            }
        }
        fast
    }
}

impl World {
    /// Takes in that the host puts particles of a cloth somewhere.
    pub fn note_pins(&mut self, cloth: usize, rows: impl Iterator<Item = (u32, [f32; 3])>) {
        let (time, step) = (self.control.clock.time, self.control.options.step);
        if self.runs[cloth].pins.put(&self.scene.cloths[cloth], rows, time, step) {
            self.control.follow.stir();
        }
    }

    /// Takes in that pins of a cloth are where a state has them.
    pub fn forget_pins(&mut self, cloth: usize, positions: &[[f32; 4]]) {
        let then = self.control.clock.time - self.control.options.step;
        let places = &mut self.runs[cloth].pins.0;
        places.clear();
        places.extend(positions.iter().map(|[x, y, z, _]| ([*x, *y, *z], then)));
    }
}

/// Whether a frame of reference stirs the cloth in it, which had another motion before.
pub fn is_stirring(before: &FrameMotion, now: &FrameMotion, inertia: &Inertia, seconds: f64) -> bool {
    let change = sub(now.velocity, before.velocity);
    let acceleration = f64::from(inertia.linear) * dot(change, change).sqrt() / seconds;
    let turn = 2.0 * now.turn[3].abs().min(1.0).acos() / seconds;
    let felt = f64::from(inertia.angular.max(inertia.centrifugal));
    acceleration > FRAME_M_S2 || felt * turn > FRAME_TURN_PER_S
}
