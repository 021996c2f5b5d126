//! The clothes of the figure: draped over it in the bind pose, with the weights of the body below.

use super::file::{Look, Part};
use super::png::png;
use super::rig::{COUNT, Rig, four};
use crate::body::Body;
use crate::math::V2;
use crate::sew::Garment;
use crate::surface::surface;
use crate::{skirt as skirts, tshirt as shirts};

/// The side of a panel of the T-shirt: it ends at the waist.
const SIDE: [V2; 3] = [[0.226, 1.075], [0.228, 1.12], [0.240, 1.18]];
/// Side \[m\] of the pattern of each texture, and its pixels.
const TILE: f64 = 0.08;
const PIXELS: usize = 32;

/// The T-shirt.
pub fn shirt(rig: &Rig) -> Part {
    let g = shirts::garment(&Body::person(), SIDE);
    let stripes = |_: usize, y: usize| usize::from(y % PIXELS < 9);
    part(&g, rig, 3, ("T-shirt", "jersey", look([0.80, 0.79, 0.74], &[[255, 255, 255], [64, 84, 128]], stripes)))
}

/// The skirt.
pub fn skirt(rig: &Rig) -> Part {
    let g = skirts::garment(&Body::person_on_stand());
    let check = |x: usize, y: usize| {
        usize::from(x % PIXELS < 16) + usize::from(y % PIXELS < 16) + 3 * usize::from(x == 24 || y == 24)
    };
    let palette =
        [[255, 255, 255], [206, 200, 200], [150, 140, 145], [255, 214, 120], [255, 214, 120], [255, 214, 120]];
    part(&g, rig, 60, ("Skirt", "tartan", look([0.50, 0.07, 0.09], &palette, check)))
}

/// A colour, and a pattern of its own palette.
pub fn look(factor: [f64; 3], palette: &[[u8; 3]], pattern: impl Fn(usize, usize) -> usize) -> Look {
    let pixels: Vec<u8> = (0..PIXELS * PIXELS).map(|k| pattern(k % PIXELS, k / PIXELS) as u8).collect();
    Look { factor, image: png(PIXELS, &pixels, palette) }
}

/// A part of the file; weights of neighbours are averaged in some rounds: cloth between two limbs follows both.
pub fn part(g: &Garment, rig: &Rig, rounds: usize, (name, material, look): (&'static str, &'static str, Look)) -> Part {
    let mut s = surface(g);
    let tiles = (s.metres_per_uv / TILE) as f32;
    s.uvs.iter_mut().flatten().for_each(|c| *c *= tiles);
    s.metres_per_uv = TILE;
    let weights = averaged(g, g.x.iter().map(|p| rig.weights(*p)).collect(), rounds);
    let follows = s.particle.iter().map(|i| four(&weights[*i])).collect();
    Part { name, material, look, surface: s, follows }
}

fn averaged(g: &Garment, mut weights: Vec<[f64; COUNT]>, rounds: usize) -> Vec<[f64; COUNT]> {
    let mut next: Vec<Vec<usize>> = vec![Vec::new(); weights.len()];
    for (t, _) in g.triangles() {
        (0..3).for_each(|k| next[t[k]].extend([t[(k + 1) % 3], t[(k + 2) % 3]]));
    }
    for _ in 0..rounds {
        let old = weights.clone();
        for (w, near) in weights.iter_mut().zip(&next) {
            let share = 0.5 / near.len() as f64;
            for (j, x) in w.iter_mut().enumerate() {
                *x = 0.5 * *x + share * near.iter().map(|&n| old[n][j]).sum::<f64>();
            }
        }
    }
    weights
}
