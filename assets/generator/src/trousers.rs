//! Trousers of four panels with one belt loop: a flat tube between two holes, which gives the surface a handle.

use crate::body::Body;
use crate::drape::{Drape, drape, smooth};
use crate::glb::{Scene, write};
use crate::math::{PI, V2, V3, add, cos, cross, lerp, norm, scale, sin, sub, unit};
use crate::panel::{Edge, Panel, PanelMesh, bezier, line, mirror};
use crate::sew::{Garment, sew};
use crate::surface::surface;

const WAIST_HEIGHT: f64 = 1.06;
/// Half axes of the waist.
const WAIST: V2 = [0.148, 0.108];
/// The middle of the belt loop on the front left panel, and the size of its holes.
const LOOP: V2 = [0.090, 1.012];
const HOLE: V2 = [0.034, 0.011];
/// How far apart the centres of the two holes are.
const SPAN: f64 = 0.054;

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
    let holes = || vec![hole(LOOP[1] + SPAN / 2.0), hole(LOOP[1] - SPAN / 2.0)];
    let (front, back) = (leg(FRONT, "f"), leg(BACK, "b"));
    // A left panel seen from behind is a mirror image, and so is a right one from the front.
    let other = |name: &str| {
        let stem = name.strip_suffix("-l");
        stem.map_or(name.to_string(), |stem| format!("{stem}-r"))
    };
    let same = str::to_string;
    let panels = [
        Panel { outline: front.clone(), holes: holes(), place: Box::new(|p| on_leg(FRONT, p, 1.0, 1.0)) },
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
    add_loop(&mut g);
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

/// A clockwise rectangle with two segments across and one down, starting at its top left corner.
fn hole(y: f64) -> Vec<V2> {
    let (w, h) = (HOLE[0] / 2.0, HOLE[1] / 2.0);
    [[-w, h], [0.0, h], [w, h], [w, -h], [0.0, -h], [-w, -h]].iter().map(|q| [q[0] + LOOP[0], q[1] + y]).collect()
}

/// Bridges the two holes with a tube that arches over the cloth.
fn add_loop(g: &mut Garment) {
    let ring = |k: usize| g.panels[0].holes[k].iter().map(|&i| g.particle[0][i]).collect::<Vec<_>>();
    let (top, low) = (ring(0), ring(1));
    // What is above at the upper hole is below at the lower one.
    let bottom: Vec<usize> = [5, 4, 3, 2, 1, 0].iter().map(|&k| low[k]).collect();
    let x = |i: usize| g.x[i];
    let out = unit(cross(sub(x(top[2]), x(low[0])), sub(x(top[0]), x(low[2]))));
    let steps = 7;
    let mut rings = vec![top.clone()];
    let mut places = g.x.clone();
    for s in 1..steps {
        let t = s as f64 / steps as f64;
        let arch = |k: usize| {
            // The upper side of the strap arches higher than the one next to the cloth.
            let high = if k < 3 { 0.020 } else { 0.010 };
            add(lerp(x(top[k]), x(bottom[k]), ease(t)), scale(out, high * 4.0 * t * (1.0 - t)))
        };
        rings.push((0..6).map(|k| places.len() + k).collect());
        places.extend((0..6).map(arch));
    }
    rings.push(bottom);
    g.x = places;
    g.panels.push(strip(&g.x, &rings));
    g.particle.push(rings.iter().flat_map(|r| (0..=6).map(|k| r[k % 6])).collect());
}

/// Leaves the ends steeply, so that the strap stands off the cloth.
fn ease(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t) * 0.6 + t * 0.4
}

/// The tube unrolled: seven columns, the last one sewn to the first.
fn strip(x: &[V3], rings: &[Vec<usize>]) -> PanelMesh {
    let gap = |a: usize, b: usize| norm(sub(x[a], x[b]));
    let across: Vec<f64> = (0..6).map(|k| rings.iter().map(|r| gap(r[k], r[(k + 1) % 6])).sum::<f64>()).collect();
    let mut points: Vec<V2> = Vec::new();
    let mut down = 0.0;
    for (j, r) in rings.iter().enumerate() {
        if j > 0 {
            down -= (0..6).map(|k| gap(r[k], rings[j - 1][k])).sum::<f64>() / 6.0;
        }
        let mut u = 0.0;
        for k in 0..=6 {
            points.push([u, down]);
            u += across[k % 6] / rings.len() as f64;
        }
    }
    let mut triangles = Vec::new();
    for j in 0..rings.len() - 1 {
        for k in 0..6 {
            let (a, b) = (j * 7 + k, j * 7 + k + 1);
            let (c, d) = (a + 7, b + 7);
            let [pa, pb, pc, pd] = [a, b, c, d].map(|i| x[rings[i / 7][(i % 7) % 6]]);
            // Split along the shorter diagonal.
            if norm(sub(pb, pc)) < norm(sub(pa, pd)) {
                triangles.extend([[b, a, c], [b, c, d]]);
            } else {
                triangles.extend([[b, a, d], [a, c, d]]);
            }
        }
    }
    PanelMesh { points, triangles, edges: vec![], holes: vec![] }
}
