//! The cloth that a device is tried on, and the comparison with the CPU.

use super::super::Stepper;
use super::Mismatch;
use crate::cloth::{Cloth, Grid, Mass, Particle, Parts, Rest};
use crate::collider::{Collider, Shape};
use crate::error::{Error, Result};
use crate::gpu::{Pipelines, Span, guard_async, read_back_async};
use crate::options::{Backend, Options, Solver};
use crate::scene::Scene;

/// Length \[s\] of the frame, of two steps.
const FRAME: f64 = 1.0 / 120.0;
/// Largest differences that rounding explains: of positions \[m\] after two steps of cloth half a metre long, and of unit
/// normals.
const POSITION: f64 = 1e-5;
const NORMAL: f64 = 2e-3;

/// A device and its queue, and the host's cache of pipelines.
#[derive(Clone, Copy)]
pub struct On<'a> {
    pub handles: (&'a wgpu::Device, &'a wgpu::Queue),
    pub cache: Option<&'a wgpu::PipelineCache>,
}

type Lists = [Vec<[f32; 4]>; 3];
const NAMES: [&str; 3] = ["positions", "previous positions", "normals"];

/// Runs the probe. Errors of the device are mismatches.
pub async fn run(on: On<'_>) -> Vec<Mismatch> {
    let found = match scene() {
        Ok(scene) => compare(on, [&scene; 2]).await,
        Err(error) => Err(error),
    };
    let failed = |error: Error| error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    found.unwrap_or_else(|error| vec![Mismatch::Failed(failed(error))])
}

/// Steps one scene on the device and another, which is the same but in tests, on the CPU.
async fn compare(on: On<'_>, [there, here]: [&Scene; 2]) -> Result<Vec<Mismatch>> {
    let expected = on_cpu(here)?;
    let mut found = Vec::new();
    for (run, fused) in [("whole frames", true), ("pass by pass", false)] {
        let computed = on_device(on, there, fused).await?;
        for ((cloth, computed), expected) in here.cloths.iter().zip(&computed).zip(&expected) {
            found.extend(differences(run, computed, expected));
            found.extend(open_seams(run, cloth, computed));
        }
    }
    Ok(worst(found))
}

/// The worst of each kind, in the order of the first.
fn worst(found: Vec<Mismatch>) -> Vec<Mismatch> {
    let mut kept: Vec<Mismatch> = Vec::new();
    for mismatch in found {
        let same = |k: &&mut Mismatch| match (&**k, &mismatch) {
            (Mismatch::Apart { run: a, what: b, .. }, Mismatch::Apart { run, what, .. }) => (a, b) == (run, what),
            (Mismatch::Seam { run: a, what: b, .. }, Mismatch::Seam { run, what, .. }) => (a, b) == (run, what),
            _ => false,
        };
        match (kept.iter_mut().find(same), &mismatch) {
            (Some(Mismatch::Apart { by, .. }), Mismatch::Apart { by: more, .. }) => *by = by.max(*more),
            (Some(Mismatch::Seam { count, .. }), Mismatch::Seam { count: more, .. }) => *count += more,
            _ => kept.push(mismatch),
        }
    }
    kept
}

fn differences(run: &'static str, computed: &Lists, expected: &Lists) -> Vec<Mismatch> {
    let mut found = Vec::new();
    for (n, what) in NAMES.into_iter().enumerate() {
        let limit = if n < 2 { POSITION } else { NORMAL };
        let apart = |(a, b): (&[f32; 4], &[f32; 4])| (0..3).map(|c| difference(a[c], b[c])).fold(0.0, f64::max);
        let by = computed[n].iter().zip(&expected[n]).map(apart).fold(0.0, f64::max);
        if by > limit || computed[n].len() != expected[n].len() {
            found.push(Mismatch::Apart { run, what, by, limit });
        }
    }
    let mass =
        |(a, b): (&[f32; 4], &[f32; 4])| if a[3].to_bits() == b[3].to_bits() { 0.0 } else { difference(a[3], b[3]) };
    let by = computed[0].iter().zip(&expected[0]).map(mass).fold(0.0, f64::max);
    if by > 0.0 {
        found.push(Mismatch::Apart { run, what: "inverse masses", by, limit: 0.0 });
    }
    found
}

