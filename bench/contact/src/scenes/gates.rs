//! Scenes of everyday contact: cloth under a load, cloth dragged over cloth, and a flag.

use gimage_runtime::{Collider, Flat, Scene, Shape, Wind, WindForce};

use super::action::{Action, Line, Slide, carry};
use super::{Failure, calm, table};

/// A sheet of 8 times the mass falls on cloth that is draped over a block.
pub fn load(scene: &mut Scene, n: u32) -> Result<(), Failure> {
    let drape = Flat { origin: [-0.5, 0.32, -0.5], ..Flat::square("drape", n) };
    scene.cloths.push(calm(drape.cloth()?));
    let (side, count) = (0.3, (3 * n / 10).max(4));
    let heavy = Flat {
        name: "load".into(),
        width: count,
        height: count,
        origin: [-0.15, 0.42, -0.15],
        right: [side, 0.0, 0.02],
        down: [-0.02, 0.0, side],
        mass: 1.6,
    };
    scene.cloths.push(calm(heavy.cloth()?));
    scene.colliders.push(table());
    let block = Shape::Box { half: [0.2, 0.15, 0.2] };
    scene.colliders.push(Collider { friction: 0.5, ..Collider::new(block, [0.0, 0.15, 0.0]) });
    Ok(())
}

/// A strip is drawn by one end over another strip that lies across it on a table, by 1 m in 4 s.
pub fn drag(scene: &mut Scene, n: u32) -> Result<Vec<Action>, Failure> {
    let narrow = (n / 4).max(3);
    let strip = |name: &str, origin, right| Flat {
        name: name.into(),
        width: n,
        height: narrow,
        origin,
        right,
        down: [0.0, 0.0, 0.25],
        mass: 0.05,
    };
    let lower = Flat { down: [-0.25, 0.0, 0.0], ..strip("lower", [0.125, 0.012, -0.5], [0.0, 0.0, 1.0]) };
    scene.cloths.push(calm(lower.cloth()?));
    scene.cloths.push(calm(strip("upper", [-0.9, 0.05, -0.125], [1.0, 0.0, 0.0]).cloth()?));
    scene.colliders.push(table());
    let end = (0..narrow).map(|row| row * n + n - 1).collect();
    let way = Line { velocity: [0.25, 0.0, 0.0], from_s: 0.5, until_s: 4.5 };
    Ok(vec![carry(scene, 1, end, way)?])
}

/// A flag at a pole in gusts, 30 s.
pub fn flag(scene: &mut Scene, n: u32) -> Result<(), Failure> {
    let height = (2 * n / 3).max(3);
    let flat = Flat {
        name: "flag".into(),
        width: n,
        height,
        origin: [0.0, 2.0, 0.0],
        right: [1.2, 0.0, 0.0],
        down: [0.0, -0.8, 0.0],
        mass: 0.12,
    };
    let mut cloth = flat.cloth()?;
    cloth.damping = 0.3;
    (0..height).try_for_each(|row| cloth.set_pinned((row * n) as usize, true))?;
    scene.cloths.push(cloth);
    scene.wind = Some(Wind {
        velocity: [7.0, 0.4, 1.0],
        gust: 55.0f32.to_radians(),
        gust_size: 0.7,
        force: WindForce::Triangles { density: 1.2, drag: 1.0, lift: 0.6 },
    });
    let pole = Shape::Capsule { half_height: 1.0, radius: 0.02 };
    scene.colliders.push(Collider::new(pole, [-0.022, 1.1, 0.0]));
    scene.frames = 1800;
    Ok(())
}

/// Ten squares on a table, each turned by 9 degrees more, under a ball of 0.25 m that comes down at 5 m/s and stops where it presses the pile to 11 times the
/// distance of neighbours (`stack` of ppf-contact-solver, 128; its ball is so heavy that cloth hardly slows it).
pub fn stack(scene: &mut Scene, n: u32) -> Result<Vec<Action>, Failure> {
    let h = 1.0 / (n - 1) as f32;
    for layer in 0..10 {
        let (s, c) = (9.0f32.to_radians() * layer as f32).sin_cos();
        let corner = [-0.5 * c + 0.5 * s, 1.3 * h * (layer as f32 + 1.0), -0.5 * s - 0.5 * c];
        let flat = Flat {
            origin: corner,
            right: [c, 0.0, s],
            down: [-s, 0.0, c],
            ..Flat::square(&format!("sheet {layer}"), n)
        };
        scene.cloths.push(calm(flat.cloth()?));
    }
    scene.colliders.push(table());
    let (radius, seconds) = (0.25, 0.2);
    let stop = radius + 11.0 * h;
    let start = [0.0, stop + 5.0 * seconds, 0.0];
    scene.colliders.push(Collider { friction: 0.5, ..Collider::new(Shape::Sphere { radius }, start) });
    scene.frames = 120;
    let way = Line { velocity: [0.0, -5.0, 0.0], from_s: 0.5, until_s: 0.5 + f64::from(seconds) };
    Ok(vec![Action::Slide(Slide { collider: 1, start, way })])
}
