//! `gimage simulate`: steps a scene, times it, and dumps positions.

pub mod dump;
mod passes;

use std::time::Instant;

use gimage_runtime::{Backend, Cloth, Quality, Solver};
use serde_json::json;

use crate::args::SimulateArgs;
use crate::commands::engine::Engine;
use crate::commands::faults::Faults;
use crate::commands::scene;
use crate::exit::{Exit, Failure};
use crate::output::Output;
use crate::table::{NOTHING, Table};
use dump::Dump;
use passes::PassTimes;

/// Runs it.
pub fn run(args: &SimulateArgs, out: &Output) -> Result<Exit, Failure> {
    let loaded = scene::load(&args.scene)?;
    let frames = args.frames.unwrap_or(loaded.file.scene.frames);
    let step = loaded.file.options.step;
    let mut engine = Engine::of(&loaded)?;
    engine.warn(out);
    let dump = args.dump.as_deref().map(|dir| Dump::new(dir, &engine.stepper, args.force, out)).transpose()?;
    let (mut times, mut counts, mut rounds) = (Vec::new(), Vec::new(), Vec::new());
    let mut faults = Faults::default();
    let mut passes = PassTimes::default();
    for frame in 0..=frames {
        if frame > 0 {
            let start = Instant::now();
            if out.json && PassTimes::is_due(frame) && engine.gpu().is_some() {
                passes.take(engine.timed_frame(step)?);
            } else {
                engine.frame(step)?;
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
            counts.push(engine.stepper.substeps());
            rounds.push(engine.stepper.polish());
            faults.after_frame(&mut engine);
        }
        let due = frame >= args.dump_from && (frame - args.dump_from).is_multiple_of(args.every);
        if let Some(dump) = dump.as_ref().filter(|_| due) {
            dump.write(frame, &mut engine)?;
        }
    }
    faults.at_end(&mut engine)?;
    faults.warn(out, &engine, counts.len());
    report(args, out, &engine, (&faults, &passes), (times, [counts, rounds]))
}

fn report(
    args: &SimulateArgs,
    out: &Output,
    engine: &Engine,
    (faults, pass_times): (&Faults, &PassTimes),
    (mut times, mut counts): (Vec<f64>, [Vec<u32>; 2]),
) -> Result<Exit, Failure> {
    let frames = counts[0].len();
    times.sort_by(f64::total_cmp);
    let [substeps, rounds] = counts.each_mut().map(|list| {
        list.sort_unstable();
        [0, list.len() / 2, list.len().saturating_sub(1)].map(|k| list.get(k).copied())
    });
    let error = engine.stepper.estimated_error();
    let (least, median) = (times.first().copied(), times.get(times.len() / 2).copied());
    let (plan, options) = (engine.stepper.plan(), engine.stepper.options());
    let choice = engine.stepper.choice();
    let backend = if engine.stepper.backend() == Backend::Cpu { "cpu" } else { "gpu" };
    if !out.json {
        let ms = |x: Option<f64>| x.map_or_else(|| "-".into(), |x| format!("{x:.4}"));
        let name = args.scene.scene();
        let line = format!("{name}: {frames} frames on the {backend} ({})", engine.adapter);
        let line = format!("{line}, ms per frame: least {}, median {}\n", ms(least), ms(median));
        let chosen = chosen(options.quality, [substeps, rounds], error);
        let passes = if out.verbose { plan.to_string() } else { String::new() };
        out.data(&(line + &format!("{choice}\n") + &chosen + &fares(engine, faults) + &passes))?;
        return Ok(faults.exit());
    }
    let passes = plan.passes.iter().map(|p| {
        let bindings: serde_json::Map<_, _> = p.bindings.iter().map(|(n, b)| (n.to_string(), json!(b))).collect();
        json!({"cloth": p.cloth, "shader": p.shader, "workgroups": p.workgroups, "dispatches": p.dispatches,
               "bindings": bindings})
    });
    let cloths = faults.health.iter().zip(&engine.stepper.scene().cloths).enumerate().map(|(index, (h, cloth))| {
        let worst = engine.stepper.health(index).map_or(0.0, |h| h.1);
        json!({"name": cloth.name(), "particles": cloth.len(), "stretch_mean": h.stretch.map(|s| s.mean),
               "stretch_p99": h.stretch.map(|s| s.p99), "stretch_max": h.stretch.map(|s| s.max),
               "stretch_p99_worst": worst, "speed_rms_m_s": h.speed, "contact_depth_m": h.depth})
    });
    out.json(&json!({
        "scene": args.scene.scene(),
        "backend": backend,
        "adapter": engine.adapter,
        "solver": if options.solver == Solver::Xpbd { "xpbd" } else { "classic" },
        "substeps": engine.stepper.substeps(),
        "budget_ms": options.quality.budget(),
        "error_target": options.quality.target(),
        "substeps_min": substeps[0],
        "substeps_median": substeps[1],
        "substeps_max": substeps[2],
        "error_estimated": error,
        "warnings": engine.stepper.warnings().iter().map(ToString::to_string).collect::<Vec<_>>(),
        "start": engine.start_json(),
        "iterations": options.iterations,
        "tethers": options.tethers,
        "pyramid": options.pyramid,
        "polish": engine.stepper.polish(),
        "polish_min": rounds[0],
        "polish_median": rounds[1],
        "polish_max": rounds[2],
        "choice": choice.to_string(),
        "thickness": options.thickness,
        "particles": engine.stepper.scene().cloths.iter().map(Cloth::len).sum::<usize>(),
        "frames": frames,
        "ms_frame_min": least,
        "ms_frame_median": median,
        "dispatches_per_frame": plan.dispatches(),
        "plan": passes.collect::<Vec<_>>(),
        "gpu_passes": pass_times.json(),
        "cloths": cloths.collect::<Vec<_>>(),
        "findings": faults.findings(),
        "crossings": faults.crossed.json(),
        "faults": faults.json(),
        "exit": faults.exit().code(),
    }))?;
    Ok(faults.exit())
}

/// A row per cloth: how it fares at the end.
fn fares(engine: &Engine, faults: &Faults) -> String {
    let headings = ["<cloth", "particles", "stretch mean", "p99", "max", "worst p99", "speed", "depth", "warnings"];
    let mut table = Table::new(&headings);
    for (index, (h, cloth)) in faults.health.iter().zip(&engine.stepper.scene().cloths).enumerate() {
        let percent = |x: Option<f64>| x.map_or_else(|| NOTHING.to_owned(), |x| format!("{:.2} %", 100.0 * x));
        let worst = engine.stepper.health(index).filter(|_| h.stretch.is_some()).map(|h| h.1);
        table.row([
            cloth.name().to_owned(),
            cloth.len().to_string(),
            percent(h.stretch.map(|s| s.mean)),
            percent(h.stretch.map(|s| s.p99)),
            percent(h.stretch.map(|s| s.max)),
            percent(worst),
            format!("{:.1} mm/s", 1e3 * h.speed),
            format!("{:.2} mm", 1e3 * h.depth),
            faults.count(index).to_string(),
        ]);
    }
    table.render()
}

/// How many steps and rounds of polish were chosen and what they achieved, where they were; else nothing.
fn chosen(quality: Quality, [substeps, rounds]: [[Option<u32>; 3]; 2], error: Option<f64>) -> String {
    let range =
        |[least, median, most]: [Option<u32>; 3]| Some(format!("least {}, median {}, most {}", least?, median?, most?));
    let (Some(substeps), Some(rounds)) = (range(substeps), range(rounds)) else { return String::new() };
    if quality == Quality::Fixed {
        return String::new();
    }
    let error = error.map_or_else(String::new, |e| format!("; stretch at the end {:.2} %", 100.0 * e));
    format!("substeps chosen: {substeps}; rounds of polish: {rounds}{error}\n")
}
