//! `gimage render`: pictures of a scene, headless.

mod body;
mod covered;
mod encode;
mod inward;
mod offscreen;
mod painter;
mod paints;
mod palette;
mod shown;
mod space;

use std::path::Path;
use std::slice;

use gimage_runtime::draw::{Camera, Framing, View, bounds};
use gimage_runtime::{Backend, Cloth};
use serde_json::json;

use crate::args::{GroundArg, RenderArgs};
use crate::commands::engine::Engine;
use crate::commands::faults::Faults;
use crate::commands::scene::{self, Loaded};
use crate::exit::{Exit, Failure};
use crate::files::{Pending, check_file_target};
use crate::output::{Output, Tone};
use painter::Painter;
use shown::Shown;

/// sRGB of the background, unless told otherwise.
const BACKGROUND: [f32; 3] = [0.957, 0.957, 0.949];
/// The side from which a scene without a camera is seen.
const FROM: [f32; 3] = [0.45, 0.32, 1.0];
/// Degrees from the lower to the upper edge, unless told otherwise.
const FOV: f32 = 35.0;

/// Longest time of a picture \[s\], that of the longest scene.
const LONGEST_S: f64 = 86_400.0;

/// The kind of file to write.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Png,
    Gif,
}

/// Runs it.
pub fn run(args: &RenderArgs, out: &Output) -> Result<Exit, Failure> {
    let kind = kind(&args.output)?;
    painter::check_size(args.size)?;
    check_file_target(&args.output, args.force)?;
    let loaded = scene::load(&args.scene)?;
    let file = &loaded.file;
    let rests = args.time.is_none() && kind == Kind::Png && is_loose_bundle(args, &loaded);
    if rests {
        let text = "nothing is pinned: the picture shows the rest pose; give --time for a later one";
        out.remark(Tone::Note, "note", text);
    }
    let end = args.time.unwrap_or(if rests { 0.0 } else { f64::from(file.scene.frames) * file.options.step });
    let times = times(args, kind, end)?;
    let mut shown = Shown::new(args, &loaded, out)?;
    let (camera, lowest) = camera(args, &loaded, &times, &mut shown)?;
    let mut engine = Engine::of(&loaded)?;
    engine.warn(out);
    let has_ground = match args.ground {
        GroundArg::Auto => loaded.animated.is_some(),
        GroundArg::On => true,
        GroundArg::Off => false,
    };
    let ground = if has_ground { shown.ground(&loaded, &times, lowest) } else { None };
    let on_cpu = ground.is_some();
    if on_cpu && engine.gpu().is_some() {
        out.remark(
            Tone::Note,
            "note",
            "a ground with its shadow is drawn on the CPU, with all else; the cloth is on the GPU",
        );
    }
    let mut painter = Painter::new(&engine, args.size, file, on_cpu)?;
    painter.wear(&shown, &engine);
    if let Painter::Cpu(software) = &mut painter {
        software.ground = ground;
    }
    let (width, height) = args.size;
    let view = View {
        background: args.background.or(file.background).unwrap_or(BACKGROUND),
        ..View::new(&camera, width as f32 / height as f32)
    };
    let mut pictures = encode::Pictures::new(kind, args.size, args.fps);
    let mut faults = Faults::default();
    for time in &times {
        // Nothing left over: the last step is just what is seen.
        let fraction = Some(engine.go_to(*time, &mut faults)?).filter(|f| *f > 0.0).unwrap_or(1.0);
        pictures.add(painter.paint(&engine, &mut shown, &view, fraction)?)?;
    }
    faults.at_end(&mut engine)?;
    faults.warn(out, &engine, (engine.time() / engine.stepper.options().step).round() as usize);
    let bytes = pictures.finish()?;
    Pending::write(&args.output, &bytes)?.commit()?;
    let backend = if engine.stepper.backend() == Backend::Cpu { "cpu" } else { "gpu" };
    if out.json {
        out.json(&json!({
            "output": args.output.display().to_string(),
            "width": width,
            "height": height,
            "pictures": times.len(),
            "time": times.last(),
            "bytes": bytes.len(),
            "backend": backend,
            "adapter": engine.adapter,
            "surface": if shown.has_mesh() { "render" } else { "grid" },
            "ground": ground.map(|g| json!({"height": g.height, "middle": g.middle, "radius": g.radius})),
            "camera": {"eye": camera.eye, "target": camera.target, "fov_degrees": camera.fov.to_degrees()},
            "start": engine.start_json(),
            "findings": faults.findings(),
            "crossings": faults.crossed.json(),
            "faults": faults.json(),
            "exit": faults.exit().code(),
        }))?;
    } else {
        let (name, count, size) = (args.output.display(), times.len(), bytes.len());
        let plural = if count == 1 { "picture" } else { "pictures" };
        out.data(&format!("{name}: {count} {plural} of {width} x {height} on the {backend}, {size} bytes\n"))?;
    }
    Ok(faults.exit())
}

