//! The surface of the body, as a bundle has it: the triangles of the file. An image of them would have twice as many texels as they have vertices
//! for an error of 0.2 mm (RMS; 4.7 mm at fingers) on the figure, and a second of work.

mod close;
mod covered;

use std::collections::HashMap;

use gimage_bundle::{Body, DisjointSets};

use crate::base::mesh::{Mesh, Semantic};

/// Share of the sides of triangles that may lie on a border: cuts at the neck and the wrists, but not loose triangles.
const MAX_BORDER: f64 = 0.05;
/// Smallest sum of weights of a vertex that follows joints.
const LEAST_WEIGHT: f32 = 1e-6;

/// The surface of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Its triangles.
    pub body: Body,
    /// Triangles that are left out, as other components of the body cover them.
    pub covered: usize,
    /// Openings that are closed by triangles that the file does not have.
    pub closed: usize,
}

/// The surface of a mesh, all of which is the body; or the reason why it cannot be a collider.
///
/// `left_out` tells which triangles of the mesh it does without; empty for none.
pub(crate) fn surface(mesh: &Mesh, left_out: &[bool]) -> Result<Surface, String> {
    let whole = gathered(mesh, &[])?;
    check(&whole)?;
    let mut body = if left_out.contains(&true) { gathered(mesh, left_out)? } else { whole };
    if body.triangles.is_empty() {
        return Err("it has no triangle".into());
    }
    let closed = close::close(&mut body);
    let count = body.triangles.len();
    covered::drop_covered(&mut body);
    let covered = count - body.triangles.len();
    Ok(Surface { body, covered, closed })
}

/// The triangles of a mesh that have an area, with vertices of one position as one.
fn gathered(mesh: &Mesh, left_out: &[bool]) -> Result<Body, String> {
    let sets: Vec<_> = (0..)
        .map_while(|n| Some((mesh.channel(&Semantic::Joints(n))?, mesh.channel(&Semantic::Weights(n))?)))
        .collect();
    let mut body = Body::default();
    let mut known: HashMap<[u32; 3], u32> = HashMap::new();
    let kept = |t: &usize| !left_out.get(*t).is_some_and(|out| *out);
    for (t, corners) in mesh.triangles.iter().enumerate().filter(|(t, _)| kept(t)) {
        let mut triangle = [0; 3];
        for (c, v) in corners.iter().enumerate() {
            // Vertices of one position are one, of either zero.
            let at = mesh.positions[*v as usize].map(|x| x as f32 + 0.0);
            let next = body.positions.len() as u32;
            triangle[c] = *known.entry(at.map(f32::to_bits)).or_insert(next);
            if triangle[c] == next {
                body.positions.push(at);
                for (joints, weights) in &sets {
                    let joints = joints.at(t, c).and_then(|j| j.first_chunk::<4>()).copied().unwrap_or_default();
                    let weights = weights.at(t, c).and_then(|w| w.first_chunk::<4>()).copied().unwrap_or_default();
                    body.joints.push(joints.map(|j| j as u32));
                    body.weights.push(weights);
                }
            }
        }
        let [a, b, c] = triangle;
        if a != b && b != c && c != a {
            body.triangles.push(triangle);
        }
    }
    normalize(&mut body, sets.len(), mesh.skeleton.joints.len())?;
    Ok(body)
}

/// Makes the weights of each vertex sum to 1, and drops joints that have none.
fn normalize(body: &mut Body, sets: usize, joints: usize) -> Result<(), String> {
    let each = body.joints.chunks_mut(sets.max(1)).zip(body.weights.chunks_mut(sets.max(1)));
    for (joints_of, weights) in each {
        let sum: f32 = weights.iter().flatten().sum();
        if sum.is_nan() || sum <= LEAST_WEIGHT {
            return Err("a part of it follows no joint".into());
        }
        for (joint, weight) in joints_of.iter_mut().flatten().zip(weights.iter_mut().flatten()) {
            *weight /= sum;
            *joint = if *weight > 0.0 { *joint } else { 0 };
            if *joint as usize >= joints {
                return Err("a part of it follows a joint that the skeleton does not have".into());
            }
        }
    }
    Ok(())
}

