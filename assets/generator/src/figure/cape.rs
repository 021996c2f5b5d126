//! A cape for the figure: it hangs from the shoulders behind the other clothes, and ends at the knees.

use super::file::Part;
use super::rig::Rig;
use super::wear::{look, part};
use crate::body::Body;
use crate::drape::{Drape, drape, smooth};
use crate::math::{V2, V3, sin, smoothstep};
use crate::panel::{Edge, Panel, line};
use crate::sew::{Garment, sew};

/// Heights \[m\] of the collar and, as long as the cape is flat, of the hem.
const COLLAR: f64 = 1.43;
const HEM: f64 = 0.50;
/// Half the width \[m\] of the collar and of the hem.
const HALF_TOP: f64 = 0.135;
const HALF_HEM: f64 = 0.34;
/// Distance \[m\] that the cape keeps from what it hangs on.
const GAP: f64 = 0.012;

/// The cape; `below` are the points of the body and of the other clothes.
pub fn cape(rig: &Rig, below: &[V3]) -> Part {
    let g = garment(Back::new(below));
    let weave = |x: usize, y: usize| usize::from((x + y) % 8 < 4);
    part(&g, rig, 20, ("Cape", "loden", look([0.07, 0.16, 0.10], &[[255, 255, 255], [224, 230, 224]], weave)))
}

fn garment(back: Back) -> Garment {
    let body = Body::person_on_stand();
    let place = |p: V2| [p[0], p[1], 0.03 * smoothstep(COLLAR, HEM, p[1]) * sin(26.0 * p[0]) - 0.05];
    let mut g = sew(&[Panel { outline: outline(), holes: vec![], place: Box::new(place) }], 0.0245);
    g.x.iter_mut().for_each(|p| *p = back.behind(*p));
    let pins = g.on_edges("collar");
    let limit = |_: usize, p: V3| back.behind(p);
    let how =
        Drape { body: &body, pins: &pins, steps: 420, bend: 0.5, friction: 0.2, layer: 0.018, gap: GAP, limit: &limit };
    drape(&mut g, &how);
    smooth(&mut g, 3, &pins);
    g.x.iter_mut().for_each(|p| *p = back.behind(*p));
    g
}

/// Seen from behind, counter-clockwise, hem first.
fn outline() -> Vec<Edge> {
    let (left, right) = ([HALF_HEM, HEM], [-HALF_HEM, HEM]);
    let (top_left, top_right) = ([HALF_TOP, COLLAR], [-HALF_TOP, COLLAR]);
    vec![
        line("hem", left, right),
        line("side-r", right, top_right),
        line("collar", top_right, top_left),
        line("side-l", top_left, left),
    ]
}

/// How far back all that is below the cape reaches, over cells of x and y.
struct Back {
    z: Vec<f64>,
}

/// Side \[m\] of a cell, their numbers, and the least x and y.
const CELL: f64 = 0.02;
const COUNT: [usize; 2] = [60, 64];
const LOW: V2 = [-0.6, 0.3];

impl Back {
    fn new(below: &[V3]) -> Self {
        let mut z = vec![f64::INFINITY; COUNT[0] * COUNT[1]];
        for p in below {
            let [x, y] = cell(*p);
            // Triangles reach a cell beyond their corners.
            for (x, y) in (x.saturating_sub(1)..x + 2).flat_map(|x| (y.saturating_sub(1)..y + 2).map(move |y| (x, y))) {
                if x < COUNT[0] && y < COUNT[1] {
                    z[y * COUNT[0] + x] = z[y * COUNT[0] + x].min(p[2]);
                }
            }
        }
        Back { z }
    }

    /// `p`, or the point behind it that is clear of what is below.
    fn behind(&self, p: V3) -> V3 {
        let [x, y] = cell(p).map(|c| c.max(1));
        let (x, y) = (x.min(COUNT[0] - 2), y.min(COUNT[1] - 2));
        let cells = (x - 1..x + 2).flat_map(|x| (y - 1..y + 2).map(move |y| y * COUNT[0] + x));
        let least = cells.map(|k| self.z[k]).fold(f64::INFINITY, f64::min);
        [p[0], p[1], p[2].min(least - GAP)]
    }
}

fn cell(p: V3) -> [usize; 2] {
    [0, 1].map(|c| ((p[c] - LOW[c]) / CELL).max(0.0) as usize)
}
