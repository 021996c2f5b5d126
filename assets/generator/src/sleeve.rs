//! A sleeve on an arm of three joints, with two animations: a tube as it is cut, without a drape.

use crate::glb::{Between, Clip, Joint, Scene, Skin, Track, write};
use crate::math::{PI, cos, sin};
use crate::surface::Surface;

/// Columns around the arm and rows along it; the last column is the first one again.
const AROUND: usize = 24;
const ALONG: usize = 24;
const RADIUS: f64 = 0.08;
/// Heights of the shoulder and of the arm, and where the sleeve begins and ends along x.
const HEIGHT: f64 = 1.4;
const FROM: f64 = 0.2;
const TO: f64 = 0.7;

/// The file. The arm points along x; joints are at both ends of the sleeve and in its middle.
pub fn sleeve() -> Vec<u8> {
    let s = tube();
    let (indices, weights) = s.positions.iter().map(|p| weigh(f64::from(p[0]))).unzip();
    let clips = vec![swing(), pull()];
    let scene = Scene {
        name: "sleeve",
        material: ("blue linen", [0.10, 0.22, 0.45]),
        short_indices: true,
        parent: None,
        pin: None,
        colours: None,
        skin: Some(Skin { joints: joints(), indices, weights, clips }),
    };
    write(&s, &scene)
}

fn joints() -> Vec<Joint> {
    let at = |x: f64| [x as f32, HEIGHT as f32, 0.0];
    vec![
        Joint { name: "shoulder", parent: None, at: at(FROM) },
        Joint { name: "elbow", parent: Some(0), at: at((FROM + TO) / 2.0) },
        Joint { name: "wrist", parent: Some(1), at: at(TO) },
    ]
}

/// Linear from joint to joint.
fn weigh(x: f64) -> ([u8; 4], [f32; 4]) {
    let along = (2.0 * (x - FROM) / (TO - FROM)).clamp(0.0, 2.0);
    let weight = |n: f64| (1.0 - (along - n).abs()).max(0.0) as f32;
    let [a, c] = [weight(0.0), weight(2.0)];
    ([0, 1, 2, 0], [a, 1.0 - a - c, c, 0.0])
}

fn tube() -> Surface {
    let side = (2.0 * PI * RADIUS).max(TO - FROM);
    let mut s = Surface { metres_per_uv: side, ..Surface::default() };
    for j in 0..=ALONG {
        for i in 0..=AROUND {
            let angle = 2.0 * PI * (i % AROUND) as f64 / AROUND as f64;
            let (y, z) = (cos(angle), sin(angle));
            let x = FROM + (TO - FROM) * j as f64 / ALONG as f64;
            let grid = |c: f64| ((c * 1e5).round() / 1e5) as f32;
            s.positions.push([grid(x), grid(HEIGHT + RADIUS * y), grid(RADIUS * z)]);
            s.normals.push([0.0, y as f32, z as f32]);
            let (u, v) = (i as f64 / AROUND as f64 * 2.0 * PI * RADIUS, j as f64 / ALONG as f64 * (TO - FROM));
            s.uvs.push([(u / side) as f32, (1.0 - v / side) as f32]);
            s.particle.push(j * AROUND + i % AROUND);
        }
    }
    let at = |i: usize, j: usize| (j * (AROUND + 1) + i) as u32;
    for (i, j) in (0..ALONG).flat_map(|j| (0..AROUND).map(move |i| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        s.indices.extend([a, b, c, a, c, d]);
    }
    s
}

/// A second in which the arm goes down and up again, linear from key to key, and bends and stretches along a spline.
fn swing() -> Clip {
    let about = |axis: usize, angle: f64| {
        let mut q = [0.0f32; 4];
        (q[axis], q[3]) = (sin(angle / 2.0) as f32, cos(angle / 2.0) as f32);
        q
    };
    let shoulder: Vec<f32> = [0.0, -0.5, -0.8, -0.5, 0.0].iter().flat_map(|a| about(2, *a)).collect();
    let still = [0.0f32; 4];
    let elbow: Vec<f32> = [0.0, -1.2, 0.0].iter().flat_map(|a| [still, about(1, *a), still]).flatten().collect();
    Clip {
        name: "swing",
        tracks: vec![
            track(0, "rotation", Between::Linear, &[0.0, 0.25, 0.5, 0.75, 1.0], shoulder),
            track(1, "rotation", Between::Cubic, &[0.0, 0.5, 1.0], elbow),
        ],
    }
}

/// The wrist is 3 cm farther out from half a second on, and the elbow grows to 1.2 times its size.
fn pull() -> Clip {
    let half = ((TO - FROM) / 2.0) as f32;
    let wrist = vec![half, 0.0, 0.0, half + 0.03, 0.0, 0.0];
    Clip {
        name: "pull",
        tracks: vec![
            track(2, "translation", Between::Step, &[0.0, 0.5], wrist),
            track(1, "scale", Between::Linear, &[0.0, 1.0], [[1.0f32; 3], [1.2; 3]].concat()),
        ],
    }
}

fn track(joint: usize, path: &'static str, between: Between, times: &[f32], values: Vec<f32>) -> Track {
    Track { joint, path, between, times: times.to_vec(), values }
}
