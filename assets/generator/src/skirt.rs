//! A flared skirt of two panels, each a sector of a ring.

use crate::body::Body;
use crate::drape::{Drape, drape, smooth};
use crate::glb::{Scene, write};
use crate::math::{PI, V2, V3, atan2, cos, sin};
use crate::panel::{Edge, Panel, curve, line};
use crate::sew::{Garment, sew};
use crate::surface::surface;

/// One panel of a flared skirt.
#[derive(Clone, Copy)]
pub struct Flare {
    /// Half the angle of the sector.
    pub half_angle: f64,
    /// The radius of the waist edge.
    pub inner: f64,
    /// The radius of the hem.
    pub outer: f64,
}

/// The waist of the figure at the height where skirts sit: half axes of an ellipse.
const WAIST: V2 = [0.147, 0.108];
const WAIST_HEIGHT: f64 = 1.07;
const SHAPE: Flare = Flare { half_angle: 0.72, inner: 0.281, outer: 0.851 };

/// The file. Its mesh is in centimetres, Z up, under a node that turns and scales it.
pub fn skirt() -> Vec<u8> {
    let mut s = surface(&garment(&Body::stand()));
    for p in &mut s.positions {
        *p = [p[0], -p[2], p[1]].map(|c| (f64::from(c) * 1e5).round() / 1e3).map(|c| c as f32);
    }
    for n in &mut s.normals {
        *n = [n[0], -n[2], n[1]];
    }
    let turn = 0.5f64.sqrt();
    let scene = Scene {
        name: "skirt",
        material: ("wool crepe", [0.42, 0.08, 0.12]),
        short_indices: false,
        parent: Some(("z up, centimetres", [-turn, 0.0, 0.0, turn], 0.01)),
        pin: None,
        colours: None,
        skin: None,
    };
    write(&s, &scene)
}

/// The skirt, draped over a body on a stand.
pub fn garment(body: &Body) -> Garment {
    let panel = |which: &'static str, side: f64| Panel {
        outline: sector(SHAPE, which),
        holes: vec![],
        place: Box::new(move |p| on_cone(SHAPE, WAIST, WAIST_HEIGHT, p, side)),
    };
    let mut g = sew(&[panel("f", 1.0), panel("b", -1.0)], 0.0225);
    let pins = g.on_edges("waist");
    let how =
        Drape { body, pins: &pins, steps: 420, bend: 0.45, friction: 0.2, layer: 0.018, gap: 0.006, limit: &|_, p| p };
    drape(&mut g, &how);
    smooth(&mut g, 3, &pins);
    g
}

/// The outline of a flared panel, hem first; the sector's centre is the origin.
pub fn sector(f: Flare, which: &str) -> Vec<Edge> {
    let at = |r: f64, a: f64| [r * sin(a), -r * cos(a)];
    let (left, right) = if which == "f" { ("skirt-r", "skirt-l") } else { ("skirt-l", "skirt-r") };
    let a = f.half_angle;
    vec![
        curve(&format!("hem-{which}"), |t| at(f.outer, a * (2.0 * t - 1.0))),
        line(right, at(f.outer, a), at(f.inner, a)),
        curve(&format!("waist-{which}"), |t| at(f.inner, a * (1.0 - 2.0 * t))),
        line(left, at(f.inner, -a), at(f.outer, -a)),
    ]
}

/// Half a turn of a wavy cone from an ellipse at `height` down; `side` is 1 in front and -1 behind.
pub fn on_cone(f: Flare, waist: V2, height: f64, p: V2, side: f64) -> V3 {
    let r = (p[0] * p[0] + p[1] * p[1]).sqrt();
    let down = r - f.inner;
    let share = atan2(p[0], -p[1]) / f.half_angle;
    let phi = share * PI / 2.0 + if side > 0.0 { 0.0 } else { PI };
    let wave = 0.028 * (down / (f.outer - f.inner)) * (sin(7.0 * phi + 0.6) + 0.5 * sin(4.0 * phi + 2.0));
    let flare = 0.30 * down + wave;
    [(waist[0] + flare) * sin(phi), height - 0.93 * down, (waist[1] + flare) * cos(phi)]
}
