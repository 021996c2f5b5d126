//! Makes neighbours wind the same way.
//!
//! In each component the winding that covers the larger area wins: the author's choice, even where it faces inwards.
//! Only if both cover the same area does the volume decide for a closed component, outwards.

use super::nonmanifold::Gluing;
use super::work::Work;
use crate::base::halfedge::{BOUNDARY, origin};
use crate::base::vec3::{cross, dot, sub};
use crate::base::words;
use crate::record::Severity;

/// Areas closer than this share of their sum count as equal.
const TIE: f64 = 1e-9;

/// Orients every component. The half-edges of `gluing` mean nothing afterwards. O(n).
pub(super) fn orient(work: &mut Work, gluing: &Gluing) {
    let n = work.len();
    let (mut turned, mut seen) = (vec![false; n], vec![false; n]);
    let (mut flips, mut queue) = (Vec::new(), Vec::new());
    let mut twisted: Vec<String> = Vec::new();
    let mut twisted_count = 0;
    for start in 0..n {
        if seen[start] {
            continue;
        }
        queue.clear();
        queue.push(start as u32);
        let Sides { closed, orientable } = walk(work, gluing, &mut queue, &mut seen, &mut turned);
        if other_way(work, &queue, &turned, closed && orientable) {
            queue.iter().for_each(|&t| turned[t as usize] ^= true);
        }
        if orientable {
            flips.extend(queue.iter().copied().filter(|&t| turned[t as usize]));
        } else {
            twisted_count += 1;
            twisted.push(format!("{} from {}", words::triangles(queue.len()), work.triangle_words(start)));
        }
    }
    flips.sort_unstable();
    for t in (0..n).filter(|&t| turned[t]) {
        work.reverse(t);
    }
    let examples = flips.iter().take(4).map(|&t| work.triangle_words(t as usize)).collect();
    let message = format!("{} flipped to match the winding of most of the piece", words::triangles(flips.len()));
    work.report(Severity::Repair, "flipped-faces", flips.len(), examples, message);
    let pieces = words::counted(twisted_count, "piece that is", "pieces that are");
    let message = format!("{pieces} not orientable will be cut across");
    work.report(Severity::Note, "not-orientable", twisted_count, twisted, message);
}

/// The triangles of components with one side, as strips with a half twist. O(n).
pub(super) fn one_sided(work: &Work, gluing: &Gluing) -> Vec<bool> {
    let n = work.len();
    let (mut turned, mut seen, mut out, mut queue) = (vec![false; n], vec![false; n], vec![false; n], Vec::new());
    for start in 0..n as u32 {
        if !seen[start as usize] {
            queue.clear();
            queue.push(start);
            let one = !walk(work, gluing, &mut queue, &mut seen, &mut turned).orientable;
            queue.iter().for_each(|t| out[*t as usize] = one);
        }
    }
    out
}

/// The findings of a walk over a component.
struct Sides {
    closed: bool,
    orientable: bool,
}

/// Walks over the component of the triangle in `queue`, to which it adds the others, and finds which have to turn to wind as that one does.
fn walk(work: &Work, gluing: &Gluing, queue: &mut Vec<u32>, seen: &mut [bool], turned: &mut [bool]) -> Sides {
    seen[queue[0] as usize] = true;
    let (mut next, mut closed, mut orientable) = (0, true, true);
    while let Some(&t) = queue.get(next) {
        next += 1;
        let (triangles, around) = (&work.mesh.triangles, [3 * t, 3 * t + 1, 3 * t + 2]);
        let mut across = around.map(|h| (gluing.twin[h as usize], h));
        // By triangle: where a piece is one-sided the tree decides, and must not depend on the corners' order.
        across.sort_unstable_by_key(|x| x.0 / 3);
        for (g, h) in across {
            if g == BOUNDARY {
                closed = false;
                continue;
            }
            let same_way = origin(triangles, h) == origin(triangles, g);
            let (u, turn) = (g as usize / 3, turned[t as usize] != same_way);
            if !seen[u] {
                (seen[u], turned[u]) = (true, turn);
                queue.push(u as u32);
            } else {
                orientable &= turned[u] == turn;
            }
        }
    }
    Sides { closed, orientable }
}

