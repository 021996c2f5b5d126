//! `gimage export`: the simulated motion as files that film and game tools read.

mod grid;
mod mesh;
mod schedule;
mod sink;
mod source;

use gimage::export::motion::{Compression, Shown};
use gimage_runtime::Backend;
use serde_json::json;

use crate::args::{CompressArg, ExportArgs, ShownArg};
use crate::commands::engine::Engine;
use crate::commands::faults::Faults;
use crate::commands::scene;
use crate::exit::{Exit, Failure};
use crate::output::{Output, Tone};
use crate::units::grouped;
use schedule::Schedule;
use sink::{Sink, Written};
use source::Source;

/// The kind of file to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Glb(Shown, Compression),
    Usd,
    Obj,
}

/// Runs it.
pub fn run(args: &ExportArgs, out: &Output) -> Result<Exit, Failure> {
    let kind = kind(args)?;
    sink::check(kind, &args.output, args.force)?;
    let loaded = scene::load(&args.scene)?;
    let schedule = Schedule::new(args, loaded.file.scene.frames, loaded.file.options.step)?;
    let mut engine = Engine::of(&loaded)?;
    engine.warn(out);
    let mut source = Source::new(args, &engine, &loaded, out)?;
    for name in source.empty() {
        let text = format!("piece {name}: it has no triangles, and is not in the file");
        out.remark(Tone::Warning, "warning", &text);
    }
    let dressing = if matches!(kind, Kind::Glb(..)) { source.dressing(&loaded)? } else { None };
    let mut sink = Sink::new(kind, &args.output, &schedule, dressing)?;
    let mut faults = Faults::default();
    schedule
        .run(&mut engine, &mut faults, |engine, time, fraction| sink.frame(source.read(engine, fraction)?, time))?;
    faults.at_end(&mut engine)?;
    faults.warn(out, &engine, (engine.time() / engine.stepper.options().step).round() as usize);
    let written = sink.finish()?;
    report(args, out, (&engine, &faults), (&schedule, &source, &written))
}

fn kind(args: &ExportArgs) -> Result<Kind, Failure> {
    let (output, shown) = (&args.output, args.shown);
    let extension = output.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    let kind = match extension.as_deref() {
        Some("glb") => {
            let shown = match shown {
                Some(ShownArg::Meshes) => Shown::Meshes,
                Some(ShownArg::Targets) | None => Shown::Targets,
            };
            let compression = match args.compress {
                CompressArg::None => Compression::None,
                CompressArg::Meshopt => Compression::Meshopt,
                CompressArg::Draco => Compression::Draco,
            };
            if compression == Compression::Draco && shown == Shown::Targets {
                let hint = "give --as meshes, for a mesh per frame, or --compress meshopt";
                return Err(Failure::refused(format!("--compress draco has no morph targets; {hint}")));
            }
            return Ok(Kind::Glb(shown, compression));
        }
        Some("usda") => Kind::Usd,
        Some("obj") => Kind::Obj,
        _ => {
            let hint = "end it in .glb, .usda or .obj";
            return Err(Failure::refused(format!("{}: unknown kind of file; {hint}", output.display())));
        }
    };
    let glb_only = [("--as", shown.is_some()), ("--compress", args.compress != CompressArg::None)];
    match glb_only.into_iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => {
            Err(Failure::refused(format!("{}: only a .glb has {option}; leave it out", output.display())))
        }
        None => Ok(kind),
    }
}

fn report(
    args: &ExportArgs,
    out: &Output,
    (engine, faults): (&Engine, &Faults),
    (schedule, source, written): (&Schedule, &Source, &Written),
) -> Result<Exit, Failure> {
    let exit = if source.empty().next().is_some() { faults.exit().max(Exit::Findings) } else { faults.exit() };
    let backend = if engine.stepper.backend() == Backend::Cpu { "cpu" } else { "gpu" };
    let [pieces, vertices, triangles] = source.counts();
    if out.json {
        out.json(&json!({
            "output": args.output.display().to_string(),
            "files": written.files,
            "surface": source.name(),
            "frames": schedule.kept(),
            "frames_per_second": schedule.rate(),
            "seconds": schedule.seconds(),
            "pieces": pieces,
            "vertices": vertices,
            "triangles": triangles,
            "bytes": written.bytes,
            "backend": backend,
            "adapter": engine.adapter,
            "start": engine.start_json(),
            "findings": faults.findings(),
            "crossings": faults.crossed.json(),
            "faults": faults.json(),
            "exit": exit.code(),
        }))?;
        return Ok(exit);
    }
    let name = match &written.files[..] {
        [first, .., last] => format!("{first} to {last}"),
        files => files.concat(),
    };
    let (frames, rate) = (schedule.kept(), schedule.rate());
    let [pieces, vertices, triangles, bytes] =
        [pieces as u64, vertices as u64, triangles as u64, written.bytes].map(grouped);
    let of = format!("{pieces} pieces, {vertices} vertices, {triangles} triangles");
    out.data(&format!("{name}: {frames} frames at {rate} per second on the {backend}: {of}, {bytes} bytes\n"))?;
    Ok(exit)
}
