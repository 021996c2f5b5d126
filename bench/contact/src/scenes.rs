//! Scenes in which cloth meets cloth.

mod action;
mod crossed;
mod garment;
mod gates;
mod hung;
mod many;
mod tube;
mod turned;

use std::path::Path;

use gimage_runtime::{Cloth, Collider, Flat, Scene, Shape};

use crate::run::Failure;
pub use action::Action;

/// All of them.
pub const NAMES: [&str; 21] = [
    "fold", "drop", "hang", "ball", "pile", "drape", "layers", "cards", "twist", "tube", "style3d", "flip", "swing",
    "curtain", "stack", "load", "drag", "flag", "overlap", "waves", "coat",
];

/// Scenes at the size that their sources give, with particles per side and number of sheets; other scenes have none.
pub const FULL: [(&str, u32, u32); 13] = [
    ("layers", 70, 50),
    ("twist", 51, 1),
    ("cards", 5, 52),
    ("style3d", 100, 1),
    ("flip", 128, 1),
    ("swing", 128, 5),
    ("curtain", 64, 15),
    ("stack", 128, 10),
    ("tube", 96, 1),
    ("fold", 128, 3),
    ("load", 64, 2),
    ("drag", 64, 2),
    ("flag", 64, 1),
];

/// A scene, and what moves in it.
pub struct Set {
    pub scene: Scene,
    /// The distance \[m\] of neighbouring particles.
    pub spacing: f32,
    /// Length of a frame \[s\].
    pub frame_s: f64,
    /// Friction between cloths.
    pub friction: f32,
    pub actions: Vec<Action>,
}

/// A scene by its name, or the bundle in this directory, with `n` particles per side; `layers` sheets where the scene has a pile of them.
pub fn scene(name: &str, n: u32, layers: u32) -> Result<Set, Failure> {
    let (frame_s, friction) = (1.0 / 60.0, 0.3);
    let mut set =
        Set { scene: Scene::new(name), spacing: 1.0 / (n - 1) as f32, frame_s, friction, actions: Vec::new() };
    if Path::new(name).is_dir() {
        (set.scene, set.spacing) = garment::garment(name)?;
        return Ok(set);
    }
    let Set { scene, spacing, .. } = &mut set;
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
        "layers" => many::layers(scene, n, layers)?,
        "cards" => {
            many::cards(scene)?;
            *spacing = 0.015;
        }
        "twist" => {
            set.actions = turned::twist(scene, n)?;
            set.friction = 0.2;
        }
        "tube" => {
            *spacing = std::f32::consts::TAU * 0.15 / (n - 1) as f32;
            set.actions = turned::wrung(scene, n)?;
        }
        "style3d" => hung::style3d(scene, n)?,
        "flip" => {
            *spacing *= 2.0;
            set.actions = hung::flip(scene, n)?;
        }
        "swing" => {
            *spacing *= 2.0;
            hung::swing(scene, n)?;
            set.frame_s = 0.01;
        }
        "curtain" => {
            *spacing *= 2.0;
            set.actions = hung::curtain(scene, n)?;
        }
        "stack" => {
            set.actions = gates::stack(scene, n)?;
            set.friction = 0.5;
        }
        "load" => gates::load(scene, n)?,
        "drag" => set.actions = gates::drag(scene, n)?,
        "flag" => {
            *spacing *= 1.2;
            gates::flag(scene, n)?;
        }
        "overlap" => crossed::overlap(scene, n)?,
        "waves" => crossed::waves(scene, n)?,
        "coat" => {
            crossed::coat(scene, n)?;
            *spacing = std::f32::consts::TAU * 0.15 / (n - 1) as f32;
        }
        _ => return Err(format!("no scene of this name and no bundle; there are {}", NAMES.join(", ")).into()),
    }
    Ok(set)
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
