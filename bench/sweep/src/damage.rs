//! Garments damaged on purpose, by kind of damage, number and seed.

use std::collections::BTreeMap;

use crate::random::Random;
use crate::shape::Shape;

/// Damages a mesh by a strength 0..=1.
type Harm = fn(&mut Random, f64, Shape) -> Shape;

/// Every kind of damage by name.
pub const KINDS: [(&str, Harm); 8] = [
    ("bridge", bridge),
    ("delete", delete),
    ("double", double),
    ("fold", fold),
    ("scale", scale),
    ("spike", spike),
    ("weld", weld),
    ("several", several),
];

/// The name of mesh `k`: its damage, its garment and its number.
pub fn name(k: usize, parts: &[(String, Shape)]) -> String {
    let part = parts.get((k / KINDS.len()) % parts.len().max(1)).map_or("none", |p| p.0.as_str());
    format!("{}-{part}-{k:04}", KINDS[k % KINDS.len()].0)
}

/// Mesh `k`: kinds take turns, then garments, and within both the strength is drawn.
pub fn mesh(seed: u64, k: usize, parts: &[(String, Shape)]) -> (String, Shape) {
    let mut r = Random::new(seed, k as u64);
    let harm = KINDS[k % KINDS.len()].1;
    let Some((_, shape)) = parts.get((k / KINDS.len()) % parts.len().max(1)) else {
        return (name(k, parts), Shape::default());
    };
    let strength = r.unit();
    (name(k, parts), harm(&mut r, strength, shape.clone()))
}

fn between(t: f64, low: f64, high: f64) -> f64 {
    low * (high / low).powf(t)
}

/// A vertex, and those within `radius` of it.
fn around(r: &mut Random, s: &Shape, radius: f64) -> Vec<usize> {
    let Some(&p) = s.positions.get(r.below(s.positions.len())) else { return Vec::new() };
    let near = |q: &[f64; 3]| (0..3).map(|c| (q[c] - p[c]).powi(2)).sum::<f64>().sqrt() <= radius;
    (0..s.positions.len()).filter(|&v| near(&s.positions[v])).collect()
}

/// One to twenty vertices pulled 0.01 to 1,000 diagonals away.
fn spike(r: &mut Random, t: f64, mut s: Shape) -> Shape {
    let far = between(t, 0.01, 1000.0) * s.diagonal();
    for _ in 0..1 + r.below(20) {
        let (k, d) = (r.below(s.positions.len()), r.direction());
        (0..3).for_each(|c| s.positions[k][c] += far * d[c]);
    }
    s
}

/// The part beyond a plane turned over onto the rest.
fn fold(r: &mut Random, t: f64, s: Shape) -> Shape {
    let (n, p) = (r.direction(), s.positions[r.below(s.positions.len())]);
    // Nearly flat on the rest, or in it: what is between is as thin as the strength says.
    let back = 2.0 - between(t, 1e-9, 0.2);
    s.moved(|q| {
        let d: f64 = (0..3).map(|c| n[c] * (q[c] - p[c])).sum();
        if d > 0.0 { [0, 1, 2].map(|c| q[c] - back * d * n[c]) } else { q }
    })
}

/// Vertices joined: any two, or all that lie in cells of a lattice in a part of the mesh.
fn weld(r: &mut Random, t: f64, mut s: Shape) -> Shape {
    let mut to: Vec<u32> = (0..s.positions.len() as u32).collect();
    if r.chance(0.5) {
        for _ in 0..between(t, 1.0, 200.0) as usize {
            let (a, b) = (r.below(to.len()), r.below(to.len()));
            to[a] = to[b];
        }
    } else {
        // Cells of 1 to 10 edges.
        let [p, q, _] = s.triangles[r.below(s.triangles.len())].map(|v| s.positions[v as usize]);
        let edge = (0..3).map(|c| (q[c] - p[c]).powi(2)).sum::<f64>().sqrt().max(1e-4 * s.diagonal());
        let size = edge * between(t, 1.0, 10.0);
        let mut cell: BTreeMap<[i64; 3], u32> = BTreeMap::new();
        for v in around(r, &s, 0.3 * s.diagonal()) {
            let key = s.positions[v].map(|x| (x / size).floor() as i64);
            to[v] = *cell.entry(key).or_insert(v as u32);
        }
    }
    s.triangles.iter_mut().for_each(|t| *t = t.map(|v| to[v as usize]));
    s.triangles.retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
    s.compacted()
}

/// 1 to 100 triangles between vertices that have nothing to do with one another.
fn bridge(r: &mut Random, t: f64, mut s: Shape) -> Shape {
    let n = s.positions.len();
    for _ in 0..between(t, 1.0, 100.0) as usize {
        // From an edge, or from anywhere.
        let [a, b, _] = s.triangles[r.below(s.triangles.len())];
        let far = r.below(n) as u32;
        let other = if r.chance(0.5) { b } else { r.below(n) as u32 };
        if a != other && other != far && far != a {
            s.triangles.push([other, a, far]);
        }
    }
    s
}

