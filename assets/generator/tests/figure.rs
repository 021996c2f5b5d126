//! Promises of the figure: a closed body, clothes outside of it, a skeleton, loops, and the bytes in the repository.

mod glb;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;

use gimage_assets::body::Body;
use glb::Glb;

static FILE: LazyLock<Vec<u8>> = LazyLock::new(gimage_assets::figure);
static FIGURE: LazyLock<Glb> = LazyLock::new(|| Glb::read(&FILE));

fn indices(mesh: usize) -> Vec<[usize; 3]> {
    FIGURE.triangles_of(mesh)
}

#[test]
fn the_file_in_the_repository_is_this() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../figure.glb");
    assert!(FILE.len() < 1 << 20);
    let stale = "figure.glb is stale: cargo run -p gimage-assets --bin make-assets -- assets";
    assert!(std::fs::read(path).expect("figure.glb") == *FILE, "{stale}");
}

#[test]
fn the_body_is_closed_and_its_skin_smooth() {
    let triangles = indices(0);
    let mut half = BTreeMap::new();
    for t in &triangles {
        for k in 0..3 {
            assert!(half.insert((t[k], t[(k + 1) % 3]), ()).is_none(), "an edge has three triangles");
        }
    }
    assert!(half.keys().all(|(a, b)| half.contains_key(&(*b, *a))), "the body has a hole");
    let points = FIGURE.floats_of::<3>(0, "POSITION");
    assert_eq!(points.len() + triangles.len() - half.len() / 2, 2, "the Euler number of a ball");
    // Weights of neighbours differ little, so that joints bend smoothly.
    let joints = FIGURE.bytes_of(0, "JOINTS_0").as_chunks::<4>().0;
    let weights = FIGURE.bytes_of(0, "WEIGHTS_0").as_chunks::<4>().0;
    let weight = |v: usize, joint: u8| -> i32 {
        (0..4).filter(|&k| joints[v][k] == joint).map(|k| i32::from(weights[v][k])).sum()
    };
    assert!(weights.iter().all(|w| w.iter().map(|x| u32::from(*x)).sum::<u32>() == 255));
    let jump = half.keys().flat_map(|&(a, b)| joints[a].map(|j| (weight(a, j) - weight(b, j)).abs())).max();
    assert!(jump < Some(200), "{jump:?} of 255 between neighbours");
}

#[test]
fn the_clothes_are_outside_of_the_body() {
    let body = Body::person();
    for mesh in [1, 2] {
        let points = FIGURE.floats_of::<3>(mesh, "POSITION").iter().map(|p| p.map(f64::from)).collect::<Vec<_>>();
        let mut least = f64::INFINITY;
        for t in indices(mesh) {
            let middle = [0, 1, 2].map(|c| t.iter().map(|v| points[*v][c]).sum::<f64>() / 3.0);
            least = t.iter().map(|v| points[*v]).chain([middle]).map(|p| body.distance(p)).fold(least, f64::min);
        }
        assert!(least > 0.002, "mesh {mesh} is {least} m from the body");
    }
}

#[test]
fn the_cape_hangs_behind_the_other_clothes() {
    let file = Glb::read(&gimage_assets::figure_in_cape());
    let body = Body::person();
    let points = |mesh| -> Vec<[f64; 3]> {
        file.floats_of::<3>(mesh, "POSITION").iter().map(|p: &[f32; 3]| p.map(f64::from)).collect()
    };
    let cape = points(3);
    let least = cape.iter().map(|p| body.distance(*p)).fold(f64::INFINITY, f64::min);
    assert!(least > 0.005, "{least} m from the body");
    // No point of T-shirt or skirt lies behind a point of the cape at the same place across.
    for p in points(1).into_iter().chain(points(2)) {
        let beside = cape.iter().filter(|q| (q[0] - p[0]).abs() < 0.01 && (q[1] - p[1]).abs() < 0.01);
        let behind = beside.map(|q| p[2] - q[2]).fold(f64::INFINITY, f64::min);
        assert!(behind > 0.005, "{p:?}: {behind} m in front of the cape");
    }
}

#[test]
fn the_clips_are_loops() {
    let doc = &FIGURE.doc;
    assert_eq!(doc["skins"][0]["joints"].as_array().map(Vec::len), Some(19));
    let clips = doc["animations"].as_array().expect("animations");
    assert_eq!(clips.len(), 3);
    for (clip, (name, seconds)) in clips.iter().zip([("Walk", 2.4), ("Turn", 2.4), ("Sit", 5.0)]) {
        assert_eq!(clip["name"], name);
        for sampler in clip["samplers"].as_array().expect("samplers") {
            let index = |key: &str| sampler[key].as_u64().expect("accessor") as usize;
            let times = FIGURE.accessor::<1>(index("input"));
            assert!((times[times.len() - 1][0] - seconds).abs() < 1e-6);
            let wide = doc["accessors"][index("output")]["type"] == "VEC4";
            let values: Vec<Vec<f32>> = if wide {
                FIGURE.accessor::<4>(index("output")).iter().map(|q| q.to_vec()).collect()
            } else {
                FIGURE.accessor::<3>(index("output")).iter().map(|q| q.to_vec()).collect()
            };
            let (first, last) = (&values[0], &values[values.len() - 1]);
            // A quaternion and its opposite are one rotation.
            let far = |sign: f32| first.iter().zip(last).map(|(a, b)| (a - sign * b).abs()).fold(0.0, f32::max);
            assert!(far(1.0).min(far(-1.0)) < 1e-5, "{name}: {first:?}, then {last:?}");
        }
    }
}
