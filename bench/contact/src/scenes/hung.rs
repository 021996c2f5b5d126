//! Scenes of other programs with hanging sheets: newton and ppf-contact-solver.

use gimage_runtime::{Cloth, Collider, Flat, Scene, Shape};

use super::action::{Action, Line, Slide};
use super::{Failure, calm};

/// A horizontal square of 1 m and 0.3 kg, held by two corners, falls and swings (`style3d` of newton, 100 x 100).
pub fn style3d(scene: &mut Scene, n: u32) -> Result<(), Failure> {
    let flat = Flat { origin: [-0.5, 1.5, -0.5], mass: 0.3, ..Flat::square("sheet", n) };
    scene.cloths.push(held_by_corners(flat.cloth()?, n)?);
    Ok(())
}

/// A square of 2 m hangs by two corners; gravity points up from 1 s to 2 s (`hang` of ppf-contact-solver, 128, 200 frames).
pub fn flip(scene: &mut Scene, n: u32) -> Result<Vec<Action>, Failure> {
    scene.cloths.push(held_by_corners(wide("sheet", n, [-1.0, 0.0, -1.0]).cloth()?, n)?);
    scene.frames = 200;
    let [x, y, z] = scene.gravity;
    Ok(vec![Action::Gravity { from_s: 1.0, to: [x, -y, z] }, Action::Gravity { from_s: 2.0, to: [x, y, z] }])
}

/// Five squares of 2 m, 5 cm apart, held by two corners each, fall on a ball of 0.5 m (`drape` of ppf-contact-solver, 128, 100 frames of 0.01 s).
pub fn swing(scene: &mut Scene, n: u32) -> Result<(), Failure> {
    for layer in 0..5 {
        let flat = wide(&format!("sheet {layer}"), n, [-1.0, 0.6 + 0.05 * layer as f32, -1.0]);
        scene.cloths.push(held_by_corners(flat.cloth()?, n)?);
    }
    let ball = Shape::Sphere { radius: 0.5 };
    scene.colliders.push(Collider { friction: 0.3, ..Collider::new(ball, [0.0; 3]) });
    scene.frames = 100;
    Ok(())
}

/// Fifteen squares of 2 m hang by their upper edges, 25 cm apart; a ball of 0.5 m moves through them by 8 m in 5 s (`curtain` of
/// ppf-contact-solver, 64, 300 frames).
pub fn curtain(scene: &mut Scene, n: u32) -> Result<Vec<Action>, Failure> {
    for layer in 0..15 {
        let at = [-1.0, 1.0, 0.25 * layer as f32 - 1.75];
        let flat = Flat { down: [0.0, -2.0, 0.0], ..wide(&format!("curtain {layer}"), n, at) };
        let mut cloth = calm(flat.cloth()?);
        (0..n).try_for_each(|k| cloth.set_pinned(k as usize, true))?;
        scene.cloths.push(cloth);
    }
    let start = [0.0, 0.0, -4.0];
    let ball = Shape::Sphere { radius: 0.5 };
    scene.colliders.push(Collider { friction: 0.3, ..Collider::new(ball, start) });
    let way = Line { velocity: [0.0, 0.0, 1.6], from_s: 0.0, until_s: 5.0 };
    Ok(vec![Action::Slide(Slide { collider: 0, start, way })])
}

/// A horizontal square of 2 m and 0.8 kg.
fn wide(name: &str, n: u32, origin: [f32; 3]) -> Flat {
    Flat { origin, right: [2.0, 0.0, 0.0], down: [0.0, 0.0, 2.0], mass: 0.8, ..Flat::square(name, n) }
}

fn held_by_corners(cloth: Cloth, n: u32) -> Result<Cloth, Failure> {
    let mut cloth = calm(cloth);
    [0, n - 1].into_iter().try_for_each(|k| cloth.set_pinned(k as usize, true))?;
    Ok(cloth)
}
