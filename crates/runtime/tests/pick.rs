//! Picking, with parry3d as the judge.

use crate::support::rig::Rig;
use crate::support::{self, curtain, scene, tube, two_charts};
use gimage_runtime::*;
use parry3d_f64::math::Vector;
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::TriMesh;

/// xorshift32, -1 to 1.
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 as f32 / u32::MAX as f32 * 2.0 - 1.0
    }

    fn ray(&mut self) -> ([f32; 3], [f32; 3]) {
        let origin = [2.0 * self.next(), 2.0 * self.next(), 2.0 + self.next()];
        let at = [0.5 + 0.7 * self.next(), -0.5 + 0.7 * self.next(), 0.1 * self.next()];
        // Of any length.
        (origin, [0, 1, 2].map(|c| 3.0 * (at[c] - origin[c])))
    }
}

/// A curtain with folds, and holes in it where `gone` says.
fn folded() -> Cloth {
    let mut cloth = curtain(24);
    let fold = |p: &[f32; 3]| [p[0], p[1], 0.1 * (9.0 * p[0]).sin() + 0.05 * (7.0 * p[1]).cos()];
    let positions = cloth.positions().iter().map(fold).collect();
    cloth.place(positions).unwrap();
    cloth
}

/// The triangles of one grid without missing particles, in the order of codes.
fn mesh(positions: &[[f32; 4]], n: u32, holes: Option<&[u32]>) -> Option<(TriMesh, Vec<u32>)> {
    let points = positions.iter().map(|p| Vector::new(p[0].into(), p[1].into(), p[2].into())).collect();
    let (mut triangles, mut codes) = (Vec::new(), Vec::new());
    for k in (0..n * (n - 1)).filter(|k| k % n < n - 1) {
        for (bit, corners) in [[k, k + n, k + n + 1], [k, k + n + 1, k + 1]].into_iter().enumerate() {
            if holes.is_none_or(|h| h[k as usize] >> bit & 1 == 0) {
                triangles.push(corners);
                codes.push(2 * k + bit as u32);
            }
        }
    }
    Some((TriMesh::new(points, triangles).ok()?, codes))
}

fn norm(v: [f32; 3]) -> f32 {
    v.iter().map(|x| x * x).sum::<f32>().sqrt()
}

#[test]
fn parry_meets_the_same_triangle() {
    let cloth = folded();
    let mut rig = Rig::cpu(scene(cloth.clone()), &Options::default());
    for cut in [false, true] {
        if cut {
            rig.stepper.cut([0.3, 0.2, 2.0], [-1.0, -1.3, -1.5], [1.6, -0.2, -1.2]).unwrap();
            rig.frame(0.0);
        }
        let positions = rig.positions(0);
        let holes = rig.holes(0);
        let (mesh, codes) = mesh(&positions, 24, holes.as_deref()).unwrap();
        let (mut noise, mut hits, mut edges) = (Noise(3), 0, 0);
        for _ in 0..20_000 {
            let (origin, direction) = noise.ray();
            let length = norm(direction);
            let [o, d] = [origin, direction.map(|x| x / length)].map(|v| Vector::from_array(v.map(f64::from)));
            let there = mesh.cast_local_ray_and_get_normal(&Ray::new(o, d), 1e9, false);
            let here = pick(&cloth, &positions, holes.as_deref(), origin, direction).unwrap();
            // On an edge of the cloth one may meet what the other misses.
            let rim = |hit: &Hit| hit.barycentric.iter().any(|b| *b < 1e-4);
            match (here, there) {
                (None, None) => {}
                (Some(hit), Some(other)) => {
                    hits += 1;
                    let far = f64::from(hit.distance) - other.time_of_impact;
                    // Rounding of both, which a grazing ray makes larger.
                    let most = 4e-6 * f64::from(hit.distance) / other.normal.dot(d).abs();
                    if far.abs() > most {
                        assert!(rim(&hit), "{hit:?} {other:?}");
                        edges += 1;
                        continue;
                    }
                    let point = hit.point();
                    let along = [0, 1, 2].map(|c| origin[c] + direction[c] / length * hit.distance - point[c]);
                    assert!(f64::from(norm(along)) < most, "{hit:?}: {along:?}");
                    assert!((hit.barycentric.iter().sum::<f32>() - 1.0).abs() < 1e-6);
                    let code = 2 * (hit.texel[1] * 24 + hit.texel[0]) + hit.triangle;
                    let same = codes.contains(&code);
                    assert!(same && hit.particles[0] == hit.texel[1] * 24 + hit.texel[0], "{hit:?}");
                }
                (Some(hit), None) => {
                    assert!(rim(&hit), "{hit:?}");
                    edges += 1;
                }
                (None, Some(other)) => panic!("{origin:?} {direction:?} {other:?}"),
            }
        }
        eprintln!("{hits} hits, {edges} on edges");
        assert!(hits > 5_000 && edges < 20, "{hits} hits, {edges} on edges");
    }
}

