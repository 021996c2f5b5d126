//! The scenes that solvers are compared on: n x n particles, 1 m x 1 m, 0.2 kg, gravity 9.81 m/s^2 along -y.

use super::Scene;
use crate::cloth::{Cloth, Compliance, Flat};
use crate::collider::{Collider, Shape};
use crate::error::{Error, Result};

/// A built-in scene with `n` x `n` particles, n at least 2. Errors on other names and sizes.
///
/// - `s1`: horizontal, hung by the two ends of row 0, damped at 2 /s. Ends as a flat vertical square.
/// - `s1k`: the same with springs of 1000 N/m.
/// - `s2`: falls on a sphere of radius 0.3 m with friction 0.3. `s2f`: meets it at 30 m/s.
/// - `s3`: hangs by row 0 in the fundamental mode of a chain, undamped.
pub fn builtin(name: &str, n: u32) -> Result<Scene> {
    let mut scene = Scene::new(name);
    let mut cloth = match name {
        "s1" | "s1k" => hung(name, n)?,
        "s2" => Flat { origin: [-0.5, 0.5, -0.5], ..Flat::square(name, n) }.cloth()?,
        "s2f" => Flat { origin: [-0.5, 0.35, -0.5], ..Flat::square(name, n) }.cloth()?,
        "s3" => chain(n)?,
        _ => return Err(Error::NoScene(name.into())),
    };
    match name {
        "s1k" => cloth.compliance = Compliance::Constant(1e-3),
        "s2" => scene.frames = 60,
        "s2f" => (scene.frames, cloth.velocity) = (12, [0.0, -30.0, 0.0]),
        _ => {}
    }
    if name.starts_with("s2") {
        let sphere = Collider::new(Shape::Sphere { radius: 0.3 }, [0.0; 3]);
        scene.colliders.push(Collider { friction: 0.3, ..sphere });
    }
    scene.cloths.push(cloth);
    Ok(scene)
}

fn hung(name: &str, n: u32) -> Result<Cloth> {
    let mut cloth = Flat::square(name, n).cloth()?;
    cloth.set_pinned(0, true)?;
    cloth.set_pinned(n as usize - 1, true)?;
    cloth.damping = 2.0;
    Ok(cloth)
}

/// Hangs along -y by its first row; at arc length s the offset is 0.05 J0(2.4048 sqrt(1 - s)), and every row is as far
/// from the next as at rest.
fn chain(n: u32) -> Result<Cloth> {
    let mut cloth = Flat { down: [0.0, -1.0, 0.0], ..Flat::square("s3", n) }.cloth()?;
    let h = 1.0 / f64::from(n - 1);
    let offset = |s: f64| 0.05 * bessel_j0(2.404825557695773 * (1.0 - s).max(0.0).sqrt());
    let (mut y, mut z) = (0.0, 0.0);
    let mut positions = cloth.positions().to_vec();
    for j in 0..n as usize {
        if j > 0 {
            let dz = offset(j as f64 * h) - offset((j - 1) as f64 * h);
            z += dz;
            y -= (h * h - dz * dz).sqrt();
        }
        for i in 0..n as usize {
            let x = &mut positions[j * n as usize + i];
            (x[1], x[2]) = (y as f32, z as f32);
        }
    }
    cloth.place(positions)?;
    for i in 0..n as usize {
        cloth.set_pinned(i, true)?;
    }
    Ok(cloth)
}

/// The Bessel function J0 by its power series, exact to rounding for |x| < 4.
fn bessel_j0(x: f64) -> f64 {
    let q = -x * x / 4.0;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..30 {
        term *= q / f64::from(k * k);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::BUILTIN;

    #[test]
    fn all_names_make_a_scene() {
        for name in BUILTIN {
            let scene = builtin(name, 5).unwrap();
            assert_eq!((scene.name.as_str(), scene.cloths[0].len()), (name, 25));
            assert!(builtin(name, 1).is_err() && builtin(name, 0).is_err() && builtin(name, u32::MAX).is_err());
        }
        assert!(builtin("s9", 5).unwrap_err().to_string().contains("s2f"));
    }

    #[test]
    fn the_chain_keeps_its_lengths_and_reaches_its_offset() {
        assert!((bessel_j0(1.0) - 0.765_197_686_557_966_6).abs() < 1e-15 && bessel_j0(2.404825557695773).abs() < 1e-14);
        let cloth = &builtin("s3", 33).unwrap().cloths[0];
        let p = cloth.positions();
        for j in 0..32 {
            let (a, b) = (p[33 * j], p[33 * (j + 1)]);
            let far = ((a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt();
            assert!((far - 1.0 / 32.0).abs() < 1e-6, "{far}");
        }
        assert!((p[33 * 32][2] - 0.05).abs() < 1e-6);
        assert_eq!((cloth.inverse_mass(32), cloth.inverse_mass(33) > 0.0), (0.0, true));
    }
}