/// Infinite where either is not finite.
fn difference(a: f32, b: f32) -> f64 {
    let by = (f64::from(a) - f64::from(b)).abs();
    if by.is_finite() { by } else { f64::INFINITY }
}

fn open_seams(run: &'static str, cloth: &Cloth, computed: &Lists) -> Vec<Mismatch> {
    let (starts, members) = cloth.rings();
    let rings = || starts.windows(2).map(|ends| &members[ends[0] as usize..ends[1] as usize]);
    let mut found = Vec::new();
    for (list, what) in computed.iter().zip(NAMES) {
        let bits = |k: &u32| [0, 1, 2].map(|c| list[*k as usize][c].to_bits());
        let count = rings().filter(|ring| ring.iter().any(|k| bits(k) != bits(&ring[0]))).count();
        if count > 0 {
            found.push(Mismatch::Seam { run, what, count });
        }
    }
    found
}

fn options(backend: Backend, fused: bool) -> Options {
    Options { backend, solver: Solver::Xpbd, substeps: Some(2), step: FRAME, threads: 1, fused, ..Options::default() }
}

fn on_cpu(scene: &Scene) -> Result<Vec<Lists>> {
    let mut stepper = Stepper::unchecked(scene.clone(), options(Backend::Cpu, true), None, None)?;
    stepper.advance(FRAME)?;
    let list = |list: Option<&[[f32; 4]]>| list.map(<[_]>::to_vec).unwrap_or_default();
    let lists = |c| [list(stepper.positions(c)), list(stepper.previous(c)), list(stepper.normals(c))];
    Ok((0..scene.cloths.len()).map(lists).collect())
}

async fn on_device(on: On<'_>, scene: &Scene, fused: bool) -> Result<Vec<Lists>> {
    let (device, queue) = on.handles;
    let run = || {
        let (options, pipelines) = (options(Backend::Gpu, fused), Pipelines::new(device, on.cache));
        let mut stepper = Stepper::unchecked(scene.clone(), options, Some((device, queue)), Some(pipelines))?;
        let mut encoder = device.create_command_encoder(&Default::default());
        stepper.record(&mut encoder, FRAME)?;
        queue.submit([encoder.finish()]);
        Ok(stepper)
    };
    let stepper = guard_async(device, run).await?;
    let cloths = (0..scene.cloths.len()).filter_map(|c| stepper.buffers(c));
    // No reference to a stepper is held while the device is awaited, so that hosts may do so on any thread.
    let spans: Vec<[Span; 3]> = cloths.map(|b| [&b.now, &b.before, &b.normals].map(Span::clone)).collect();
    drop(stepper);
    let mut all = Vec::new();
    for [now, before, normals] in &spans {
        let read = |span| read_back_async(device, queue, span);
        all.push([read(now).await?, read(before).await?, read(normals).await?]);
    }
    Ok(all)
}

/// Two seamed tubes, whose ring lists have entries of two, three and four duplicates, in touch with a sphere.
fn scene() -> Result<Scene> {
    let mut scene = Scene::new("self-check");
    scene.cloths = vec![tube(3)?, tube(4)?];
    let sphere = Collider::new(Shape::Sphere { radius: 0.1 }, [0.15, -0.2, 0.0]);
    scene.colliders.push(Collider { friction: 0.3, ..sphere });
    Ok(scene)
}

/// Columns, of which the last is the duplicate of the first, and rows.
const SIZE: [u32; 2] = [9, 8];

