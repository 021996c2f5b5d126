//! The particle code, which is the fourth channel of a position map.
//!
//! 0 means no particle; the sign is free (+) or pinned (-); magnitude 1 is an ordinary particle; magnitude n >= 2 is a
//! seam particle whose next duplicate has the bundle-wide index n - 2.

pub use crate::error::CodeError;

/// Largest number of particles (texels) in one bundle: 2^24 - 2, so that every code is a whole number that f32 holds exactly.
pub const MAX_PARTICLES: u32 = (1 << 24) - 2;

/// The state of a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Particle {
    /// No particle: the texel is outside the surface.
    None,
    /// A particle that moves. `next` is the bundle-wide index of its next duplicate, if it lies on a seam.
    Free {
        /// Next duplicate, `None` off the seams.
        next: Option<u32>,
    },
    /// A particle that is held where it is. `next` as for `Free`.
    Pinned {
        /// Next duplicate, `None` off the seams.
        next: Option<u32>,
    },
}

impl Particle {
    /// Reads a code. Either zero is [`Particle::None`]. Errors on NaN, infinities, fractions and magnitudes of 2^24 up.
    pub fn from_code(w: f32) -> Result<Self, CodeError> {
        if !w.is_finite() {
            return Err(CodeError::NotFinite(w));
        }
        if w.fract() != 0.0 {
            return Err(CodeError::Fractional(w));
        }
        let magnitude = w.abs();
        if magnitude == 0.0 {
            return Ok(Particle::None);
        }
        // The largest legal code is 2 + (MAX_PARTICLES - 1).
        if magnitude >= (MAX_PARTICLES + 2) as f32 {
            return Err(CodeError::LinkTooLarge(w));
        }
        let next = (magnitude as u32).checked_sub(2);
        Ok(if w < 0.0 { Particle::Pinned { next } } else { Particle::Free { next } })
    }

    /// The code of a particle. Errors where `next` is not below [`MAX_PARTICLES`].
    pub fn code(self) -> Result<f32, CodeError> {
        let magnitude = |next: Option<u32>| match next {
            Option::None => Ok(1.0),
            Some(index) if index < MAX_PARTICLES => Ok((index + 2) as f32),
            Some(index) => Err(CodeError::IndexTooLarge(index)),
        };
        match self {
            Particle::None => Ok(0.0),
            Particle::Free { next } => magnitude(next),
            Particle::Pinned { next } => magnitude(next).map(|m| -m),
        }
    }

    /// Index of the next duplicate on the seam ring, if there is one.
    pub fn next(self) -> Option<u32> {
        match self {
            Particle::None => Option::None,
            Particle::Free { next } | Particle::Pinned { next } => next,
        }
    }

    /// Whether there is a particle.
    pub fn exists(self) -> bool {
        self != Particle::None
    }

    /// Whether the particle is pinned.
    pub fn is_pinned(self) -> bool {
        matches!(self, Particle::Pinned { .. })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_ends_of_the_range_are_exact() {
        for index in [0, 1, MAX_PARTICLES - 2, MAX_PARTICLES - 1] {
            let particle = Particle::Pinned { next: Some(index) };
            assert_eq!(Particle::from_code(particle.code().unwrap()), Ok(particle));
        }
        let beyond = Particle::Free { next: Some(MAX_PARTICLES) };
        assert_eq!(beyond.code(), Err(CodeError::IndexTooLarge(MAX_PARTICLES)));
        assert_eq!(Particle::from_code(16_777_216.0), Err(CodeError::LinkTooLarge(16_777_216.0)));
        assert_eq!(Particle::from_code(-0.0), Ok(Particle::None));
    }

    #[test]
    fn bad_codes_are_refused_not_rounded() {
        for w in [0.5, 1.5, 2.5, -7.25, f32::MIN_POSITIVE] {
            assert_eq!(Particle::from_code(w), Err(CodeError::Fractional(w)));
        }
        for w in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!(matches!(Particle::from_code(w), Err(CodeError::NotFinite(_))));
        }
    }

    proptest! {
        #[test]
        fn particle_to_code_and_back(index in proptest::option::of(0..MAX_PARTICLES), pinned: bool) {
            let p = if pinned { Particle::Pinned { next: index } } else { Particle::Free { next: index } };
            prop_assert_eq!(Particle::from_code(p.code().unwrap()), Ok(p));
        }

        #[test]
        fn any_bits_read_back_as_themselves_or_not_at_all(bits: u32) {
            let w = f32::from_bits(bits);
            if let Ok(p) = Particle::from_code(w) {
                prop_assert_eq!(p.code().unwrap(), w);
            }
        }
    }
}
