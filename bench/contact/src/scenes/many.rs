//! Scenes of many cloths: piles of sheets and of cards.

use gimage_runtime::{Collider, Flat, Scene, Shape};

use super::{Failure, calm, table};

/// Sheets dropped on a cylinder, from which they slide to the ground (the scene of Offset Geometric Contact, which has 50 of 70 x 70).
pub fn layers(scene: &mut Scene, n: u32, count: u32) -> Result<(), Failure> {
    for layer in 0..count {
        let flat =
            Flat { origin: [-0.45, 0.63 + 0.02 * layer as f32, -0.5], ..Flat::square(&format!("sheet {layer}"), n) };
        scene.cloths.push(calm(flat.cloth()?));
    }
    scene.colliders.push(table());
    let lying = std::f32::consts::FRAC_1_SQRT_2;
    let cylinder = Shape::Capsule { half_height: 0.6, radius: 0.2 };
    scene.colliders.push(Collider {
        friction: 0.2,
        rotation: [lying, 0.0, 0.0, lying],
        ..Collider::new(cylinder, [0.0, 0.4, 0.0])
    });
    Ok(())
}

/// A pile of 52 stiff cards of 5 x 7 particles and 1.8 g that falls on a table, each turned a little (a scene of newton).
pub fn cards(scene: &mut Scene) -> Result<(), Failure> {
    for card in 0..52 {
        let (s, c) = (0.1 * (card as f32 * 2.4).sin()).sin_cos();
        let flat = Flat {
            name: format!("card {card}"),
            width: 5,
            height: 7,
            origin: [-0.03 + 0.004 * (card as f32).cos(), 0.03 + 0.02 * card as f32, -0.045],
            right: [0.063 * c, 0.0, 0.063 * s],
            down: [-0.088 * s, 0.0, 0.088 * c],
            mass: 0.0018,
        };
        scene.cloths.push(calm(flat.cloth()?));
    }
    scene.colliders.push(table());
    Ok(())
}
