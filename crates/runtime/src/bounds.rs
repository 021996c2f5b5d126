//! Boxes around cloths, for culling.

use crate::cpu::bounds::Extent;

/// An axis-aligned box around all particles of a cloth, at their positions and those of one step before: a vertex that is drawn between
/// the two ([`crate::Progress::fraction`]) is inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The corner of the smallest coordinates \[m\].
    pub low: [f32; 3],
    /// The corner of the largest coordinates \[m\].
    pub high: [f32; 3],
    /// The largest speed of a particle in the last step \[m/s\].
    pub speed: f32,
    /// How long ago it was measured \[s\] of the scene's time; 0 on the CPU backend.
    pub age: f64,
}

impl Bounds {
    /// The extent of the particles after a step of `dt` \[s\].
    pub(crate) fn new(extent: &Extent<f32>, dt: f64) -> Self {
        let Extent { low, high, far } = *extent;
        Bounds { low, high, speed: (f64::from(far).sqrt() / dt) as f32, age: 0.0 }
    }

    /// The box as it may be by now: larger on all sides by the way of the fastest particle, [`Bounds::speed`] times
    /// [`Bounds::age`], and `margin` \[m\]. It holds the cloth if no particle has become faster since by more than the margin covers:
    /// gravity adds half a centimetre in two frames of 1/60 s.
    pub fn grown(&self, margin: f32) -> Bounds {
        let by = (f64::from(self.speed) * self.age) as f32 + margin;
        Bounds { low: self.low.map(|x| x - by), high: self.high.map(|x| x + by), ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_grows_by_the_way_of_the_fastest() {
        let extent = Extent { low: [0.0, -1.0, 2.0], high: [1.0, 1.0, 3.0], far: 0.0004 };
        let now = Bounds::new(&extent, 0.01);
        assert!((now.speed - 2.0).abs() < 1e-6 && now.age == 0.0);
        assert_eq!(now.grown(0.0), now);
        let old = Bounds { age: 0.25, ..now };
        let grown = old.grown(0.5);
        assert_eq!((grown.low, grown.high), ([-1.0, -2.0, 1.0], [2.0, 2.0, 4.0]));
    }
}
