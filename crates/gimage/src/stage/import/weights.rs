//! Skin weights made sound: joints that exist, weights that sum to 1.

use super::attributes::Attribute;
use super::findings::Findings;
use crate::base::mesh::Semantic;
use crate::record::Severity;

/// How far a sum of weights may be from 1 without a word: four weights in bytes round to within 2 / 255.
const ROUNDING: f64 = 0.01;

/// Makes the joints of a primitive index the skeleton and its weights sum to 1, over all sets together. Without a skin
/// (`map` is `None`) joints mean nothing and are dropped.
pub(crate) fn settle(
    attributes: &mut Vec<Attribute>,
    map: Option<&[u32]>,
    positions: &[[f64; 3]],
    element: &str,
    findings: &mut Findings,
) {
    let (mut joints, mut weights, mut rest) = (Vec::new(), Vec::new(), Vec::new());
    for a in std::mem::take(attributes) {
        match a.semantic {
            Semantic::Joints(n) => joints.push((n, a)),
            Semantic::Weights(n) => weights.push((n, a)),
            _ => rest.push(a),
        }
    }
    *attributes = rest;
    let before = joints.len() + weights.len();
    joints.retain(|(n, _)| weights.iter().any(|(m, _)| m == n));
    weights.retain(|(n, _)| joints.iter().any(|(m, _)| m == n));
    // Sets stand in the same order in both lists, as attributes are read in the order of their semantics.
    let map = map.unwrap_or_default();
    if map.is_empty() || joints.len() + weights.len() < before {
        let message = "Joints and weights that come without each other or without a skin were left out.";
        findings.add(Severity::Note, "joints-without-skin", before.min(1), message, || element.into());
    }
    let (Some(&fallback), false) = (map.first(), joints.is_empty()) else { return };
    let (mut absent, mut uneven, mut empty) = (0, 0, Vec::new());
    for v in 0..positions.len() {
        let mut sum = 0.0;
        for ((_, j), (_, w)) in joints.iter_mut().zip(&mut weights) {
            for k in 4 * v..4 * v + 4 {
                let (joint, weight) = (&mut j.values[k], &mut w.values[k]);
                if !(weight.is_finite() && *weight > 0.0) {
                    *weight = 0.0;
                }
                let whole = *joint >= 0.0 && joint.fract() == 0.0;
                match map.get(*joint as usize).filter(|_| whole) {
                    Some(&new) => *joint = new as f32,
                    None => {
                        absent += usize::from(*weight > 0.0);
                        (*joint, *weight) = (fallback as f32, 0.0);
                    }
                }
                sum += f64::from(*weight);
            }
        }
        if sum <= 0.0 {
            empty.push(v);
            continue;
        }
        uneven += usize::from((sum - 1.0).abs() > ROUNDING);
        for (_, w) in &mut weights {
            w.values[4 * v..4 * v + 4].iter_mut().for_each(|x| *x = (f64::from(*x) / sum) as f32);
        }
    }
    let message = "Weights on joints that the skin does not have were left out.";
    findings.add(Severity::Repair, "joint-out-of-range", absent, message, || element.into());
    let message = "Weights that do not sum to 1 were divided by their sum.";
    findings.add(Severity::Repair, "unnormalised-weights", uneven, message, || element.into());
    if empty.len() == positions.len() {
        let message = "A skinned primitive has no weights; it is treated as rigid.";
        findings.add(Severity::Warning, "no-weights", 1, message, || element.into());
        return;
    }
    let message = "Vertices without weights took those of the nearest vertex that has some.";
    findings.add(Severity::Repair, "zero-weights", empty.len(), message, || format!("{element}, vertex {}", empty[0]));
    for (v, from) in nearest(&empty, positions) {
        for (_, a) in joints.iter_mut().chain(&mut weights) {
            a.values.copy_within(4 * from..4 * from + 4, 4 * v);
        }
    }
    attributes.extend(joints.into_iter().chain(weights).map(|(_, a)| a));
}

/// For each vertex of `empty` (in ascending order) the nearest other vertex, the first among equals. Sweeps along the longest
/// side of the bounding box.
fn nearest(empty: &[usize], positions: &[[f64; 3]]) -> Vec<(usize, usize)> {
    if empty.is_empty() {
        return Vec::new();
    }
    let side = |k: usize| {
        let (lo, hi) = positions.iter().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p[k]), h.max(p[k])));
        hi - lo
    };
    let axis = (0..3).max_by(|&a, &b| side(a).total_cmp(&side(b))).unwrap_or(0);
    let mut full: Vec<usize> = (0..positions.len()).filter(|v| empty.binary_search(v).is_err()).collect();
    full.sort_by(|&a, &b| positions[a][axis].total_cmp(&positions[b][axis]).then(a.cmp(&b)));
    let closest = |&v: &usize| {
        let p = positions[v];
        let start = full.partition_point(|&u| positions[u][axis] < p[axis]);
        let mut best = (f64::INFINITY, usize::MAX);
        let mut look = |u: usize| {
            let along = (positions[u][axis] - p[axis]).abs();
            if along > best.0 {
                return false;
            }
            let d = crate::base::vec3::distance(positions[u], p);
            if (d, u) < best {
                best = (d, u);
            }
            true
        };
        for &u in &full[start..] {
            if !look(u) {
                break;
            }
        }
        for &u in full[..start].iter().rev() {
            if !look(u) {
                break;
            }
        }
        (best.1 != usize::MAX).then_some((v, best.1))
    };
    empty.iter().filter_map(closest).collect()
}
