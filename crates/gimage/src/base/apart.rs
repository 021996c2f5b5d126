//! Parts that lie far from all others, as in files whose nodes have several units or places.

use super::mesh::Mesh;
use super::stray::{Bounds, diagonal, widen};
use super::vec3::norm;

/// A part is apart if it is farther from the others than this many diagonals of the larger of both boxes.
const FAR: f64 = 4.0;

/// Parts with triangles that are apart from the one with the most triangles, and from all that lie near it or near those: each with its box
/// and its distance \[m\] from the box around all that is near. In ascending order. Of two passes over the parts, the second
/// widens the box fourfold or is the last, so they are few.
pub(crate) fn apart(mesh: &Mesh) -> Vec<(u32, Bounds, f64)> {
    let mut boxes: Vec<(usize, Option<Bounds>)> = vec![(0, None); mesh.parts.len()];
    for (triangle, part) in mesh.triangles.iter().zip(&mesh.triangle_part) {
        let Some((count, all)) = boxes.get_mut(*part as usize) else { return Vec::new() };
        *count += 1;
        triangle.iter().for_each(|v| widen(all, mesh.positions[*v as usize]));
    }
    let most = boxes.iter().enumerate().max_by_key(|(k, (count, _))| (*count, usize::MAX - k)).map(|(k, _)| k);
    let Some((first, mut near)) = most.and_then(|k| Some((k, boxes[k].1?))) else { return Vec::new() };
    let others = boxes.iter().enumerate().filter(|(k, _)| *k != first);
    let mut far: Vec<(u32, Bounds)> = others.filter_map(|(k, (_, all))| Some((k as u32, (*all)?))).collect();
    loop {
        let before = far.len();
        far.retain(|(_, part)| {
            let stays = gap(near, *part) > FAR * diagonal(near).max(diagonal(*part));
            if !stays {
                near = join(near, *part);
            }
            stays
        });
        if far.len() == before {
            return far.into_iter().map(|(k, part)| (k, part, gap(near, part))).collect();
        }
    }
}

/// The distance between two boxes.
fn gap(a: Bounds, b: Bounds) -> f64 {
    norm([0, 1, 2].map(|k| (b.0[k] - a.1[k]).max(a.0[k] - b.1[k]).max(0.0)))
}

fn join(a: Bounds, b: Bounds) -> Bounds {
    ([0, 1, 2].map(|k| a.0[k].min(b.0[k])), [0, 1, 2].map(|k| a.1[k].max(b.1[k])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::mesh::Part;

    /// Parts, each by its number of triangles, its place on the x axis and its size.
    fn parts(all: &[(usize, f64, f64)]) -> Mesh {
        let mut mesh = Mesh::default();
        for (part, (count, at, side)) in all.iter().enumerate() {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend([[*at, 0.0, 0.0], [at + side, 0.0, 0.0], [*at, *side, 0.0]]);
            mesh.triangles.extend(vec![[first, first + 1, first + 2]; *count]);
            mesh.triangle_part.extend(vec![part as u32; *count]);
            mesh.parts.push(Part::default());
        }
        mesh
    }

    fn far(all: &[(usize, f64, f64)]) -> Vec<u32> {
        apart(&parts(all)).iter().map(|(part, ..)| *part).collect()
    }

    #[test]
    fn a_button_in_another_unit_is_apart_and_a_row_of_garments_is_not() {
        assert_eq!(far(&[(2, 100.0, 2.0), (50, 0.0, 0.8)]), [0]);
        // The same where the garment comes first, or where it consists of two parts.
        assert_eq!(far(&[(50, 0.0, 0.8), (2, 100.0, 2.0), (1, 1.0, 0.3)]), [1]);
        assert_eq!(far(&[(9, 0.0, 1.0), (9, 3.0, 1.0), (9, 6.0, 1.0), (9, 20.0, 1.0)]), [0; 0]);
        assert_eq!(
            [far(&[]), far(&[(3, 5.0, 1.0)]), far(&[(0, 5.0, 1.0), (1, 0.0, 1.0)])],
            [const { Vec::<u32>::new() }; 3]
        );
        // Many near ones reach further.
        assert_eq!(far(&[(9, 0.0, 1.0), (1, 7.0, 1.0), (1, 5.0, 1.0), (1, 200.0, 1.0)]), [3]);
        let (_, bounds, gap) = apart(&parts(&[(9, 0.0, 1.0), (1, 100.0, 2.0)]))[0];
        assert_eq!((bounds.0[0], bounds.1[0], gap), (100.0, 102.0, 99.0));
    }
}
