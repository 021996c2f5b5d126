//! Where the animations of a file take the points of its meshes.

use std::path::Path;

use super::samples::{barycentric, strongest};
use crate::base::mesh::{Joint, Mesh, Semantic, Skeleton};
use crate::base::scatter::Sampler;
use crate::base::vec3::{add, scale};
use crate::stage::import::{Character, ImportOptions, Matrix, mul, point};

/// Frames per second at which animations are looked at, frames of one at most, and of all.
const RATE: f64 = 12.0;
const OF_ONE: usize = 32;
const OF_ALL: usize = 400;

/// Frames of all animations: for each the transform of each joint, from where meshes are bound to the world.
pub(super) struct Motion {
    pub frames: Vec<Vec<Matrix>>,
}

impl Motion {
    /// Of a file whose meshes follow this skeleton. Animations that do not have its joints, or cannot be read, are left out.
    pub fn new(path: &Path, options: &ImportOptions, skeleton: &Skeleton) -> Self {
        let look = |character: &Character| {
            let nodes = skeleton.joints.iter().map(|j| character.node(&j.name).ok()).collect::<Option<Vec<usize>>>();
            let count = ((character.seconds() * RATE).ceil() as usize).clamp(1, OF_ONE);
            nodes.filter(|nodes| !nodes.is_empty()).map_or((Vec::new(), 0), |nodes| (nodes, count))
        };
        // Counted first, so that no more frames than are looked at are ever in memory.
        let mut total = 0;
        Character::each(path, options, |character| total += look(&character).1);
        let every = total.div_ceil(OF_ALL).max(1);
        let (mut frames, mut first) = (Vec::new(), 0);
        Character::each(path, options, |character| {
            let (nodes, count) = look(&character);
            frames.extend((0..count).filter(|k| (first + k).is_multiple_of(every)).map(|k| {
                let worlds = character.worlds(character.seconds() * k as f64 / count as f64);
                let of = |(node, joint): (&usize, &Joint)| mul(&worlds[*node], &joint.inverse_bind);
                nodes.iter().zip(&skeleton.joints).map(of).collect()
            }));
            first += count;
        });
        Motion { frames }
    }
}

/// Points of a mesh that follow joints.
pub(super) struct Followers {
    /// The joint with the largest weight of each.
    pub joints: Vec<Option<u32>>,
    /// For each the corners of its triangle.
    corners: Vec<[Corner; 3]>,
}

/// A corner of a triangle.
struct Corner {
    /// Its share of a point.
    share: f64,
    /// Where it is bound \[m\].
    at: [f64; 3],
    /// Its joints and their weights.
    joints: Vec<(u32, f64)>,
}

impl Followers {
    /// Points at equal shares of the area; none without an area.
    pub fn new(mesh: &Mesh, count: usize, seed: u64) -> Self {
        let corners: Vec<_> = (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect();
        let sampler = Sampler::new(&corners, count, seed);
        let count = if sampler.area() > 0.0 { count } else { 0 };
        let (mut joints, mut all) = (Vec::new(), Vec::new());
        for (p, t) in (0..count).map(|i| sampler.at(i)) {
            let shares = barycentric(corners[t], p);
            joints.push(strongest(mesh, t, p));
            let corner = |c: usize| Corner { share: shares[c], at: corners[t][c], joints: influences(mesh, t, c) };
            all.push([0, 1, 2].map(corner));
        }
        Followers { joints, corners: all }
    }

    /// Where they are in a frame.
    pub fn at(&self, pose: &[Matrix]) -> Vec<[f64; 3]> {
        let corner = |Corner { share, at, joints }: &Corner| {
            let moved = joints.iter().filter_map(|(j, w)| Some(scale(point(pose.get(*j as usize)?, *at), share * w)));
            moved.fold([0.0; 3], add)
        };
        self.corners.iter().map(|corners| corners.iter().map(corner).fold([0.0; 3], add)).collect()
    }
}

/// The joints of a corner, and their weights, which sum to 1.
fn influences(mesh: &Mesh, t: usize, c: usize) -> Vec<(u32, f64)> {
    let mut out = Vec::new();
    for n in 0.. {
        let channels = (mesh.channel(&Semantic::Joints(n)), mesh.channel(&Semantic::Weights(n)));
        let (Some(joints), Some(weights)) = channels else { break };
        let (Some(joints), Some(weights)) = (joints.at(t, c), weights.at(t, c)) else { continue };
        let each = joints.iter().zip(weights).filter(|(_, w)| **w > 0.0);
        out.extend(each.map(|(j, w)| (*j as u32, f64::from(*w))));
    }
    let sum: f64 = out.iter().map(|(_, w)| w).sum();
    out.iter_mut().for_each(|(_, w)| *w /= sum);
    out
}

#[cfg(test)]
mod tests {
    use base64::Engine;
    use serde_json::json;

    use super::*;
    use crate::stage::import::IDENTITY;

    /// Animations of 4 s in which a joint moves by 4 m along x, and one of another file.
    fn slides(count: usize) -> Vec<Vec<Matrix>> {
        let numbers = [0.0f32, 4.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0];
        let bytes: Vec<u8> = numbers.into_iter().flat_map(f32::to_le_bytes).collect();
        let uri = base64::engine::general_purpose::STANDARD.encode(&bytes);
        let of = |node: usize| {
            json!({
                "channels": [{"sampler": 0, "target": {"node": node, "path": "translation"}}],
                "samplers": [{"input": 0, "output": 1}],
            })
        };
        let file = json!({
            "asset": {"version": "2.0"},
            "buffers": [{"byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{uri}")}],
            "bufferViews": [
                {"buffer": 0, "byteOffset": 0, "byteLength": 8},
                {"buffer": 0, "byteOffset": 8, "byteLength": 24},
            ],
            "accessors": [
                {"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [4]},
                {"bufferView": 1, "componentType": 5126, "count": 2, "type": "VEC3"},
            ],
            "nodes": [{"name": "hip"}],
            "scenes": [{"nodes": [0]}],
            // The last one moves a node that does not exist.
            "animations": (0..count).map(|_| of(0)).chain([of(7)]).collect::<Vec<_>>(),
        });
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("slides.gltf");
        std::fs::write(&path, file.to_string()).unwrap();
        let hip = Joint { name: "hip".into(), parent: None, inverse_bind: IDENTITY, world: IDENTITY };
        let frames = |joints| Motion::new(&path, &ImportOptions::default(), &Skeleton { joints }).frames;
        assert!(frames(vec![Joint { name: "other".into(), ..hip.clone() }]).is_empty());
        frames(vec![hip])
    }

    #[test]
    fn frames_are_evenly_among_all_animations_and_no_more_than_so_many() {
        for (count, every) in [(1, 1), (12, 1), (13, 2), (25, 2), (40, 4)] {
            let frames = slides(count);
            assert_eq!(frames.len(), (OF_ONE * count).div_ceil(every), "{count}");
            for (n, pose) in frames.iter().enumerate() {
                let at = 4.0 * ((every * n) % OF_ONE) as f64 / OF_ONE as f64;
                assert!((pose[0][12] - at).abs() < 1e-6, "{count} animations, frame {n}: {}", pose[0][12]);
            }
        }
    }
}
