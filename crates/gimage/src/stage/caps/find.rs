//! Finds caps by their shape, and the bones that pass through them.

use gimage_bundle::DisjointSets;

use super::Cap;
use crate::base::halfedge::{euler, sorted_edges};
use crate::base::mesh::Mesh;
use crate::base::vec3::{add, cross, distance, dot, scale, sub};
use crate::stage::import::bones;

/// Sheets end at edges that are bent by more than this.
pub(super) const SHARP_DEGREES: f64 = 45.0;
/// Share of the area of a component that its largest sheet must have to be the garment.
const GARMENT_SHARE: f64 = 0.5;
/// Least and largest share of the area of a component that a cap may have: more than a button, less than a front.
const CAP_SHARE: [f64; 2] = [0.003, 0.25];
/// The area of the opening that a cap closes, over that of the cap, at least.
const FLAT_SHARE: f64 = 0.45;

/// All caps of a repaired mesh, by their first triangles.
pub(super) fn caps(mesh: &Mesh) -> Vec<Cap> {
    let count = mesh.triangles.len();
    let areas: Vec<f64> = (0..count).map(|t| mesh.triangle_area(t)).collect();
    let normals: Vec<[f64; 3]> = (0..count).map(|t| mesh.facing(t)).collect();
    let edges = sorted_edges(&mesh.triangles);
    let (mut components, mut sheets) = (DisjointSets::new(count), DisjointSets::new(count));
    let cosine = SHARP_DEGREES.to_radians().cos();
    let pairs = || edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)).filter(|run| run.len() == 2);
    for (a, b) in pairs().map(|run| (run[0].2 / 3, run[1].2 / 3)) {
        components.union(a, b);
        let [n, m] = [a, b].map(|t| normals[t as usize]);
        // A triangle without area is of either sheet.
        if dot(n, m) > cosine || n == [0.0; 3] || m == [0.0; 3] {
            sheets.union(a, b);
        }
    }
    let (component, sheet) = (components.into_representatives(), sheets.into_representatives());
    let is_garment = garments(&areas, &component, &sheet);
    let mut closures = DisjointSets::new(count);
    let mut has_hole = vec![false; count];
    for run in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        match run {
            [(_, _, g), (_, _, h)] => {
                let (a, b) = (g / 3, h / 3);
                if !is_garment[a as usize] && !is_garment[b as usize] {
                    closures.union(a, b);
                }
            }
            _ => run.iter().for_each(|(_, _, h)| has_hole[*h as usize / 3] = true),
        }
    }
    let mut lengths = vec![0.0; count];
    for (p, q, a, b) in pairs().map(|run| (run[0].0, run[0].1, run[0].2 / 3, run[1].2 / 3)) {
        let beside = match (is_garment[a as usize], is_garment[b as usize]) {
            (true, false) => b,
            (false, true) => a,
            _ => continue,
        };
        lengths[closures.find(beside) as usize] += distance(mesh.positions[p as usize], mesh.positions[q as usize]);
    }
    let closure = closures.into_representatives();
    let mut whole = vec![0.0; count];
    (0..count).for_each(|t| whole[component[t] as usize] += areas[t]);
    let mut order: Vec<u32> = (0..count as u32).filter(|t| !is_garment[*t as usize]).collect();
    order.sort_by_key(|t| (closure[*t as usize], *t));
    let mut found = Vec::new();
    for triangles in order.chunk_by(|a, b| closure[*a as usize] == closure[*b as usize]) {
        let first = triangles[0] as usize;
        let (area, length) = (triangles.iter().map(|t| areas[*t as usize]).sum::<f64>(), lengths[first]);
        let share = area / whole[component[first] as usize];
        let opening = opening(triangles.iter().map(|t| (areas[*t as usize], normals[*t as usize])));
        let corners: Vec<[u32; 3]> = triangles.iter().map(|t| mesh.triangles[*t as usize]).collect();
        let is_lid = opening >= FLAT_SHARE * area && (CAP_SHARE[0]..=CAP_SHARE[1]).contains(&share);
        if is_lid && !triangles.iter().any(|t| has_hole[*t as usize]) && euler(&corners) == 1 {
            let node = mesh.parts.get(mesh.triangle_part[first] as usize).map(|part| part.node.clone());
            let (node, bone) = (node.unwrap_or_default(), bone_through(mesh, triangles, (&component, first)));
            found.push(Cap { node, triangles: triangles.to_vec(), area, length, bone });
        }
    }
    found
}

/// The area of the opening around triangles, given with their normals: the length of their vector area, which depends on their border alone.
pub(super) fn opening(triangles: impl Iterator<Item = (f64, [f64; 3])>) -> f64 {
    let sum = triangles.fold([0.0; 3], |sum, (area, n)| add(sum, scale(n, area)));
    dot(sum, sum).sqrt()
}

/// Whether each triangle is of the largest sheet of its component, or of a component without caps: one whose largest sheet is too small.
fn garments(areas: &[f64], component: &[u32], sheet: &[u32]) -> Vec<bool> {
    let mut of_sheet = vec![0.0; areas.len()];
    let mut of_component = vec![0.0; areas.len()];
    for (t, area) in areas.iter().enumerate() {
        of_sheet[sheet[t] as usize] += area;
        of_component[component[t] as usize] += area;
    }
    let mut largest: Vec<Option<u32>> = vec![None; areas.len()];
    for t in 0..areas.len() {
        let (own, best) = (sheet[t], &mut largest[component[t] as usize]);
        if best.is_none_or(|best| of_sheet[own as usize] > of_sheet[best as usize]) {
            *best = Some(own);
        }
    }
    let is_garment = |t: usize| {
        let best = largest[component[t] as usize];
        let share = best.map_or(0.0, |best| of_sheet[best as usize] / of_component[component[t] as usize]);
        share < GARMENT_SHARE || best == Some(sheet[t])
    };
    (0..areas.len()).map(is_garment).collect()
}

/// The name of the joint at the end of a bone that passes through some triangles, if the component of the triangle `first` follows one of its joints.
fn bone_through(mesh: &Mesh, triangles: &[u32], (component, first): (&[u32], usize)) -> Option<String> {
    let joints = mesh.followed(|t| component[t] == component[first]);
    let passes = |ends: &[[f64; 3]; 2]| triangles.iter().any(|t| crosses(ends, mesh.corners(*t as usize)));
    let follows = |joint: u32| joints.contains(&joint);
    let bone =
        bones(&mesh.skeleton).into_iter().find(|b| (follows(b.joint) || follows(b.parent)) && passes(&b.ends))?;
    mesh.skeleton.joints.get(bone.joint as usize).map(|joint| joint.name.clone())
}

/// Whether a line passes through a triangle.
fn crosses([from, to]: &[[f64; 3]; 2], [a, b, c]: [[f64; 3]; 3]) -> bool {
    // T. Moeller and B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
    let (along, u, v) = (sub(*to, *from), sub(b, a), sub(c, a));
    let h = cross(along, v);
    let det = dot(u, h);
    if det == 0.0 {
        return false;
    }
    let s = sub(*from, a);
    let q = cross(s, u);
    let (s, t, r) = (dot(s, h) / det, dot(along, q) / det, dot(v, q) / det);
    s >= 0.0 && t >= 0.0 && s + t <= 1.0 && (0.0..=1.0).contains(&r)
}