/// Whether a bundle is drawn that nothing holds: stepped, it only falls.
fn is_loose_bundle(args: &RenderArgs, loaded: &Loaded) -> bool {
    let pinned = |cloth: &Cloth| cloth.particles().iter().any(|p| p.is_pinned());
    let bundle = loaded.animated.is_none() && Path::new(args.scene.scene()).is_dir();
    bundle && !loaded.file.scene.cloths.iter().any(pinned)
}

fn kind(output: &Path) -> Result<Kind, Failure> {
    match output.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("png") => Ok(Kind::Png),
        Some("gif") => Ok(Kind::Gif),
        _ => Err(Failure::refused(format!("{}: name a .png or .gif", output.display()))),
    }
}

/// Times \[s\] of the pictures, rising to `end`.
fn times(args: &RenderArgs, kind: Kind, end: f64) -> Result<Vec<f64>, Failure> {
    if end > LONGEST_S {
        return Err(Failure::refused(format!("--time {end}: give at most {LONGEST_S} s")));
    }
    let fps = f64::from(args.fps);
    let count = match (kind, args.frames) {
        (Kind::Png, None | Some(1)) => 1,
        (Kind::Png, Some(_)) => return Err(Failure::refused("a PNG is one picture; name a .gif for --frames")),
        (Kind::Gif, Some(frames)) => frames,
        (Kind::Gif, None) => ((end * fps + 1e-6).floor() as u32).saturating_add(1),
    };
    if count > 10_000 {
        return Err(Failure::refused(format!("{count} pictures; give --frames, --fps or --time for at most 10000")));
    }
    let time = |k: u32| (end - f64::from(count - 1 - k) / fps).max(0.0);
    Ok((0..count).map(time).collect())
}

/// The camera of the arguments, else of the scene, else one that has everything in every picture, and the lowest y \[m\] of these.
fn camera(
    args: &RenderArgs,
    loaded: &Loaded,
    times: &[f64],
    shown: &mut Shown,
) -> Result<(Camera, Option<f32>), Failure> {
    let fov = args.fov.map(f32::to_radians);
    let given = args.camera.map(|[a, b, c, d, e, f]| Camera {
        eye: [a, b, c],
        target: [d, e, f],
        fov: fov.unwrap_or(FOV.to_radians()),
    });
    let of_file = loaded.file.camera.map(|c| Camera { fov: fov.unwrap_or(c.fov), ..c });
    if let Some(camera) = given.or(of_file) {
        camera.check()?;
        return Ok((camera, None));
    }
    let fov = fov.unwrap_or(FOV.to_radians());
    Camera { eye: FROM, target: [0.0; 3], fov }.check()?;
    // The pictures are not known before the scene has run: it runs twice.
    let mut engine = Engine::of(loaded)?;
    let aspect = args.size.0 as f32 / args.size.1 as f32;
    let mut framing = Framing::new(FROM, fov, aspect);
    let mut lowest = f32::INFINITY;
    let mut take = |points: &mut dyn Iterator<Item = [f32; 3]>| {
        framing.add(points.inspect(|p| lowest = lowest.min(p[1])));
    };
    for time in times {
        engine.go_to(*time, &mut Faults::default())?;
        let scene = engine.stepper.scene();
        for cloth in 0..scene.cloths.len() {
            let real = engine.positions(cloth)?.into_iter().filter(|p| p[3] >= 0.0);
            take(&mut real.map(|[x, y, z, _]| [x, y, z]));
        }
        let seen = scene.colliders.iter().enumerate();
        let seen = seen.filter(|(index, _)| !shown.hides_collider(*index, loaded.animated.as_deref()));
        for (low, high) in seen.filter_map(|(_, collider)| bounds(&[], slice::from_ref(collider))) {
            take(&mut (0..8).map(|k| [0, 1, 2].map(|c| if k >> c & 1 == 1 { high[c] } else { low[c] })));
        }
        take(&mut shown.facets(&engine, 1.0)?.iter().flat_map(|facet| facet.corners));
    }
    let camera = framing.camera().unwrap_or_else(|| Camera::framing([-0.5; 3], [0.5; 3], FROM, fov, aspect));
    camera.check()?;
    Ok((camera, Some(lowest).filter(|y| y.is_finite())))
}