/// Triangles taken away: 0.1 to 60 % of them anywhere, or all in a few places.
fn delete(r: &mut Random, t: f64, mut s: Shape) -> Shape {
    if r.chance(0.5) {
        let share = between(t, 1e-3, 0.6);
        s.triangles.retain(|_| !r.chance(share));
    } else {
        for _ in 0..1 + r.below(10) {
            let radius = s.diagonal() * between(t, 0.01, 0.2);
            let gone = around(r, &s, radius);
            s.triangles.retain(|t| t.iter().all(|&v| gone.binary_search(&(v as usize)).is_err()));
        }
    }
    s.compacted()
}

/// The whole scaled along one axis, or a part about its centre, by 1e-6 to 1e3.
fn scale(r: &mut Random, t: f64, mut s: Shape) -> Shape {
    let factor = between(t, 1e-6, 1e3);
    if r.chance(0.5) {
        let axis = r.below(3);
        return s.moved(|mut p| {
            p[axis] *= factor;
            p
        });
    }
    let radius = s.diagonal() * r.within(0.02, 0.4);
    let part = around(r, &s, radius);
    let centre = [0, 1, 2].map(|c| part.iter().map(|&v| s.positions[v][c]).sum::<f64>() / part.len().max(1) as f64);
    for &v in &part {
        (0..3).for_each(|c| s.positions[v][c] = centre[c] + factor * (s.positions[v][c] - centre[c]));
    }
    s
}

/// A part of the surface twice: in the same place or 1e-9 to 1e-2 diagonals beside it, in either winding.
fn double(r: &mut Random, t: f64, mut s: Shape) -> Shape {
    let radius = s.diagonal() * between(t, 0.02, 2.0);
    let part = around(r, &s, radius);
    let (gap, turned) = (if r.chance(0.4) { 0.0 } else { s.diagonal() * r.log(1e-9, 1e-2) }, r.chance(0.5));
    let d = r.direction();
    let inside = |t: &&[u32; 3]| t.iter().all(|&v| part.binary_search(&(v as usize)).is_ok());
    let triangles = s.triangles.iter().filter(inside).map(|&[a, b, c]| if turned { [b, a, c] } else { [a, b, c] });
    let copy = Shape { positions: s.positions.clone(), triangles: triangles.collect() }.compacted();
    s.join(&copy.moved(|p| [0, 1, 2].map(|c| p[c] + gap * d[c])));
    s
}

/// Two to four kinds of damage, one after the other.
fn several(r: &mut Random, t: f64, mut s: Shape) -> Shape {
    for _ in 0..2 + r.below(3) {
        if s.triangles.len() > 10 {
            let (harm, weaker) = (KINDS[r.below(KINDS.len() - 1)].1, t * r.unit());
            s = harm(r, weaker, s);
        }
    }
    s
}

#[cfg(test)]
mod tests {
    use super::*;
    use gimage::topology::Topology;

    fn parts() -> Vec<(String, Shape)> {
        let tube = Shape::tube(24, 24, |a, v| [0.3 * a.cos(), v, 0.3 * a.sin()]);
        vec![("tube".into(), tube), ("ball".into(), Shape::sphere(20, 20, |_| 0.5))]
    }

    fn all(kind: &str) -> Vec<Shape> {
        let first = KINDS.iter().position(|k| k.0 == kind).unwrap();
        (0..40).map(|k| mesh(7, first + k * KINDS.len(), &parts()).1).collect()
    }

    #[test]
    fn the_same_seed_gives_the_same_damage() {
        for k in 0..2 * KINDS.len() {
            assert_eq!(mesh(3, k, &parts()), mesh(3, k, &parts()));
        }
        assert_ne!(mesh(3, 5, &parts()).1, mesh(4, 5, &parts()).1);
    }

    #[test]
    fn every_kind_does_the_damage_of_its_name() {
        let (tube, ball) = (parts()[0].1.clone(), parts()[1].1.clone());
        let plain = |k: usize| if k.is_multiple_of(2) { &tube } else { &ball };
        let each = |kind: &str, test: &dyn Fn(&Shape, &Shape) -> bool| {
            let hits = all(kind).iter().enumerate().filter(|(k, s)| test(s, plain(*k))).count();
            assert!(hits >= 30, "{kind}: {hits} of 40");
        };
        each("spike", &|s, p| s.diagonal() > 1.005 * p.diagonal());
        each("delete", &|s, p| s.triangles.len() < p.triangles.len());
        each("double", &|s, p| s.triangles.len() > p.triangles.len());
        each("bridge", &|s, _| Topology::of(&s.triangles).non_manifold_edges > 0);
        each("weld", &|s, p| s.positions.len() < p.positions.len());
        each("fold", &|s, p| s.triangles == p.triangles && s.positions != p.positions);
        each("scale", &|s, p| s.triangles == p.triangles && s.positions != p.positions);
        each("several", &|s, p| s != p);
    }

    #[test]
    fn every_index_is_of_a_vertex() {
        for k in 0..20 * KINDS.len() {
            let (name, s) = mesh(1, k, &parts());
            assert!(s.triangles.iter().flatten().all(|&v| (v as usize) < s.positions.len()), "{name}");
            assert!(s.positions.iter().flatten().all(|x| x.is_finite()), "{name}");
        }
        assert!(mesh(1, 0, &[]).1.triangles.is_empty());
    }
}