#[test]
fn a_pick_is_that_of_the_twin() {
    let Some(device) = support::device() else { return };
    let mut many = scene(folded());
    many.cloths.push(tube(17, 12, 4));
    many.cloths.push(two_charts(9));
    let mut rigs = [Rig::cpu(many.clone(), &Options::default()), Rig::gpu(many, &Options::default(), &device)];
    let (mut noise, mut seen) = (Noise(11), [0; 4]);
    for cut in [false, true] {
        if cut {
            for rig in &mut rigs {
                rig.stepper.cut([0.3, 0.2, 2.0], [-1.0, -1.3, -1.5], [1.6, -0.2, -1.2]).unwrap();
                rig.frame(0.0);
            }
        }
        for _ in 0..150 {
            let (origin, direction) = noise.ray();
            let [here, there] = rigs.each_mut().map(|rig| rig.pick(origin, direction));
            match (here, there) {
                (None, None) => seen[3] += 1,
                (Some(a), Some(b)) => {
                    seen[a.cloth] += 1;
                    assert!((a.distance - b.distance).abs() < 1e-5, "{a:?} {b:?}");
                    let off = [0, 1, 2].map(|c| a.point()[c] - b.point()[c]);
                    assert!(norm(off) < 1e-5, "{a:?} {b:?}");
                    // On an edge either triangle will do.
                    let edge = a.barycentric.iter().any(|w| w.abs() < 1e-4);
                    let place = |h: &Hit| (h.cloth, h.grid, h.texel, h.triangle, h.particles, h.corners);
                    assert!(edge || place(&a) == place(&b), "{a:?} {b:?}");
                }
                other => panic!("{origin:?} {direction:?}: {other:?}"),
            }
        }
    }
    eprintln!("{seen:?}");
    assert!(seen.iter().all(|n| *n > 5), "{seen:?}");
}

#[test]
fn no_ray_slips_through_an_edge() {
    for mut rig in Rig::both(&scene(curtain(9)), &Options::default()) {
        // Straight at particles and at the middles of edges and diagonals, where triangles meet.
        for (i, j) in
            (2..15).flat_map(|i| (2..15).map(move |j| (i, j))).step_by(if rig.name() == "gpu" { 7 } else { 1 })
        {
            let at = [i as f32 / 16.0, -(j as f32) / 16.0];
            let hit = rig.pick([at[0], at[1], 1.0], [0.0, 0.0, -1.0]).unwrap();
            assert!((hit.distance - 1.0).abs() < 1e-6 && (hit.point()[0] - at[0]).abs() < 1e-6, "{hit:?}");
        }
        // Both sides, and not behind the origin.
        assert!(rig.pick([0.4, -0.4, -1.0], [0.0, 0.0, 2.0]).is_some());
        assert!(rig.pick([0.4, -0.4, -1.0], [0.0, 0.0, -2.0]).is_none());
        assert!(rig.pick([1.4, -0.4, -1.0], [0.0, 0.0, 2.0]).is_none());
        assert!(rig.pick([0.4, -0.4, 0.0], [1.0, 0.0, 0.0]).is_none(), "a ray within the cloth");
    }
}

#[test]
fn wrong_rays_are_errors() {
    let cloth = curtain(4);
    let stepper = Stepper::new(scene(cloth.clone()), Options::default(), None).unwrap();
    let at = [0.0; 3];
    assert!(stepper.pick(at, at).unwrap_err().to_string().contains("direction"));
    assert!(stepper.pick([f32::NAN; 3], [1.0; 3]).unwrap_err().to_string().contains("finite"));
    assert!(pick(&cloth, &[], None, at, [1.0; 3]).unwrap_err().to_string().contains("16 particles"));
    let positions = stepper.positions(0).unwrap();
    assert!(pick(&cloth, positions, Some(&[0]), at, [1.0; 3]).unwrap_err().to_string().contains("1 holes"));
    assert!(pick(&cloth, positions, None, [0.4, -0.4, 1.0], [0.0, 0.0, -1.0]).unwrap().is_some());
}
