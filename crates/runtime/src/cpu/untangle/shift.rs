//! How points move so that contours become shorter and vanish, and which of them are loose.

use super::Untangle;
use super::contour::Contour;
use super::loose;
use super::net::Net;
use super::pierce::Hit;
use super::side::{Flood, Verdict, verdict};
use crate::number::real::{V3, add, cross, dot, scale, sub};

/// Way of a point in a step, as a share of the distance of neighbours.
const STEP_SHARE: f64 = 0.05;
/// Rings of points from a contour on that move with it on the wrong side.
const MOVED_RINGS: usize = 8;

/// Directions in which a point is asked to move.
#[derive(Clone, Copy, Default)]
struct Wish {
    sum: V3<f64>,
    count: f64,
}

/// Finds the moves of all points, and those that are loose.
pub fn run(of: &mut Untangle, hits: &[Hit], contours: &[Contour]) {
    let mut wishes = vec![Wish::default(); of.at.len()];
    let mut flood = Flood::new(of, hits);
    for contour in contours {
        match verdict(of, &mut flood, hits, contour) {
            Some(verdict) => pass(of, (&mut wishes, &mut flood), (hits, contour), verdict),
            None => shorten(of, &mut wishes, (hits, contour)),
        }
    }
    let step = STEP_SHARE * of.spacing;
    for ((to, wish), free) in of.moves.iter_mut().zip(&wishes).zip(&of.free) {
        if *free && wish.count > 0.0 {
            *to = scale(wish.sum, step / wish.count);
        }
    }
    loose::run(of, &mut flood, (hits, contours));
}

fn ask(wishes: &mut [Wish], points: &[u32], way: V3<f64>) {
    for point in points {
        let wish = &mut wishes[*point as usize];
        (wish.sum, wish.count) = (add(wish.sum, way), wish.count + 1.0);
    }
}

/// Moves the wrong part of a sheet through the other sheet.
fn pass(
    of: &Untangle,
    (wishes, flood): (&mut [Wish], &mut Flood),
    (hits, contour): (&[Hit], &Contour),
    verdict: Verdict,
) {
    let Verdict { sheet, in_front } = verdict;
    let sign = if in_front { -1.0 } else { 1.0 };
    let number = flood.start(1) + 1;
    let mut ring: Vec<(u32, V3<f64>)> = Vec::new();
    for hit in contour.hits[sheet].iter().map(|n| hits[*n as usize]) {
        let way = scale(normal(of, hit.face), sign);
        let (ends, corners) = (of.net.edges[hit.edge as usize], of.net.faces[hit.face as usize]);
        ask(wishes, &ends, way);
        ask(wishes, &corners, scale(way, -1.0));
        let wrong = if in_front { ends[hit.front] } else { ends[1 - hit.front] };
        if flood.enter(wrong, number) {
            ring.push((wrong, way));
        }
    }
    for hit in contour.hits[1 - sheet].iter().map(|n| hits[*n as usize]) {
        // The normal of the sheet that stays, here at its edge.
        let sum = of.net.faces_at(hit.edge as usize).map(|face| normal(of, face)).fold([0.0; 3], add);
        let way = scale(unit(sum), sign);
        ask(wishes, &of.net.faces[hit.face as usize], way);
        ask(wishes, &of.net.edges[hit.edge as usize], scale(way, -1.0));
    }
    for _ in 0..MOVED_RINGS {
        let mut next = Vec::new();
        for (point, way) in ring {
            for [other, edge] in of.net.around(point) {
                if flood.is_open(*edge) && flood.enter(*other, number) {
                    ask(wishes, &[*other], way);
                    next.push((*other, way));
                }
            }
        }
        ring = next;
    }
}

/// Moves both sheets so that a contour that separates none of them becomes shorter.
fn shorten(of: &Untangle, wishes: &mut [Wish], (hits, contour): (&[Hit], &Contour)) {
    let each = || (0..2).flat_map(|sheet| contour.hits[sheet].iter().map(move |n| (sheet, hits[*n as usize])));
    let along = |sheet: usize| if sheet == 0 { 1.0 } else { -1.0 };
    let whole = each().map(|(sheet, hit)| scale(shortening(&of.net, &of.at, hit), along(sheet))).fold([0.0; 3], add);
    let whole = unit(whole);
    for (sheet, hit) in each() {
        let own = unit(shortening(&of.net, &of.at, hit));
        let way = unit(add(own, scale(whole, along(sheet))));
        ask(wishes, &of.net.edges[hit.edge as usize], way);
        ask(wishes, &of.net.faces[hit.face as usize], scale(way, -1.0));
    }
}

/// The direction in which an edge has to move so that the contour becomes shorter, longer where it does so faster. The end of the contour's line in a
/// face beside the edge moves along the pierced face.
fn shortening(net: &Net, at: &[V3<f64>], hit: Hit) -> V3<f64> {
    let [p, q] = net.edges[hit.edge as usize].map(|k| at[k as usize]);
    let pierced = unit(area(net, at, hit.face));
    let edge = unit(sub(q, p));
    let steep = dot(edge, pierced);
    let mut sum = [0.0; 3];
    for face in net.faces_at(hit.edge as usize) {
        let line = unit(cross(pierced, area(net, at, face)));
        let corners = net.faces[face as usize];
        let Some(apex) = corners.into_iter().find(|k| !net.edges[hit.edge as usize].contains(k)) else { continue };
        let inward = sub(at[apex as usize], p);
        let inward = sub(inward, scale(edge, dot(inward, edge)));
        let line = if dot(line, inward) < 0.0 { scale(line, -1.0) } else { line };
        // An edge that is nearly in the pierced face would move it without limit.
        let bounded = if steep < 0.0 { steep.min(-0.1) } else { steep.max(0.1) };
        sum = add(sum, sub(line, scale(pierced, dot(edge, line) / bounded)));
    }
    sum
}

fn area(net: &Net, at: &[V3<f64>], face: u32) -> V3<f64> {
    let [a, b, c] = net.faces[face as usize].map(|k| at[k as usize]);
    cross(sub(b, a), sub(c, a))
}

/// The unit normal of a face.
fn normal(of: &Untangle, face: u32) -> V3<f64> {
    unit(area(&of.net, &of.at, face))
}

/// A vector of length 1, or 0 for one that has no direction.
fn unit(v: V3<f64>) -> V3<f64> {
    let long = dot(v, v).sqrt();
    if long > 0.0 && long.is_finite() { scale(v, 1.0 / long) } else { [0.0; 3] }
}
