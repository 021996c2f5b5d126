//! A garment and a crowd of it.

use gimage_runtime::{Cloth, Collider, Grid, Mass, Particle, Parts, Rest, Result, Scene, Shape, Wind, WindForce};

/// Radius and length of the skirt \[m\].
const RADIUS: f32 = 0.2;
const LENGTH: f32 = 0.8;

/// A skirt of `n` x `n` texels: a tube with a seam along its side, held by its first row.
pub fn skirt(n: u32) -> Result<Cloth> {
    let (last, texel) = (n - 1, |i: u32, j: u32| j * n + i);
    let mut positions = Vec::new();
    let mut particles = Vec::new();
    for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let (s, c) = (std::f32::consts::TAU * (i % last) as f32 / last as f32).sin_cos();
        // Wider towards the hem.
        let wide = RADIUS * (1.0 + 0.5 * j as f32 / last as f32);
        positions.push([wide * c, -LENGTH * j as f32 / last as f32, wide * s]);
        let next = if i == 0 {
            Some(texel(last, j))
        } else if i == last {
            Some(texel(0, j))
        } else {
            None
        };
        particles.push(if j == 0 { Particle::Pinned { next } } else { Particle::Free { next } });
    }
    let far = |a: u32, b: u32| {
        let way = (0..3).map(|c| (positions[a as usize][c] - positions[b as usize][c]).powi(2));
        way.sum::<f32>().sqrt()
    };
    let rest = (0..n * n).map(|k| {
        let (i, j) = (k % n, k / n);
        let to = |there: bool, i: u32, j: u32| if there { far(k, texel(i, j)) } else { 0.0 };
        let (right, down) = (i + 1 < n, j + 1 < n);
        [
            to(right, i + 1, j),
            to(down, i, j + 1),
            to(right && down, i + 1, j + 1),
            to(right && j > 0, i + 1, j.saturating_sub(1)),
        ]
    });
    let rest = Rest::Image(rest.collect());
    let grids = vec![Grid { name: "skirt".into(), first: 0, width: n, height: n }];
    let mass = Mass::Constant(0.2 / (n * n) as f32);
    let mut cloth = Cloth::new(Parts { name: "skirt".into(), grids, positions, particles, rest, mass })?;
    cloth.damping = 0.5;
    Ok(cloth)
}

/// Instances of the skirt, all around the same leg, so that each has its contact, in a light wind.
pub fn crowd(n: u32, garments: u32) -> Result<Scene> {
    let mut scene = Scene::new("crowd");
    let cloth = skirt(n)?;
    scene.cloths = vec![cloth; garments as usize];
    let leg = Shape::Capsule { half_height: 0.5, radius: 0.15 };
    scene.colliders.push(Collider { friction: 0.3, ..Collider::new(leg, [0.0, -0.5, 0.0]) });
    let force = WindForce::Push { response: 0.8 };
    scene.wind = Some(Wind { velocity: [1.0, 0.0, 0.5], gust: 1.0, gust_size: 0.3, force });
    Ok(scene)
}
