//! Scenes whose cloth crosses at the start.

use gimage_runtime::{Cloth, Collider, Flat, Scene, Shape};

use super::tube::{Tube, tube};
use super::{Failure, calm, table};

/// Two squares above a table; a strip of the upper one, three tenths of it, hangs through the lower one: about three crossings per particle
/// of a side.
pub fn overlap(scene: &mut Scene, n: u32) -> Result<(), Failure> {
    for (name, low, high, beside) in [("lower", 0.1, 0.1, 0.0), ("upper", 0.07, 0.17, 0.007)] {
        let flat = Flat {
            // Not in line, so that edges do not meet edges.
            origin: [-0.5 + beside, low, 0.5 + beside],
            right: [1.0, high - low, 0.02],
            // Its front is above.
            down: [-0.02, 0.0, -1.0],
            ..Flat::square(name, n)
        };
        scene.cloths.push(calm(flat.cloth()?));
    }
    scene.colliders.push(table());
    scene.frames = 120;
    Ok(())
}

/// A square with waves that pass through another square in closed curves.
pub fn waves(scene: &mut Scene, n: u32) -> Result<(), Failure> {
    let flat = |name: &str| calm_flat(Flat { origin: [-0.5, 0.1, -0.5], ..Flat::square(name, n) });
    scene.cloths.push(flat("flat")?);
    let mut bumps = flat("bumps")?;
    let wave = |p: &[f32; 3]| [p[0] + 1e-3, p[1] + 0.02 - 0.04 * (9.0 * p[0]).cos() * (9.0 * p[2]).cos(), p[2] + 2e-3];
    bumps.place(bumps.positions().iter().map(wave).collect())?;
    scene.cloths.push(bumps);
    scene.colliders.push(table());
    scene.frames = 120;
    Ok(())
}

fn calm_flat(flat: Flat) -> Result<Cloth, Failure> {
    Ok(calm(flat.cloth()?))
}

/// A wide tube over a narrow one around a body; the wide one is oval and crosses the narrow one at the front and at the back. Its layer is the
/// higher one if `layers`.
pub fn coat(scene: &mut Scene, n: u32) -> Result<(), Failure> {
    for (name, round, radii) in [("shirt", 0.13, [0.13, 0.13]), ("coat", 0.17, [0.2, 0.11])] {
        let mut cloth = calm(tube(&Tube { name, around: n, rows: n / 2, radii, length: 0.5 })?);
        // Round and apart where it is pinned.
        let shape = |p: &[f32; 3]| {
            let far = (p[1] / -0.1).min(1.0);
            let wide = |c: usize| p[c] / radii[c / 2] * (round + far * (radii[c / 2] - round));
            [wide(0), p[1], wide(2)]
        };
        cloth.place(cloth.positions().iter().map(shape).collect())?;
        (0..n).try_for_each(|k| cloth.set_pinned(k as usize, true))?;
        scene.cloths.push(cloth);
    }
    let body = Shape::Capsule { half_height: 0.4, radius: 0.08 };
    scene.colliders.push(Collider::new(body, [0.0, -0.25, 0.0]));
    scene.frames = 120;
    Ok(())
}
