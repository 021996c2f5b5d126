//! The scene of the page, which a native program can step too.

use gimage_bundle::Bundle;
use gimage_runtime::{Cloth, Collider, Result, Scene, Shape, Wind, WindForce};

/// Length of a frame \[s\].
pub const STEP: f64 = 1.0 / 60.0;

/// The garment of a bundle in wind, over a ball below its centre.
pub fn scene(bundle: &Bundle) -> Result<Scene> {
    let cloth = Cloth::from_bundle("garment", bundle)?;
    let mut scene = Scene::new("web");
    if let Some((low, high)) = cloth.bounds() {
        let [x, y, z] = [0, 1, 2].map(|c| (low[c] + high[c]) / 2.0);
        let radius = (high[1] - low[1]) / 6.0;
        scene.colliders.push(Collider::new(Shape::Sphere { radius }, [x, y - radius, z]));
    }
    let force = WindForce::Push { response: 1.0 };
    scene.wind = Some(Wind { velocity: [0.0, 0.0, 3.0], gust: 0.5, gust_size: 0.5, force });
    scene.cloths.push(cloth);
    Ok(scene)
}
