//! A T-shirt: front, back and two set-in sleeves.

use crate::body::{ARM, Body, SHOULDER};
use crate::drape::{Drape, drape, smooth};
use crate::glb::{Scene, write};
use crate::math::{PI, V2, V3, add, cos, scale, sin};
use crate::panel::{Edge, Panel, bezier, line, mirror};
use crate::sew::{Garment, sew};
use crate::surface::surface;

/// The neck point, the shoulder point, and the underarm point of the wearer's left half.
const NECK: V2 = [0.088, 1.505];
const TIP: V2 = [0.215, 1.462];
const UNDERARM: V2 = [0.262, 1.235];
/// The side of a panel up to the underarm: the hem, and two control points.
const SIDE: [V2; 3] = [[0.258, 0.80], [0.252, 0.95], [0.248, 1.1]];
const SLEEVE_HALF: f64 = 0.185;

/// The file.
pub fn tshirt() -> Vec<u8> {
    let s = surface(&garment(&Body::figure(), SIDE));
    let material = ("heather cotton", [0.16, 0.34, 0.48]);
    let scene =
        Scene { name: "tshirt", material, short_indices: true, parent: None, pin: None, colours: None, skin: None };
    write(&s, &scene)
}

/// A T-shirt draped over a body; `side` is the side of a panel from the hem to the last control point before the underarm.
pub fn garment(body: &Body, side: [V2; 3]) -> Garment {
    let armhole = armhole("").length();
    let cap = cap_height(armhole);
    let panels = [
        Panel { outline: torso(0.095, "f", side), holes: vec![], place: Box::new(|p| on_torso(p, 1.0)) },
        Panel { outline: torso(0.028, "b", side), holes: vec![], place: Box::new(|p| on_torso(p, -1.0)) },
        Panel { outline: sleeve(cap, ["l-b", "l-f"]), holes: vec![], place: Box::new(move |p| on_arm(p, 1.0)) },
        Panel { outline: sleeve(cap, ["r-f", "r-b"]), holes: vec![], place: Box::new(move |p| on_arm(p, -1.0)) },
    ];
    let mut g = sew(&panels, 0.021);
    let how =
        Drape { body, pins: &[], steps: 420, bend: 0.1, friction: 0.6, layer: 0.018, gap: 0.006, limit: &|_, p| p };
    drape(&mut g, &how);
    smooth(&mut g, 2, &[]);
    g
}

/// The armhole from the underarm up to the shoulder, on the side of positive x.
fn armhole(name: &str) -> Edge {
    bezier(name, [UNDERARM, [0.20, 1.245], [0.192, 1.36], TIP])
}

/// The front or back outline; `which` is "f" or "b".
fn torso(drop: f64, which: &str, [hem, low, high]: [V2; 3]) -> Vec<Edge> {
    // Seen from behind, the wearer's left is on the left.
    let (right, left) = if which == "f" { ("l", "r") } else { ("r", "l") };
    let half = |side: &str| {
        vec![
            bezier(&format!("side-{side}"), [hem, low, high, UNDERARM]),
            armhole(&format!("armhole-{side}-{which}")),
            line(&format!("shoulder-{side}"), TIP, NECK),
        ]
    };
    let dip = hem[1] - 0.012;
    let mut out = vec![bezier(&format!("hem-{which}"), [[-hem[0], hem[1]], [-0.1, dip], [0.1, dip], hem])];
    out.extend(half(right));
    let neck = NECK[1] - drop;
    out.push(bezier(
        &format!("neck-{which}"),
        [NECK, [NECK[0] - 0.012, neck - drop * 0.32], [0.012 - NECK[0], neck - drop * 0.32], [-NECK[0], NECK[1]]],
    ));
    out.extend(mirror(&half(left), str::to_string));
    out
}

/// A sleeve with the underarm at height 0. `sides` names the armholes its right and left halves meet.
fn sleeve(cap: f64, sides: [&str; 2]) -> Vec<Edge> {
    let [right, left] = sides;
    let under = format!("under-{}", &right[..1]);
    let half = crown(cap);
    let mut out = vec![
        line(&format!("cuff-{}", &right[..1]), [-0.17, -0.115], [0.17, -0.115]),
        line(&under, [0.17, -0.115], [SLEEVE_HALF, 0.0]),
        Edge { name: format!("armhole-{right}"), ..half.clone() },
    ];
    out.extend(mirror(&[half], |_| format!("armhole-{left}")));
    out.push(line(&under, [-SLEEVE_HALF, 0.0], [-0.17, -0.115]));
    out
}

/// Half of the sleeve cap, from the underarm to the top.
fn crown(cap: f64) -> Edge {
    bezier("", [[SLEEVE_HALF, 0.0], [SLEEVE_HALF * 0.55, 0.01], [SLEEVE_HALF * 0.5, cap], [0.0, cap]])
}

/// The cap height whose edge is as long as the armhole.
fn cap_height(armhole: f64) -> f64 {
    let (mut low, mut high) = (0.02, 0.35);
    for _ in 0..40 {
        let mid = (low + high) / 2.0;
        if crown(mid).length() < armhole { low = mid } else { high = mid }
    }
    low
}

fn on_torso(p: V2, side: f64) -> V3 {
    let across = p[0] / 0.27;
    [side * p[0], p[1] + 0.03, side * (0.05 + 0.14 * (1.0 - across * across).max(0.0).sqrt())]
}

/// A tube round the arm; `side` is 1 for the left arm.
fn on_arm(p: V2, side: f64) -> V3 {
    let along = [side * ARM[0], ARM[1], 0.0];
    // From the top of the arm, positive panel x runs backwards on the left arm and forwards on the right one.
    let (top, across) = ([-side * ARM[1], ARM[0], 0.0], [0.0, 0.0, -side]);
    let angle = p[0] / SLEEVE_HALF * PI;
    let start = add([side * SHOULDER[0], SHOULDER[1] + 0.02, 0.0], scale(along, 0.12 - p[1]));
    let radius = SLEEVE_HALF / PI + 0.015;
    add(start, add(scale(top, radius * cos(angle)), scale(across, radius * sin(angle))))
}
