//! A character at rest and in motion on a backend, and the row of figures of both.

use gimage_bench_host::{FRAME, Gpu, Host};
use gimage_runtime::{Options, Scene};

use crate::Error;
use crate::judge::Judge;
use crate::model::{LEAD_S, Model};

/// Seconds of rest, and those of them in which it is judged.
const REST_S: f64 = 2.0;
const RESTS_S: f64 = 1.0;
/// Particles that begin deeper \[m\] inside are counted apart: they do not meet the surface of a body.
const INSIDE_M: f64 = 0.005;
/// Two parts of a body cross at a point around which it winds this often.
const CROSSED: f64 = 1.5;

/// The first line of the table.
pub const HEADER: &str = "character,animation,collider,backend,particles,free,begin_inside,rest_frames,rest_over_0.5mm,rest_max_mm,\
frames,over_1mm,over_3mm,p99.9_mm,p99.99_mm,max_mm,points_over_3mm,of_them_in_crossed_body,begun_inside_max_mm,pin_gap_m,ring_gap_m,\
not_finite,stretch_p99_worst,faults,ms_min,ms_median,device_ms_median";

/// The figures of a run.
#[derive(Default)]
struct Seen {
    frames: u32,
    /// Frames with a particle deeper than 0.5, 1 and 3 mm.
    over: [u32; 3],
    depths: Vec<f64>,
    points_over: [u32; 2],
    /// Of particles that began inside.
    inside: f64,
    pin_gap: f64,
    ring_gap: f64,
    not_finite: usize,
    stretch: f64,
    faults: usize,
    /// Of each frame.
    times: Vec<f64>,
    /// The same by the clock of the device, if it has one.
    device_times: Vec<f64>,
}

/// The row of a character.
pub fn row(model: &Model, gpu: Option<&Gpu>, seconds: f64, deeper: Option<f64>) -> Result<String, Error> {
    let rest = run(model, gpu, [-LEAD_S - REST_S, -LEAD_S], RESTS_S, None)?;
    let mut seen = run(model, gpu, [-LEAD_S, seconds], seconds, deeper)?;
    seen.depths.sort_by(f64::total_cmp);
    seen.times.sort_by(f64::total_cmp);
    seen.device_times.sort_by(f64::total_cmp);
    let on_device =
        seen.device_times.get(seen.device_times.len() / 2).map_or_else(String::new, |ms| format!("{ms:.3}"));
    let time = |share: usize| seen.times.get(share * seen.times.len() / 2).copied().unwrap_or(0.0);
    let mm = |share: f64| {
        let last = seen.depths.len().saturating_sub(1);
        1e3 * seen.depths.get((last as f64 * share) as usize).copied().unwrap_or(0.0)
    };
    let percent = |count: u32, of: u32| 100.0 * f64::from(count) / f64::from(of.max(1));
    let particles = model.cloth.particles();
    let free = particles.iter().filter(|p| p.exists() && !p.is_pinned()).count();
    let rest_max = 1e3 * rest.depths.iter().copied().fold(0.0, f64::max);
    Ok(format!(
        "{},{},{},{},{},{free},{},{},{:.1},{rest_max:.2},{},{:.1},{:.1},{:.3},{:.3},{:.2},{},{},{:.1},{:.1e},{:.1e},{},{:.4},{},{:.3},{:.3},{on_device}",
        model.name,
        model.animation,
        model.collider,
        if gpu.is_some() { "gpu" } else { "cpu" },
        particles.iter().filter(|p| p.exists()).count(),
        free - seen.depths.len() / seen.frames.max(1) as usize,
        rest.frames,
        percent(rest.over[0], rest.frames),
        seen.frames,
        percent(seen.over[1], seen.frames),
        percent(seen.over[2], seen.frames),
        mm(0.999),
        mm(0.9999),
        mm(1.0),
        seen.points_over[0],
        seen.points_over[1],
        1e3 * seen.inside,
        seen.pin_gap.max(rest.pin_gap),
        seen.ring_gap.max(rest.ring_gap),
        seen.not_finite + rest.not_finite,
        seen.stretch,
        seen.faults,
        time(0),
        time(1),
    ))
}

