//! A skinned summer dress: bodice with shoulder straps, and a flared skirt.

use crate::body::Body;
use crate::drape::{Drape, drape, smooth};
use crate::glb::{Joint, Scene, Skin, write};
use crate::math::{V2, V3, dot, noise, norm, scale, smoothstep, sub};
use crate::panel::{Edge, Panel, bezier, line, mirror};
use crate::sew::{Garment, sew};
use crate::skirt::{Flare, on_cone, sector};
use crate::surface::surface;

const WAIST_HEIGHT: f64 = 1.09;
/// Half the width of a bodice panel at the waist; the inner edge of the skirt has the same length.
const WAIST_HALF: f64 = 0.193;
const SHAPE: Flare = Flare { half_angle: 0.62, inner: 0.311, outer: 0.871 };

/// The file.
pub fn dress() -> Vec<u8> {
    let g = garment();
    let s = surface(&g);
    let x = |i: &usize| g.x[*i];
    let (indices, weights) = s.particle.iter().map(|i| weigh(x(i))).unzip();
    let colours = s.particle.iter().map(|i| colour(x(i), *i)).collect();
    let scene = Scene {
        name: "dress",
        material: ("printed viscose", [0.9, 0.9, 0.9]),
        short_indices: true,
        parent: None,
        pin: None,
        colours: Some(colours),
        skin: Some(Skin { joints: skeleton(), indices, weights, clips: vec![] }),
    };
    write(&s, &scene)
}

fn garment() -> Garment {
    let body = Body::stand();
    let bodice = |drop: f64, which: &'static str, side: f64| Panel {
        outline: bodice(drop, which),
        holes: vec![],
        place: Box::new(move |p| on_torso(p, side)),
    };
    let skirt = |which: &'static str, side: f64| Panel {
        outline: sector(SHAPE, which),
        holes: vec![],
        place: Box::new(move |p| on_cone(SHAPE, [0.15, 0.115], WAIST_HEIGHT, p, side)),
    };
    let panels = [bodice(0.15, "f", 1.0), bodice(0.09, "b", -1.0), skirt("f", 1.0), skirt("b", -1.0)];
    let mut g = sew(&panels, 0.0225);
    // The strap seams rest on the shoulders from the start; left free they slide off while the skirt settles.
    let pins = g.on_edges("strap");
    let how = Drape {
        body: &body,
        pins: &pins,
        steps: 420,
        bend: 0.35,
        friction: 0.2,
        layer: 0.018,
        gap: 0.006,
        limit: &|_, p| p,
    };
    drape(&mut g, &how);
    smooth(&mut g, 2, &pins);
    g
}

fn bodice(drop: f64, which: &str) -> Vec<Edge> {
    let (right, left) = if which == "f" { ("l", "r") } else { ("r", "l") };
    let (neck, tip, under): (V2, V2, V2) = ([0.080, 1.492], [0.132, 1.478], [0.240, 1.285]);
    let half = |side: &str| {
        vec![
            bezier(
                &format!("side-{side}"),
                [[WAIST_HALF, WAIST_HEIGHT], [WAIST_HALF + 0.004, 1.15], [0.23, 1.21], under],
            ),
            bezier(&format!("arm-{side}-{which}"), [under, [0.165, 1.285], [0.122, 1.38], tip]),
            line(&format!("strap-{side}"), tip, neck),
        ]
    };
    let mut out = vec![line(&format!("waist-{which}"), [-WAIST_HALF, WAIST_HEIGHT], [WAIST_HALF, WAIST_HEIGHT])];
    out.extend(half(right));
    let low = neck[1] - drop * 1.33;
    out.push(bezier(
        &format!("neck-{which}"),
        [neck, [neck[0] - 0.01, low], [0.01 - neck[0], low], [-neck[0], neck[1]]],
    ));
    out.extend(mirror(&half(left), str::to_string));
    out
}

fn on_torso(p: V2, side: f64) -> V3 {
    let across = (p[0] / 0.245).clamp(-1.0, 1.0);
    [side * p[0], p[1], side * (0.02 + 0.14 * (1.0 - across * across).sqrt())]
}

fn skeleton() -> Vec<Joint> {
    let joint = |name, parent, at| Joint { name, parent, at };
    vec![
        joint("hips", None, [0.0, 0.95, 0.0]),
        joint("spine", Some(0), [0.0, 1.08, 0.0]),
        joint("chest", Some(1), [0.0, 1.25, 0.0]),
        joint("neck", Some(2), [0.0, 1.45, 0.0]),
        joint("upper_arm.L", Some(2), [0.165, 1.395, 0.0]),
        joint("upper_arm.R", Some(2), [-0.165, 1.395, 0.0]),
        joint("upper_leg.L", Some(0), [0.0925, 0.88, 0.0]),
        joint("upper_leg.R", Some(0), [-0.0925, 0.88, 0.0]),
    ]
}

/// Where each bone ends.
const TIPS: [V3; 8] = [
    [0.0, 1.08, 0.0],
    [0.0, 1.25, 0.0],
    [0.0, 1.40, 0.0],
    [0.0, 1.55, 0.0],
    [0.37, 1.15, 0.0],
    [-0.37, 1.15, 0.0],
    [0.1125, 0.48, 0.01],
    [-0.1125, 0.48, 0.01],
];

/// The four nearest bones, by the inverse fourth power of the distance.
fn weigh(p: V3) -> ([u8; 4], [f32; 4]) {
    let mut near: Vec<(f64, u8)> = skeleton()
        .iter()
        .zip(TIPS)
        .zip(0..)
        .map(|((j, tip), k)| {
            let a = j.at.map(f64::from);
            let (ab, ap) = (sub(tip, a), sub(p, a));
            let d = norm(sub(ap, scale(ab, (dot(ap, ab) / dot(ab, ab)).clamp(0.0, 1.0))));
            (1.0 / (d * d * d * d), k)
        })
        .collect();
    near.sort_by(|a, b| b.0.total_cmp(&a.0));
    let total: f64 = near[..4].iter().map(|n| n.0).sum();
    let mut w = [0, 1, 2, 3].map(|k| (near[k].0 / total) as f32);
    w[0] = 1.0 - (w[1] + w[2] + w[3]);
    ([0, 1, 2, 3].map(|k| near[k].1), w)
}

/// From saffron at the shoulders to rose at the hem, a little uneven like dyed cloth.
fn colour(p: V3, i: usize) -> [u8; 4] {
    let t = smoothstep(0.5, 1.45, p[1]) + 0.04 * noise(i as u64);
    let mix = |low: f64, high: f64| (low + (high - low) * t).clamp(0.0, 255.0).round() as u8;
    [mix(176.0, 240.0), mix(42.0, 176.0), mix(84.0, 62.0), 255]
}
