//! Scenes in which cloth meets cloth.

mod crossed;
mod garment;
mod many;
mod tube;
mod turned;

use std::path::Path;

use gimage_runtime::{Cloth, Collider, Flat, Scene, Shape};

use crate::run::Failure;
pub use turned::Turn;

/// All of them.
pub const NAMES: [&str; 13] =
    ["fold", "drop", "hang", "ball", "pile", "drape", "layers", "cards", "twist", "tube", "overlap", "waves", "coat"];

/// A scene, and what moves in it.
pub struct Set {
    pub scene: Scene,
    /// The distance \[m\] of neighbouring particles.
    pub spacing: f32,
    pub turns: Vec<Turn>,
}

/// A scene by its name, or the bundle in this directory, with `n` particles per side; `layers` sheets where the scene has a pile of them.
pub fn scene(name: &str, n: u32, layers: u32) -> Result<Set, Failure> {
    let mut spacing = 1.0 / (n - 1) as f32;
    let mut turns = Vec::new();
    if Path::new(name).is_dir() {
        let (scene, spacing) = garment::garment(name)?;
        return Ok(Set { scene, spacing, turns });
    }
    let mut scene = Scene::new(name);
    scene.frames = 300;
    let table = table();
    match name {
        // Folded to three layers, on a table.
        "fold" => {
            scene.cloths.push(folded(n, 3, 0.01)?);
            scene.colliders.push(table);
            scene.frames = 600;
        }
        // Upright, dropped on a table.
        "drop" => {
            let flat = Flat { origin: [0.0, 1.1, 0.0], down: [0.1, -1.0, 0.05], ..Flat::square("sheet", n) };
            scene.cloths.push(calm(flat.cloth()?));
            scene.colliders.push(table);
        }
        // By two neighbouring corners brought together.
        "hang" => {
            let flat = Flat { origin: [0.0, 1.0, 0.0], down: [0.0, -1.0, 0.0], ..Flat::square("sheet", n) };
            let mut cloth = calm(flat.cloth()?);
            let wave = |p: &[f32; 3]| [0.3 * p[0], p[1], 0.05 * (18.0 * p[0]).sin()];
            cloth.place(cloth.positions().iter().map(wave).collect())?;
            [0, n - 1].into_iter().try_for_each(|k| cloth.set_pinned(k as usize, true))?;
            scene.cloths.push(cloth);
        }
        // Draped over a ball on a table.
        "ball" => {
            let flat = Flat { origin: [-0.5, 0.62, -0.5], ..Flat::square("sheet", n) };
            scene.cloths.push(calm(flat.cloth()?));
            scene.colliders.push(table);
            scene
                .colliders
                .push(Collider { friction: 0.5, ..Collider::new(Shape::Sphere { radius: 0.15 }, [0.0, 0.45, 0.0]) });
        }
        // Three sheets dropped on a box.
        "pile" => {
            for layer in 0..3 {
                let height = 0.36 + 0.05 * layer as f32;
                let flat = Flat { origin: [-0.5, height, -0.5], ..Flat::square("sheet", n) };
                scene.cloths.push(calm(flat.cloth()?));
            }
            scene.colliders.push(table);
            let block = Shape::Box { half: [0.2, 0.15, 0.2] };
            scene.colliders.push(Collider { friction: 0.5, ..Collider::new(block, [0.0, 0.15, 0.0]) });
        }
        // Five squares held by two corners each swing against a ball.
        "drape" => {
            for layer in 0..5 {
                let away = 0.05 * layer as f32;
                let flat =
                    Flat { origin: [-0.5, 0.5 + away, 0.3 + away], down: [0.0, 0.0, 1.0], ..Flat::square("sheet", n) };
                let mut cloth = calm(flat.cloth()?);
                [0, n - 1].into_iter().try_for_each(|k| cloth.set_pinned(k as usize, true))?;
                scene.cloths.push(cloth);
            }
            let ball = Shape::Sphere { radius: 0.3 };
            scene.colliders.push(Collider { friction: 0.3, ..Collider::new(ball, [0.0, -0.2, 0.0]) });
            scene.frames = 120;
        }
        "layers" => many::layers(&mut scene, n, layers)?,
        "cards" => {
            many::cards(&mut scene)?;
            spacing = 0.015;
        }
        "twist" => turns = turned::twist(&mut scene, n)?,
        "tube" => {
            turns = turned::wrung(&mut scene, n)?;
            spacing = std::f32::consts::TAU * 0.15 / (n - 1) as f32;
        }
        "overlap" => crossed::overlap(&mut scene, n)?,
        "waves" => crossed::waves(&mut scene, n)?,
        "coat" => {
            crossed::coat(&mut scene, n)?;
            spacing = std::f32::consts::TAU * 0.15 / (n - 1) as f32;
        }
        _ => return Err(format!("no scene of this name and no bundle; there are {}", NAMES.join(", ")).into()),
    }
    Ok(Set { scene, spacing, turns })
}

fn table() -> Collider {
    Collider { friction: 0.5, ..Collider::new(Shape::HalfSpace, [0.0; 3]) }
}

fn calm(mut cloth: Cloth) -> Cloth {
    cloth.damping = 0.5;
    cloth
}

/// A square folded to some layers, `gap` \[m\] apart, the lowest `gap` above the table. Springs are those of the flat square.
fn folded(n: u32, layers: u32, gap: f32) -> Result<Cloth, Failure> {
    let mut cloth = calm(Flat::square("sheet", n).cloth()?);
    let bend = std::f32::consts::PI * gap / 2.0;
    let straight = (1.0 - (layers - 1) as f32 * bend) / layers as f32;
    let at = |x: f32| {
        let layer = (x / (straight + bend)).floor().min((layers - 1) as f32);
        let (along, right) = (x - layer * (straight + bend), (layer as u32).is_multiple_of(2));
        let y = gap * (layer + 1.0);
        let (far, up) = if along <= straight {
            (along, 0.0)
        } else {
            let angle = (along - straight) / gap * 2.0;
            (straight + gap / 2.0 * angle.sin(), gap / 2.0 * (1.0 - angle.cos()))
        };
        [if right { far } else { straight - far }, y + up]
    };
    let place = |p: &[f32; 3]| {
        let [x, y] = at(p[0]);
        [x, y, p[2]]
    };
    cloth.place(cloth.positions().iter().map(place).collect())?;
    Ok(cloth)
}
