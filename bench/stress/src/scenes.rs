//! Random scenes under the default settings: cloth sizes, pins, colliders and speeds. No cloth may stretch or pass a
//! collider without a finding.

use gimage_runtime::{Backend, Collider, Fate, Flat, Options, Result, Scene, Shape, Stepper};

use crate::crew;
use crate::random::Random;

/// Frames of a scene: three seconds.
const FRAMES: u32 = 180;
const FRAME: f32 = 1.0 / 60.0;
/// First frame of which the stretch counts, and frames from one to the next: starts are abrupt on purpose.
const SCORED: [u32; 2] = [60, 4];
/// Extension that one spring in a hundred may have without a finding.
const MAX_P99: f64 = 0.1;
/// Points on the path of a particle in a frame at which it is looked for inside a collider.
const POINTS: u32 = 24;
/// Share of a collider's size: who goes through a core of this size went through.
const CORE: f32 = 0.5;

/// A scene, and the words for it.
struct Made {
    scene: Scene,
    pins: &'static str,
    speed: f32,
}

fn make(k: usize) -> Result<Made> {
    let mut random = Random(77_000 + k as u64);
    let mut between = |low: f64, high: f64| low + (high - low) * random.unit();
    let side = |r: f64| (8.0 * 12f64.powf(r)).round() as u32;
    let (wide, high) = (side(between(0.0, 1.0)), side(between(0.0, 1.0)));
    let size = between(0.3, 1.5) as f32;
    let other = size * (high - 1) as f32 / (wide - 1) as f32;
    let upright = between(0.0, 1.0) < 0.4;
    let down = if upright { [0.0, -other, 0.0] } else { [0.0, 0.0, other] };
    let flat = Flat {
        width: wide,
        height: high,
        origin: [-size / 2.0, 1.0, if upright { 0.0 } else { -other / 2.0 }],
        right: [size, 0.0, 0.0],
        down,
        mass: 0.2 * size * other,
        ..Flat::square("cloth", 2)
    };
    let mut cloth = flat.cloth()?;
    let last = (wide - 1) as usize;
    let pins = match between(0.0, 5.0) as u32 {
        0 => "corner",
        1 => "two corners",
        2 => "row",
        _ => "none",
    };
    let pinned: Vec<usize> = match pins {
        "corner" => vec![0],
        "two corners" => vec![0, last],
        "row" => (0..=last).collect(),
        _ => Vec::new(),
    };
    pinned.into_iter().try_for_each(|k| cloth.set_pinned(k, true))?;
    cloth.damping = between(0.0, 2.0) as f32;
    let speed = if between(0.0, 1.0) < 0.4 { between(0.0, 15.0) as f32 } else { 0.0 };
    cloth.velocity = if upright { [0.0, 0.0, -speed] } else { [0.0, -speed, 0.0] };
    let mut scene = Scene::new("random");
    scene.cloths.push(cloth);
    for _ in 0..between(0.0, 4.0) as u32 {
        let mut length = |low: f64, high: f64| between(low, high) as f32;
        let at = [length(-0.4, 0.4), length(0.1, 0.6), length(-0.5, 0.3)];
        let shape = match length(0.0, 5.0) as u32 {
            0 => Shape::Sphere { radius: length(0.05, 0.3) },
            1 => Shape::Capsule { half_height: length(0.05, 0.4), radius: length(0.03, 0.2) },
            2 => Shape::Box { half: [length(0.05, 0.3), length(0.05, 0.3), length(0.05, 0.3)] },
            3 => Shape::Ellipsoid { radii: [length(0.08, 0.3), length(0.08, 0.3), length(0.08, 0.3)], closest: true },
            _ => Shape::HalfSpace,
        };
        let plane = matches!(shape, Shape::HalfSpace);
        let mut collider = Collider::new(shape, if plane { [0.0, -0.2, 0.0] } else { at });
        collider.friction = length(0.0, 0.6);
        if !plane && length(0.0, 1.0) < 0.3 {
            collider.velocity = [length(-2.0, 2.0), length(-0.5, 2.0), length(-2.0, 2.0)];
        }
        scene.colliders.push(collider);
    }
    Ok(Made { scene, pins, speed })
}

/// Whether a point is inside a collider of `share` of its size; colliders of these scenes are not turned.
fn inside(c: &Collider, p: [f32; 3], share: f32) -> bool {
    let q = [0, 1, 2].map(|k| p[k] - c.center[k]);
    let norm = |v: [f32; 3]| v.iter().map(|x| x * x).sum::<f32>();
    match c.shape {
        Shape::HalfSpace => false,
        Shape::Sphere { radius } => norm(q) < (share * radius).powi(2),
        Shape::Capsule { half_height, radius } => {
            norm([q[0], q[1] - q[1].clamp(-half_height, half_height), q[2]]) < (share * radius).powi(2)
        }
        Shape::TaperedCapsule { half_height, radii: [low, high] } => (0..=64).any(|n| {
            let t = n as f32 / 64.0;
            norm([q[0], q[1] - (2.0 * t - 1.0) * half_height, q[2]]) < (share * (low + t * (high - low))).powi(2)
        }),
        Shape::Box { half } => (0..3).all(|k| q[k].abs() < share * half[k]),
        Shape::Ellipsoid { radii, .. } => norm([0, 1, 2].map(|k| q[k] / radii[k])) < share * share,
    }
}

