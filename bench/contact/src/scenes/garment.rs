//! A garment of a bundle, on the body that the bundle has.

use std::path::Path;

use gimage_runtime::{BodyCollider, Cloth, Scene};

use super::{Failure, calm};

/// The scene, without gravity if nothing holds the garment, and the mean length \[m\] of its edges.
pub fn garment(path: &str) -> Result<(Scene, f32), Failure> {
    let bundle = gimage_bundle::dir::read_dir(Path::new(path))?;
    let cloth = calm(Cloth::from_bundle(path, &bundle)?);
    let mut scene = Scene::new(path);
    scene.colliders = BodyCollider::of_bundle(&bundle).into_iter().map(|body| body.collider).collect();
    let held = !scene.colliders.is_empty() || cloth.particles().iter().any(|particle| particle.is_pinned());
    if !held {
        scene.gravity = [0.0; 3];
    }
    let spacing = mean_edge(&cloth);
    scene.cloths.push(cloth);
    scene.frames = 120;
    Ok((scene, spacing))
}

fn mean_edge(cloth: &Cloth) -> f32 {
    let (mut sum, mut count) = (0.0f64, 0u32);
    for grid in cloth.grids() {
        for k in grid.range().filter(|k| !(k - grid.first as usize + 1).is_multiple_of(grid.width as usize)) {
            if cloth.particles()[k].exists() && cloth.particles()[k + 1].exists() {
                let (a, b) = (cloth.positions()[k], cloth.positions()[k + 1]);
                sum += (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
                count += 1;
            }
        }
    }
    (sum / f64::from(count.max(1))) as f32
}
