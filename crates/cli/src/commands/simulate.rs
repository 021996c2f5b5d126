//! `gimage simulate`: steps a scene, times it, and dumps positions.

mod dump;
mod engine;

use std::path::Path;
use std::time::Instant;

use gimage_bundle::dir::read_dir;
use gimage_runtime::scene::{BUILTIN, builtin};
use gimage_runtime::{Backend, Cloth, Options, Scene, Solver};
use serde_json::json;

use crate::args::{BackendArg, SimulateArgs, SolverArg};
use crate::exit::{Exit, Failure};
use crate::output::Output;
use dump::Dump;
use engine::Engine;

/// Runs it.
pub fn run(args: &SimulateArgs, out: &Output) -> Result<Exit, Failure> {
    let scene = scene(args)?;
    let frames = args.frames.unwrap_or(scene.frames);
    let backend = match args.backend {
        BackendArg::Auto => Backend::Auto,
        BackendArg::Gpu => Backend::Gpu,
        BackendArg::Cpu => Backend::Cpu,
    };
    let solver = match args.solver {
        SolverArg::Classic => Solver::Classic,
    };
    let (substeps, iterations) = (args.substeps, args.iterations);
    let options = Options { backend, solver, substeps, iterations, threads: args.threads.into(), ..Options::default() };
    let step = options.step;
    let mut engine = Engine::new(scene, options)?;
    let dump = args.dump.as_deref().map(|dir| Dump::new(dir, &engine.stepper)).transpose()?;
    let mut times = Vec::new();
    for frame in 0..=frames {
        if frame > 0 {
            let start = Instant::now();
            engine.frame(step)?;
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
        let due = frame >= args.dump_from && (frame - args.dump_from).is_multiple_of(args.every);
        if let Some(dump) = dump.as_ref().filter(|_| due) {
            dump.write(frame, &mut engine)?;
        }
    }
    report(args, out, &engine, times)
}

/// A built-in scene by name, else a bundle under gravity.
fn scene(args: &SimulateArgs) -> Result<Scene, Failure> {
    let path = Path::new(&args.scene);
    if BUILTIN.contains(&args.scene.as_str()) || !path.exists() {
        return Ok(builtin(&args.scene, args.n)?);
    }
    let bundle = read_dir(path).map_err(|e| Failure::bundle(path, &e))?;
    let mut scene = Scene::new(&args.scene);
    scene.cloths.push(Cloth::from_bundle(&args.scene, &bundle)?);
    Ok(scene)
}

fn report(args: &SimulateArgs, out: &Output, engine: &Engine, mut times: Vec<f64>) -> Result<Exit, Failure> {
    times.sort_by(f64::total_cmp);
    let (least, median) = (times.first().copied(), times.get(times.len() / 2).copied());
    let plan = engine.stepper.plan();
    let backend = if engine.stepper.backend() == Backend::Cpu { "cpu" } else { "gpu" };
    if !out.json {
        let ms = |x: Option<f64>| x.map_or_else(|| "-".into(), |x| format!("{x:.4}"));
        let (name, frames) = (&args.scene, times.len());
        let line = format!("{name}: {frames} frames on the {backend} ({})", engine.adapter);
        let line = format!("{line}, ms a frame: least {}, median {}\n", ms(least), ms(median));
        out.data(&(line + &plan.to_string()))?;
        return Ok(Exit::Done);
    }
    let passes = plan.passes.iter().map(|p| {
        let bindings: serde_json::Map<_, _> = p.bindings.iter().map(|(n, b)| (n.to_string(), json!(b))).collect();
        json!({"cloth": p.cloth, "shader": p.shader, "workgroups": p.workgroups, "dispatches": p.dispatches,
               "bindings": bindings})
    });
    out.json(&json!({
        "scene": args.scene,
        "backend": backend,
        "adapter": engine.adapter,
        "solver": "classic",
        "substeps": args.substeps,
        "iterations": args.iterations,
        "particles": engine.stepper.scene().cloths.iter().map(Cloth::len).sum::<usize>(),
        "frames": times.len(),
        "ms_frame_min": least,
        "ms_frame_median": median,
        "dispatches_per_frame": plan.dispatches(),
        "plan": passes.collect::<Vec<_>>(),
        "exit": Exit::Done.code(),
    }))?;
    Ok(Exit::Done)
}
