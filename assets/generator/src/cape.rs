//! A cape: one sector of a ring, already a disk.

use crate::body::Body;
use crate::drape::{Drape, drape, smooth};
use crate::glb::{Scene, write};
use crate::math::{PI, V2, V3, atan2, cos, sin, smoothstep};
use crate::panel::{Edge, Panel, curve, line};
use crate::sew::{Garment, sew};
use crate::surface::surface;

/// Half the angle of the sector, and its two radii.
const HALF_ANGLE: f64 = 1.5;
const INNER: f64 = 0.138;
const OUTER: f64 = 0.95;
/// Half the angle of the neck that the collar goes round; the rest is open in front.
const ROUND: f64 = 2.62;

/// The file. `_PIN` is 1 on the collar and 0 elsewhere.
pub fn cape() -> Vec<u8> {
    let g = garment();
    let s = surface(&g);
    let collar = g.on_edges("collar");
    let pin = s.particle.iter().map(|i| if collar.contains(i) { 1.0 } else { 0.0 }).collect();
    let scene = Scene {
        name: "cape",
        material: ("green loden", [0.07, 0.18, 0.10]),
        short_indices: true,
        parent: None,
        pin: Some(pin),
        colours: None,
        skin: None,
    };
    write(&s, &scene)
}

fn garment() -> Garment {
    let body = Body::arms_down();
    let mut g = sew(&[Panel { outline: outline(), holes: vec![], place: Box::new(place) }], 0.0245);
    let pins = g.on_edges("collar");
    let how = Drape {
        body: &body,
        pins: &pins,
        steps: 480,
        bend: 0.5,
        friction: 0.2,
        layer: 0.018,
        gap: 0.008,
        limit: &|_, p| p,
    };
    drape(&mut g, &how);
    smooth(&mut g, 3, &pins);
    g
}

/// The middle of the back is at the top of the panel.
fn outline() -> Vec<Edge> {
    let at = |r: f64, a: f64| [r * sin(a), r * cos(a)];
    vec![
        curve("hem", |t| at(OUTER, HALF_ANGLE * (1.0 - 2.0 * t))),
        line("front-l", at(OUTER, -HALF_ANGLE), at(INNER, -HALF_ANGLE)),
        curve("collar", |t| at(INNER, HALF_ANGLE * (2.0 * t - 1.0))),
        line("front-r", at(INNER, HALF_ANGLE), at(OUTER, HALF_ANGLE)),
    ]
}

/// A wavy cone round the shoulders, its axis through the neck.
fn place(p: V2) -> V3 {
    let r = (p[0] * p[0] + p[1] * p[1]).sqrt();
    let a = atan2(p[0], p[1]);
    let phi = PI - a / HALF_ANGLE * ROUND;
    let out = r - INNER;
    let wave = 0.045 * smoothstep(0.2, 0.75, out) * (sin(8.0 * phi) + 0.4 * sin(5.0 * phi + 1.0));
    // First over the shoulders, then down.
    let spread = 0.165 * smoothstep(0.0, 0.22, out) + 0.16 * out + wave;
    let drop = out - 0.07 * smoothstep(0.0, 0.25, out);
    let y = 1.515 - drop * 0.95 - 0.012 * cos(phi);
    [(0.076 + 1.1 * spread) * sin(phi), y, 0.004 + (0.074 + 0.85 * spread) * cos(phi)]
}
