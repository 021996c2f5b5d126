//! Splits a triangle at a vertex that lies on one of its edges, attributes and all.

use super::work::Work;
use crate::base::mesh::{Channel, NONE, Semantic};

/// Splits triangle `t` at its edge between `a` and `b`, where corner `apex` of triangle `cap` lies, `share` of the way
/// from `a` to `b`. Triangle `t` keeps `a`; returns the index of the new one, which has `b`.
///
/// The new corners take the value the cap has at its apex where the attribute runs on from the cap to `t`, or belongs to
/// the vertex (skin, colours, custom). Across a seam of texture coordinates or normals it is interpolated in `t`.
pub(super) fn split_edge(work: &mut Work, t: usize, [a, b]: [u32; 2], cap: usize, apex: usize, share: f64) -> usize {
    let corner = |t: usize, v: u32| work.mesh.triangles[t].iter().position(|&x| x == v).unwrap_or(0);
    let (ta, tb) = (corner(t, a), corner(t, b));
    let (ca, cb) = (corner(cap, a), corner(cap, b));
    let new = work.duplicate(t);
    let c = work.mesh.triangles[cap][apex];
    work.mesh.triangles[t][tb] = c;
    work.mesh.triangles[new][ta] = c;
    for channel in &mut work.mesh.channels {
        let own = [channel.corners[3 * t + ta], channel.corners[3 * t + tb]];
        let caps = [channel.corners[3 * cap + ca], channel.corners[3 * cap + cb]];
        let at_apex = channel.corners[3 * cap + apex];
        let on_chart = matches!(channel.semantic, Semantic::TexCoord(_) | Semantic::Normal);
        let runs_on = equal(channel, own[0], caps[0]) && equal(channel, own[1], caps[1]);
        let value = if at_apex != NONE && (runs_on || !on_chart) {
            at_apex
        } else if on_chart && own[0] != own[1] && !own.contains(&NONE) {
            interpolate(channel, own, share)
        } else if share <= 0.5 {
            own[0]
        } else {
            own[1]
        };
        channel.corners[3 * t + tb] = value;
        channel.corners[3 * new + ta] = value;
    }
    new
}

/// Whether two indices stand for the same value.
fn equal(channel: &Channel, i: u32, j: u32) -> bool {
    let w = channel.width;
    let at = |k: u32| channel.values.get(k as usize * w..(k as usize + 1) * w);
    i == j || (i != NONE && j != NONE && at(i) == at(j))
}

/// Stores a value between two others; returns its index.
fn interpolate(channel: &mut Channel, [i, j]: [u32; 2], share: f64) -> u32 {
    let w = channel.width;
    let at = |i: u32, k: usize| f64::from(channel.values[i as usize * w + k]);
    let mut value: Vec<f64> = (0..w).map(|k| at(i, k) * (1.0 - share) + at(j, k) * share).collect();
    if channel.semantic == Semantic::Normal {
        let length = value.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length > 0.0 {
            value.iter_mut().for_each(|x| *x /= length);
        }
    }
    channel.values.extend(value.iter().map(|&x| x as f32));
    (channel.values.len() / w - 1) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::mesh::Mesh;

    fn split(second: [u32; 3]) -> Mesh {
        // Triangle 0 is the cap 0 1 2 with 2 a quarter of the way along 0 1; triangle 1 lies across.
        let channel = Channel {
            semantic: Semantic::TexCoord(0),
            width: 2,
            values: [[0., 0.], [1., 0.], [0.3, 0.], [4., 4.], [8., 4.], [6., 0.]].concat(),
            corners: [[0, 1, 2], second].concat(),
        };
        let triangles = vec![[0, 1, 2], [1, 0, 3]];
        let mut w =
            Work::new(Mesh { positions: vec![[0.0; 3]; 4], triangles, channels: vec![channel], ..Default::default() });
        assert_eq!(split_edge(&mut w, 1, [0, 1], 0, 2, 0.25), 2);
        assert_eq!(w.mesh.triangles[1..], [[2, 0, 3], [1, 2, 3]]);
        w.mesh
    }

    #[test]
    fn where_the_attribute_runs_on_the_cap_has_the_value() {
        assert_eq!(split([1, 0, 5]).channels[0].corners[3..], [2, 0, 5, 1, 2, 5]);
    }

    #[test]
    fn across_a_seam_it_is_interpolated() {
        let mesh = split([4, 3, 5]);
        assert_eq!(mesh.channels[0].at(1, 0), Some(&[5.0, 4.0][..]));
        assert_eq!(mesh.channels[0].corners[3..], [6, 3, 5, 4, 6, 5]);
    }
}