/// Particles whose path in a frame leads through the core of a collider.
fn through(colliders: &[Collider], was: &[[f32; 4]], now: &[[f32; 4]]) -> usize {
    let crosses = |c: &Collider, a: &[f32; 4], b: &[f32; 4]| {
        let from = [0, 1, 2].map(|k| a[k] + c.velocity[k] * FRAME);
        let on = |t: f32| [0, 1, 2].map(|k| from[k] + (b[k] - from[k]) * t);
        b[3] > 0.0 && !inside(c, from, CORE) && (1..POINTS).any(|n| inside(c, on(n as f32 / POINTS as f32), CORE))
    };
    was.iter().zip(now).filter(|(a, b)| colliders.iter().any(|c| crosses(c, a, b))).count()
}

/// Extension below which 99 of 100 structural springs are.
fn p99(flat: [usize; 2], rest: f64, now: &[[f32; 4]]) -> f64 {
    let [wide, high] = flat;
    let mut all = Vec::new();
    for k in 0..wide * high {
        let others = [(k % wide + 1 < wide).then_some(k + 1), (k / wide + 1 < high).then_some(k + wide)];
        for other in others.into_iter().flatten().filter(|o| now[k][3] + now[*o][3] > 0.0) {
            let far = (0..3).map(|c| f64::from(now[k][c] - now[other][c]).powi(2)).sum::<f64>().sqrt();
            all.push((far / rest - 1.0).max(0.0));
        }
    }
    all.sort_by(f64::total_cmp);
    all.get(all.len() * 99 / 100).copied().unwrap_or(0.0)
}

/// The result of a scene.
struct Outcome {
    line: String,
    /// Stretched or tunnelled, and nothing was found.
    silent: bool,
}

fn run_one(k: usize) -> Result<Outcome> {
    let Made { scene, pins, speed } = make(k)?;
    let grid = &scene.cloths[0].grids()[0];
    let flat = [grid.width as usize, grid.height as usize];
    let at = scene.cloths[0].positions();
    let rest = (0..3).map(|c| f64::from(at[1][c] - at[0][c]).powi(2)).sum::<f64>().sqrt();
    let colliders = scene.colliders.len();
    let options = Options { backend: Backend::Cpu, threads: 1, normals: false, ..Options::default() };
    let mut stepper = Stepper::on_cpu(scene, options)?;
    let (mut worst, mut tunnelled) = (0f64, 0);
    for frame in 1..=FRAMES {
        let mut moved = stepper.scene().colliders.clone();
        moved.iter_mut().for_each(|c| c.center = [0, 1, 2].map(|k| c.center[k] + c.velocity[k] * FRAME));
        if moved != stepper.scene().colliders {
            stepper.set_colliders(moved)?;
        }
        let was = stepper.positions(0).unwrap_or_default().to_vec();
        stepper.advance(f64::from(FRAME))?;
        let now = stepper.positions(0).unwrap_or_default();
        tunnelled += through(&stepper.scene().colliders, &was, now);
        if frame >= SCORED[0] && frame.is_multiple_of(SCORED[1]) {
            worst = worst.max(p99(flat, rest, now));
        }
    }
    let choice = stepper.choice();
    // A warning that cloth began inside a collider does not warn of what came after.
    let is_warned = stepper.findings().iter().any(|f| !matches!(f.fate, Fate::Thrown { .. }));
    let found: Vec<String> = stepper.findings().iter().map(|f| format!("{:?}", f.fate)).collect();
    let found: Vec<&str> = found.iter().map(|f| f.split([' ', '{']).next().unwrap_or_default()).collect();
    let silent = (worst > MAX_P99 || tunnelled > 0) && !is_warned;
    let (wide, high) = (flat[0], flat[1]);
    let line = format!(
        "{k},{wide},{high},{pins},{colliders},{speed:.1},{},{},{worst:.4},{tunnelled},{},{}",
        choice.substeps,
        choice.polish,
        found.join(" "),
        u8::from(silent)
    );
    Ok(Outcome { line, silent })
}

/// Prints a line per scene and their sum; returns whether nothing failed in silence.
#[allow(clippy::print_stdout)]
pub fn run(count: usize, threads: usize) -> bool {
    println!("scene,width,height,pins,colliders,speed_m_s,substeps,polish,p99_worst,tunnelled,findings,silent");
    let mut silent = 0;
    crew::share(
        (count, threads),
        || (),
        |(), k| run_one(k),
        |outcome| match outcome {
            Ok(Outcome { line, silent: alone }) => {
                println!("{line}");
                silent += usize::from(alone);
            }
            Err(error) => {
                println!("refused: {error}");
                silent += 1;
            }
        },
    );
    eprintln!("{silent} of {count} scenes fail in silence");
    silent == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_through_a_ball_is_seen_and_one_beside_it_is_not() {
        let ball = [Collider::new(Shape::Sphere { radius: 0.2 }, [0.0; 3])];
        let [above, below, beside] = [[0.0, 0.3, 0.0, 1.0], [0.05, -0.3, 0.0, 1.0], [0.19, -0.3, 0.0, 1.0]];
        assert_eq!(through(&ball, &[above], &[below]), 1);
        assert_eq!(through(&ball, &[[0.19, 0.3, 0.0, 1.0]], &[beside]), 0);
        // A ball that carries the particle along.
        let moving = [Collider { velocity: [0.0, -36.0, 0.0], ..ball[0] }];
        assert_eq!(through(&moving, &[above], &[below]), 0);
    }
}