/// A tube around y, sewn along its first and last column, whose upper row closes to one pinned point of `fold` duplicates.
/// The springs are a tenth too short, so that they act in the first step.
fn tube(fold: u32) -> Result<Cloth> {
    let [n, rows] = SIZE;
    let tip = |i: u32, j: u32| j == 0 && i < fold;
    let place = |i: u32, j: u32| {
        let angle = std::f32::consts::TAU * (i % (n - 1)) as f32 / (n - 1) as f32;
        let (s, c) = angle.sin_cos();
        if tip(i, j) { [0.02, 0.1, 0.01] } else { [0.2 * c, -0.07 * j as f32, 0.2 * s] }
    };
    let cells = || (0..rows).flat_map(|j| (0..n).map(move |i| (i, j)));
    let particle = |(i, j): (u32, u32)| match (i, j) {
        (i, 0) if i < fold => Particle::Pinned { next: Some((i + 1) % fold) },
        // The last column meets the first; in the upper row the tip has taken the first.
        (_, 0) => Particle::Free { next: None },
        (0, j) => Particle::Free { next: Some(j * n + n - 1) },
        (i, j) if i == n - 1 => Particle::Free { next: Some(j * n) },
        _ => Particle::Free { next: None },
    };
    let rest = |(i, j): (u32, u32)| {
        let to = |there: bool, x: u32, y: u32| {
            let (a, b) = (place(i, j), place(x, y));
            if there { 0.9 * (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt() } else { 0.0 }
        };
        let (right, down) = (i + 1 < n, j + 1 < rows);
        [
            to(right, i + 1, j),
            to(down, i, j + 1),
            to(right && down, i + 1, j + 1),
            to(right && j > 0, i + 1, j.saturating_sub(1)),
        ]
    };
    let mut cloth = Cloth::new(Parts {
        name: format!("ring of {fold}"),
        grids: vec![Grid { name: "tube".into(), first: 0, width: n, height: rows }],
        positions: cells().map(|(i, j)| place(i, j)).collect(),
        particles: cells().map(particle).collect(),
        rest: Rest::Image(cells().map(rest).collect()),
        mass: Mass::Constant(1e-3),
    })?;
    cloth.velocity = [0.1, -0.5, 0.2];
    cloth.damping = 0.5;
    Ok(cloth)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lists() -> (Scene, Vec<Lists>) {
        let scene = scene().unwrap();
        let lists = on_cpu(&scene).unwrap();
        (scene, lists)
    }

    #[test]
    fn the_probe_moves_stretches_and_touches() {
        let (scene, lists) = lists();
        for (cloth, [now, before, normals]) in scene.cloths.iter().zip(&lists) {
            let sizes: Vec<u32> = cloth.rings().0.windows(2).map(|r| r[1] - r[0]).collect();
            assert!(sizes.contains(&2) && sizes.iter().any(|s| *s > 2), "{sizes:?}");
            let moved = |k: usize| (0..3).map(|c| (now[k][c] - before[k][c]).abs()).fold(0.0, f32::max);
            assert!((0..now.len()).filter(|k| moved(*k) > 1e-3).count() > 30);
            assert!(normals.iter().all(|n| (n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0).abs() < 1e-4));
        }
        let without = on_cpu(&Scene { colliders: Vec::new(), ..scene }).unwrap();
        assert!((0..2).all(|c| without[c][0] != lists[c][0]), "no cloth touches the sphere");
    }

    #[test]
    fn wrong_numbers_are_named_with_their_size() {
        let (scene, lists) = lists();
        let find = |change: &dyn Fn(&mut Lists)| {
            let mut changed = lists[0].clone();
            change(&mut changed);
            let all = differences("test", &changed, &lists[0]).into_iter();
            all.chain(open_seams("test", &scene.cloths[0], &changed)).map(|m| m.to_string()).collect::<Vec<_>>()
        };
        assert!(find(&|_| {}).is_empty());
        assert!(find(&|l| l[0][40][1] += 1e-6).is_empty(), "rounding is not a fault");
        assert_eq!(find(&|l| l[0][40][1] += 1e-3), ["test: positions differ from the CPU's by 1.0e-3 (limit 1e-5)"]);
        assert!(find(&|l| l[1][40][1] = f32::NAN)[0].contains("previous positions differ from the CPU's by inf"));
        assert!(find(&|l| l[0][40][3] *= 1.0 + f32::EPSILON)[0].contains("inverse masses"));
        // A unit in the last place at one side of a seam.
        let seam = find(&|l| l[2][9][0] = f32::from_bits(l[2][9][0].to_bits() + 1));
        assert_eq!(seam, ["test: normals of 1 seam points are not the same bits on both sides"]);
    }
}