/// Whether the turned triangles outweigh the others.
fn other_way(work: &Work, component: &[u32], turned: &[bool], closed: bool) -> bool {
    if component.iter().all(|&t| !turned[t as usize]) {
        return false;
    }
    let (mut keep, mut turn) = (0.0, 0.0);
    for &t in component {
        *if turned[t as usize] { &mut turn } else { &mut keep } += work.mesh.triangle_area(t as usize);
    }
    if (turn - keep).abs() > TIE * (turn + keep) {
        return turn > keep;
    }
    if !closed {
        return false;
    }
    let base = work.mesh.corners(component[0] as usize)[0];
    let volume: f64 = component
        .iter()
        .map(|&t| {
            let [a, b, c] = work.mesh.corners(t as usize).map(|p| sub(p, base));
            let v = dot(a, cross(b, c));
            if turned[t as usize] { -v } else { v }
        })
        .sum();
    volume < 0.0
}

#[cfg(test)]
mod tests {
    use super::super::nonmanifold::glue;
    use super::*;
    use crate::base::mesh::{Channel, Mesh, Semantic};

    #[test]
    fn the_larger_area_wins_and_corners_follow() {
        let positions = vec![[0., 0., 0.], [1., 0., 0.], [1., 3., 0.], [0., 3., 0.], [-1., 0., 0.]];
        let triangles = vec![[0, 3, 4], [0, 1, 2], [0, 2, 3]];
        let corners = (0..9).collect();
        let channel = Channel { semantic: Semantic::TexCoord(0), width: 2, values: vec![0.0; 18], corners };
        let mut w = Work::new(Mesh { positions, triangles, channels: vec![channel], ..Default::default() });
        w.mesh.triangles[0] = [0, 4, 3];
        let g = glue(&w, &Default::default());
        orient(&mut w, &g);
        assert_eq!(w.mesh.triangles, [[0, 3, 4], [0, 1, 2], [0, 2, 3]]);
        assert_eq!(w.mesh.channels[0].corners, [0, 2, 1, 3, 4, 5, 6, 7, 8]);
        assert_eq!((w.findings[0].kind, w.findings[0].count), ("flipped-faces", 1));
    }

    #[test]
    fn an_even_split_of_a_closed_piece_faces_outwards() {
        let positions = vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0.5, 0.5, 1.], [0.5, 0.5, -1.]];
        let up = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
        let down = [[1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]];
        for flip_up in [true, false] {
            let mut triangles: Vec<[u32; 3]> = up.iter().chain(&down).copied().collect();
            for t in if flip_up { 0..4 } else { 4..8 } {
                triangles[t].swap(1, 2);
            }
            let mut w = Work::new(Mesh { positions: positions.clone(), triangles, ..Default::default() });
            let g = glue(&w, &Default::default());
            orient(&mut w, &g);
            let p = w.mesh.corners(0);
            assert!(dot(cross(sub(p[1], p[0]), sub(p[2], p[0])), [0.0, -1.0, 0.3]) > 0.0, "{p:?}");
        }
    }

    #[test]
    fn a_moebius_strip_is_noted_and_stays() {
        let positions = (0..6).map(|i| [f64::from(i), f64::from(i * i), f64::from(i % 2)]).collect();
        let triangles = vec![[0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 0], [4, 0, 1]];
        let mut w = Work::new(Mesh { positions, triangles, ..Default::default() });
        let g = glue(&w, &Default::default());
        orient(&mut w, &g);
        assert_eq!(w.findings.last().unwrap().kind, "not-orientable");
    }
}
