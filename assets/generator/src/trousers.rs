//! Trousers of four panels with one belt loop.

use crate::belt_loop;
use crate::body::Body;
use crate::drape::{Drape, drape, smooth};
use crate::glb::{Scene, write};
use crate::math::{PI, V2, V3, cos, sin};
use crate::panel::{Edge, Panel, bezier, line, mirror};
use crate::sew::{Garment, sew};
use crate::surface::surface;

const WAIST_HEIGHT: f64 = 1.06;
/// Half axes of the waist.
const WAIST: V2 = [0.148, 0.108];

/// The file.
pub fn trousers() -> Vec<u8> {
    let s = surface(&garment());
    let material = ("denim", [0.05, 0.09, 0.20]);
    let scene =
        Scene { name: "trousers", material, short_indices: true, parent: None, pin: None, colours: None, skin: None };
    write(&s, &scene)
}

fn garment() -> Garment {
    let body = Body::figure();
    let (front, back) = (leg(FRONT, "f"), leg(BACK, "b"));
    // A left panel seen from behind is a mirror image, and so is a right one from the front.
    let other = |name: &str| {
        let stem = name.strip_suffix("-l");
        stem.map_or(name.to_string(), |stem| format!("{stem}-r"))
    };
    let same = str::to_string;
    let panels = [
        Panel { outline: front.clone(), holes: belt_loop::holes(), place: Box::new(|p| on_leg(FRONT, p, 1.0, 1.0)) },
        Panel { outline: mirror(&front, other), holes: vec![], place: Box::new(|p| on_leg(FRONT, p, -1.0, 1.0)) },
        Panel { outline: mirror(&back, same), holes: vec![], place: Box::new(|p| on_leg(BACK, p, 1.0, -1.0)) },
        Panel {
            outline: back.iter().map(|e| Edge { name: other(&e.name), ..e.clone() }).collect(),
            holes: vec![],
            place: Box::new(|p| on_leg(BACK, p, -1.0, -1.0)),
        },
    ];
    let mut g = sew(&panels, 0.0215);
    let pins = g.on_edges("waist");
    // Each leg stays on its own side of the middle.
    let mut side = vec![0.0; g.x.len()];
    for (k, s) in [1.0, -1.0, 1.0, -1.0].into_iter().enumerate() {
        g.particle[k].iter().for_each(|&i| side[i] = s);
    }
    g.on_edges("crotch").into_iter().for_each(|i| side[i] = 0.0);
    let limit = |i: usize, p: V3| {
        let least = if p[1] < 0.78 { 0.006 } else { 0.0 };
        if side[i] * p[0] < least && side[i] != 0.0 { [side[i] * least, p[1], p[2]] } else { p }
    };
    let how = Drape {
        body: &body,
        pins: &pins,
        steps: 420,
        bend: 0.15,
        friction: 0.25,
        layer: 0.018,
        gap: 0.006,
        limit: &limit,
    };
    drape(&mut g, &how);
    let rings = g.panels[0].holes.iter().flatten().map(|&i| g.particle[0][i]);
    let still: Vec<usize> = pins.iter().copied().chain(rings).collect();
    smooth(&mut g, 2, &still);
    belt_loop::sew_on(&mut g, 0);
    g
}

/// The measures of half a front or back: all widths from the centre line.
#[derive(Clone, Copy)]
struct Cut {
    waist: f64,
    centre: f64,
    hip: f64,
    crotch: V2,
    knee: f64,
    hem: V2,
    rise: f64,
}

const FRONT: Cut = Cut {
    waist: 0.216,
    centre: 0.012,
    hip: 0.252,
    crotch: [-0.048, 0.795],
    knee: 0.232,
    hem: [0.018, 0.212],
    rise: 0.0,
};
const BACK: Cut = Cut {
    waist: 0.236,
    centre: 0.032,
    hip: 0.262,
    crotch: [-0.085, 0.795],
    knee: 0.240,
    hem: [0.002, 0.222],
    rise: 0.02,
};

/// Half a front, or half a back as if seen from the front: the wearer's left.
fn leg(c: Cut, which: &str) -> Vec<Edge> {
    let hem_height = 0.09;
    let (hem, hip) = ([c.hem[1], hem_height], [c.hip, 0.88]);
    vec![
        line(&format!("cuff-{which}-l"), [c.hem[0], hem_height], [c.hem[1], hem_height]),
        bezier("out-low-l", [hem, [c.knee, 0.40], [c.hip + 0.004, 0.70], hip]),
        bezier("out-high-l", [hip, [c.hip - 0.002, 0.94], [c.waist + 0.012, 1.0], [c.waist, WAIST_HEIGHT]]),
        line(&format!("waist-{which}-l"), [c.waist, WAIST_HEIGHT], [c.centre, WAIST_HEIGHT + c.rise]),
        bezier(
            &format!("crotch-{which}"),
            [[c.centre, WAIST_HEIGHT + c.rise], [0.0, 0.90], [c.crotch[0] * 0.15, c.crotch[1] + 0.002], c.crotch],
        ),
        bezier("in-l", [c.crotch, [c.crotch[0] + 0.04, 0.70], [c.hem[0] - 0.012, 0.52], [c.hem[0], hem_height]]),
    ]
}

/// Where a panel point starts; `left` and `front` are 1 or -1.
fn on_leg(c: Cut, p: V2, left: f64, front: f64) -> V3 {
    // Panel x of the wearer's left as seen from the front.
    let u = p[0] * left * front;
    if p[1] > WAIST_HEIGHT - 1e-9 {
        let phi = (u - c.centre) / (c.waist - c.centre) * PI / 2.0;
        return [left * WAIST[0] * sin(phi), WAIST_HEIGHT, front * WAIST[1] * cos(phi)];
    }
    let depth = 0.10 + 0.06 * (p[1] - 0.1);
    if p[1] > 0.80 {
        let across = (u / (c.hip + 0.01)).clamp(0.0, 1.0);
        return [left * u.max(0.0) * 0.85, p[1], front * (depth + 0.02) * (1.0 - across * across).sqrt()];
    }
    // Half a tube round the leg, from the inside over the front (or back) to the outside.
    let t = (0.81 - p[1]) / 0.72;
    let inner = c.crotch[0] + (c.hem[0] - c.crotch[0]) * t.min(1.0);
    let phi = ((u - inner) / (c.hip - inner)).clamp(0.0, 1.0) * PI;
    [left * (0.112 + 0.02 * t - 0.10 * cos(phi)), p[1], front * 0.10 * sin(phi)]
}
