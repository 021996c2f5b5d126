//! Overflow and NaN: positions must be finite again.

use gimage_runtime::{Collider, Error, Result, Shape, Stepper, Wind, WindForce};

use crate::case::{Case, N, flag, scene};

/// One particle, away from the pins.
const ONE: usize = 8 * N + 8;

/// An action of a case on its stepper before a frame.
type Act = Box<dyn Fn(&mut Stepper, u32) -> Result<()>>;

pub fn cases() -> Result<Vec<Case>> {
    let first = |frame: u32| frame == 30;
    let mut out = Vec::new();
    let mut case = |words: &str, act: Act| -> Result<()> {
        out.push(Case::new(words, scene(flag()?)).storm(1.0, act));
        Ok(())
    };
    case(
        "a particle is put at NaN",
        Box::new(move |s, frame| match s.set_position(0, ONE, [f32::NAN, 0.0, 0.0]) {
            _ if !first(frame) => Ok(()),
            // Refused, as it should be.
            Err(Error::NotFinite { .. }) => Ok(()),
            Ok(()) => s.set_position(0, ONE, [f32::NAN; 3]),
            Err(other) => Err(other),
        }),
    )?;
    case("a particle is put at 1e38 m", once(|s| s.set_position(0, ONE, [1e38, 0.0, 0.0])))?;
    case("a particle is put at 1e19 m", once(|s| s.set_position(0, ONE, [1e19, 0.0, 0.0])))?;
    case("a matrix overflows for one particle", once(|s| s.transform(0, &[ONE], overflow())))?;
    case(
        "a matrix overflows for all",
        once(|s| s.transform(0, &(0..N * N).filter(|k| *k != 0 && *k != N - 1).collect::<Vec<_>>(), overflow())),
    )?;
    case(
        "gravity of 1e38 m/s^2 for a frame",
        Box::new(|s, frame| s.set_gravity([0.0, if frame == 30 { -1e38 } else { -9.81 }, 0.0])),
    )?;
    case(
        "wind of 1e38 m/s for a frame",
        Box::new(|s, frame| {
            let force = WindForce::Triangles { density: 1.2, drag: 1.0, lift: 0.5 };
            let wind = Wind { velocity: [1e38, 0.0, 0.0], gust: 0.0, gust_size: 1.0, force };
            s.set_wind((frame == 30).then_some(wind))
        }),
    )?;
    case(
        "a sphere of 1e38 m for a frame",
        Box::new(|s, frame| {
            let huge = Collider::new(Shape::Sphere { radius: 1e38 }, [0.5, 0.0, 0.5]);
            s.set_colliders(if frame == 30 { vec![huge] } else { Vec::new() })
        }),
    )?;
    case(
        "a sphere at 1e38 m/s for a frame",
        Box::new(|s, frame| {
            let ball = Collider::new(Shape::Sphere { radius: 0.3 }, [0.5, -0.5, 0.0]);
            let fast = Collider { velocity: [1e38, 0.0, 0.0], spin: [0.0, 1e38, 0.0], friction: 1.0, ..ball };
            s.set_colliders(if frame == 30 { vec![fast] } else { Vec::new() })
        }),
    )?;
    Ok(out)
}

/// Done in one frame of the storm.
fn once(act: impl Fn(&mut Stepper) -> Result<()> + 'static) -> Act {
    Box::new(move |s, frame| if frame == 30 { act(s) } else { Ok(()) })
}

/// Finite elements, but what they are applied to is not.
fn overflow() -> [[f32; 4]; 4] {
    let big = f32::MAX;
    [[big, 0.0, 0.0, 0.0], [0.0, big, 0.0, 0.0], [0.0, 0.0, big, 0.0], [big, -big, big, 1.0]]
}