/// Whether most of it is closed, and faces outwards.
fn check(body: &Body) -> Result<(), String> {
    let mut sides: HashMap<[u32; 2], u32> = HashMap::new();
    let mut parts = DisjointSets::new(body.positions.len());
    for t in &body.triangles {
        for c in 0..3 {
            *sides.entry([t[c], t[(c + 1) % 3]]).or_default() += 1;
        }
        parts.union(t[0], t[1]);
        parts.union(t[0], t[2]);
    }
    let borders = sides.keys().filter(|[a, b]| !sides.contains_key(&[*b, *a])).count();
    let share = borders as f64 / sides.len().max(1) as f64;
    if body.triangles.is_empty() {
        return Err("it has no triangle".into());
    }
    if share > MAX_BORDER {
        return Err(format!("{:.0} % of the sides of its triangles have no neighbour", 100.0 * share));
    }
    let mut middles: HashMap<u32, ([f64; 3], usize)> = HashMap::new();
    for v in body.triangles.iter().flatten() {
        let (sum, count) = middles.entry(parts.find(*v)).or_default();
        let p = body.positions[*v as usize];
        (0..3).for_each(|k| sum[k] += f64::from(p[k]));
        *count += 1;
    }
    // About the middle of the part: where a part is open, the volume about another point is another one.
    let at = |v: u32, (sum, count): ([f64; 3], usize)| {
        [0, 1, 2].map(|k| f64::from(body.positions[v as usize][k]) - sum[k] / count as f64)
    };
    let mut volumes: HashMap<u32, (f64, usize)> = HashMap::new();
    for t in &body.triangles {
        let part = parts.find(t[0]);
        let middle = middles.get(&part).copied().unwrap_or(([0.0; 3], 1));
        let [a, b, c] = t.map(|v| at(v, middle));
        let volume = a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0]);
        let part = volumes.entry(part).or_default();
        (part.0, part.1) = (part.0 + volume, part.1 + 1);
    }
    let inward: usize = volumes.values().filter(|v| v.0 < 0.0).map(|v| v.1).sum();
    match 2 * inward > body.triangles.len() {
        true => Err("most of it faces inwards".into()),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::mesh::{Channel, Joint, Skeleton};

    /// A closed box of two joints, its vertices given once per face.
    fn cube(size: f64) -> Mesh {
        let corner = |k: usize| [0, 1, 2].map(|c| if k >> c & 1 == 1 { size } else { 0.0 });
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let mut mesh = Mesh::default();
        for (n, face) in faces.iter().enumerate() {
            mesh.positions.extend(face.iter().map(|k| corner(*k)));
            let k = 4 * n as u32;
            mesh.triangles.extend([[k, k + 1, k + 2], [k, k + 2, k + 3]]);
        }
        mesh.triangle_part = vec![0; 12];
        mesh.parts = vec![Default::default()];
        let joint = Joint { name: "bone".into(), parent: None, inverse_bind: [0.0; 16], world: [0.0; 16] };
        mesh.skeleton = Skeleton { joints: vec![joint; 2] };
        let corners = vec![0; 36];
        mesh.channels = vec![
            Channel {
                semantic: Semantic::Joints(0),
                width: 4,
                values: vec![1.0, 0.0, 0.0, 7.0],
                corners: corners.clone(),
            },
            Channel { semantic: Semantic::Weights(0), width: 4, values: vec![1.0, 1.0, 0.0, 0.0], corners },
        ];
        mesh
    }

    #[test]
    fn a_closed_body_is_welded_and_its_weights_sum_to_one() {
        let Surface { body, covered, closed } = surface(&cube(1.0), &[]).unwrap();
        assert_eq!((covered, closed), (0, 0));
        assert_eq!((body.positions.len(), body.triangles.len(), body.joints.len()), (8, 12, 8));
        assert_eq!(body.fault(2), None);
        assert!(body.weights.iter().all(|w| *w == [0.5, 0.5, 0.0, 0.0]));
    }

    #[test]
    fn bodies_that_are_no_collider_are_told_apart() {
        let why = |change: &dyn Fn(&mut Mesh)| {
            let mut mesh = cube(1.0);
            change(&mut mesh);
            surface(&mesh, &[]).unwrap_err()
        };
        assert!(why(&|m| m.triangles.truncate(6)).contains("no neighbour"));
        assert!(why(&|m| m.triangles.clear()).contains("no triangle"));
        assert!(why(&|m| m.triangles.iter_mut().for_each(|t| t.swap(0, 1))).contains("inwards"));
        assert!(why(&|m| m.channels[1].values = vec![0.0; 4]).contains("no joint"));
        assert!(why(&|m| m.skeleton.joints.truncate(1)).contains("skeleton"));
    }
}