/// Runs from one time to another \[s\] and judges every frame of the last `judged` seconds.
fn run(
    model: &Model,
    gpu: Option<&Gpu>,
    [from, to]: [f64; 2],
    judged: f64,
    deeper: Option<f64>,
) -> Result<Seen, Error> {
    let mut cloth = model.cloth.clone();
    cloth.follow_joints(&model.joints(from)?)?;
    let colliders = model.colliders.iter().map(|part| part.collider).collect();
    let mut scene = Scene { cloths: vec![cloth], colliders, ..Scene::new("character") };
    scene.clear_start(&Options::default())?;
    let mut placed = scene.cloths[0].clone();
    let body = Judge::new(&model.body, placed.skinning, &model.joints(from)?)?;
    let start = |p: &[f32; 3]| p.map(f64::from);
    let begins: Vec<f64> = body.depths(&placed.positions().iter().map(start).collect::<Vec<_>>());
    let rings = placed.rings();
    let (starts, members) = (rings.0.to_vec(), rings.1.to_vec());
    let mut host = Host::new(scene, Options::default(), gpu)?;
    let (frames, first) = (((to - from) / FRAME).round() as u32, ((to - from - judged) / FRAME).round() as u32);
    let mut seen = Seen::default();
    for frame in 1..=frames {
        let time = from + f64::from(frame) * FRAME;
        let matrices = model.joints(time)?;
        host.stepper.set_joints(0, &matrices)?;
        host.stepper.move_body(0, 0, &model.colliders, &matrices)?;
        let ms = host.timed(FRAME)?;
        if frame <= first {
            continue;
        }
        let now = host.now()?;
        seen.frames += 1;
        seen.times.push(ms);
        seen.device_times.extend(host.device_ms());
        seen.not_finite += now.iter().filter(|p| p.iter().any(|x| !x.is_finite())).count();
        placed.follow_joints(&matrices)?;
        for ring in starts.windows(2).map(|r| &members[r[0] as usize..r[1] as usize]) {
            for k in &ring[1..] {
                seen.ring_gap = seen.ring_gap.max(apart(&now[*k as usize], &now[ring[0] as usize]));
            }
        }
        let (mut points, mut kept) = (Vec::new(), Vec::new());
        for (k, particle) in placed.particles().iter().enumerate().filter(|x| x.1.exists()) {
            if particle.is_pinned() {
                let [x, y, z] = placed.positions()[k];
                seen.pin_gap = seen.pin_gap.max(apart(&now[k], &[x, y, z, 0.0]));
            } else {
                points.push([0, 1, 2].map(|c| f64::from(now[k][c])));
                kept.push(k);
            }
        }
        let judge = Judge::new(&model.body, placed.skinning, &matrices)?;
        let depths = judge.depths(&points);
        let mut deepest = 0.0f64;
        for ((k, p), depth) in kept.iter().zip(&points).zip(depths) {
            if begins[*k] > INSIDE_M {
                seen.inside = seen.inside.max(depth);
                continue;
            }
            deepest = deepest.max(depth);
            seen.depths.push(depth);
            if depth > 3e-3 {
                let is_crossed = judge.winding(*p) > CROSSED;
                seen.points_over = [seen.points_over[0] + 1, seen.points_over[1] + u32::from(is_crossed)];
            }
            if deeper.is_some_and(|mm| 1e3 * depth > mm) {
                let (mm, winding) = (1e3 * depth, judge.winding(*p));
                eprintln!("frame {frame}, {time:.3} s, particle {k}: {mm:.2} mm deep, winding {winding:.2}, {p:.4?}");
            }
        }
        for (count, limit) in seen.over.iter_mut().zip([5e-4, 1e-3, 3e-3]) {
            *count += u32::from(deepest > limit);
        }
        if let Some(stretch) = host.stepper.examine(0, &now, &now)?.stretch {
            seen.stretch = seen.stretch.max(stretch.p99);
        }
    }
    seen.faults = host.stepper.take_faults().len();
    Ok(seen)
}

fn apart(a: &[f32; 4], b: &[f32; 4]) -> f64 {
    (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}
