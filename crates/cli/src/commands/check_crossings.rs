//! `gimage check-crossings`: counts triangles that cross, in dumped frames and in bundles at rest.

mod frames;

use std::path::Path;

use gimage_bundle::dir::read_dir;
use gimage_runtime::Cloth;
use gimage_runtime::crossings::{self, Crossing, Crossings, Drawn, Place};
use serde_json::json;

use crate::args::CheckCrossingsArgs;
use crate::commands::scene;
use crate::exit::{Exit, Failure};
use crate::output::{Output, plain};
use crate::table::Table;
use frames::Frames;

/// Deepest pairs that are listed per frame.
const LISTED: usize = 8;

/// An input, checked.
struct Checked {
    path: String,
    cloths: Vec<Cloth>,
    /// Number of each frame, or `None` at rest, and its crossings.
    frames: Vec<(Option<u32>, Crossings)>,
}

/// Runs it.
pub fn run(args: &CheckCrossingsArgs, out: &Output) -> Result<Exit, Failure> {
    let scene = args.scene.as_deref().map(|name| scene::open(name, args.n)).transpose()?;
    let scene = scene.map(|file| file.scene.cloths);
    let mut exit = Exit::Done;
    let mut inputs = Vec::new();
    for path in &args.inputs {
        let checked = check(path, scene.as_deref())?;
        exit = exit.max(checked.exit());
        if out.json {
            inputs.push(checked.json());
        } else {
            out.data(&checked.text(out))?;
        }
        out.say(&checked.summary());
    }
    if out.json {
        out.json(&json!({"inputs": inputs, "exit": exit.code()}))?;
    }
    Ok(exit)
}

fn check(path: &Path, scene: Option<&[Cloth]>) -> Result<Checked, Failure> {
    let name = path.display().to_string();
    if !path.is_dir() {
        let hint = "give a directory of `gimage simulate --dump`, or a bundle";
        let problem = if path.exists() { "not a directory" } else { "no such directory" };
        return Err(Failure::refused(format!("{name}: {problem}; {hint}")));
    }
    if path.join("manifest.json").exists() {
        let bundle = read_dir(path).map_err(|e| Failure::bundle(path, &e))?;
        let cloths = vec![Cloth::from_bundle(&name, &bundle)?];
        let found = crossings::find(&[Drawn::new(&cloths[0])], LISTED)?;
        return Ok(Checked { path: name, cloths, frames: vec![(None, found)] });
    }
    let dump = Frames::open(path, scene)?;
    let mut frames = Vec::new();
    for frame in dump.numbers() {
        let positions = dump.read(frame)?;
        let drawn: Vec<_> = dump.cloths.iter().zip(&positions).map(|(cloth, now)| Drawn::at(cloth, now)).collect();
        frames.push((Some(frame), crossings::find(&drawn, LISTED)?));
    }
    Ok(Checked { path: name, cloths: dump.cloths, frames })
}

impl Checked {
    fn exit(&self) -> Exit {
        let clean = self.frames.iter().all(|(_, found)| found.total() == 0 && found.not_finite == 0);
        if clean { Exit::Done } else { Exit::Findings }
    }

    fn text(&self, out: &Output) -> String {
        let mut table = Table::new(&["frame", "within", "between", "touching", "double", "deepest", "not finite"]);
        let mut pairs = String::new();
        for (frame, found) in &self.frames {
            let frame = frame.map_or_else(|| "rest".into(), |f| f.to_string());
            let counts = [found.within, found.between, found.touching].map(|n| n.to_string());
            let deepest = format!("{:.3} mm", 1e3 * found.deepest);
            let [double, not_finite] = [found.double, found.not_finite]
                .map(|count| if count == 0 { String::new() } else { count.to_string() });
            for pair in found.worst.iter().filter(|_| out.verbose) {
                let [first, second] = [&pair.first, &pair.second].map(|place| self.words(place));
                pairs += &format!("  frame {frame}: {first} and {second}: {:.3} mm\n", 1e3 * pair.depth);
            }
            table.row([frame].into_iter().chain(counts).chain([double, deepest, not_finite]));
        }
        format!("{}\n", out.heading(&plain(&self.path))) + &table.render() + &plain(&pairs)
    }

    fn summary(&self) -> String {
        let crossed = self.frames.iter().filter(|(_, found)| found.total() > 0).count();
        let most = self.frames.iter().map(|(_, found)| found.total()).max().unwrap_or(0);
        let deepest = self.frames.iter().map(|(_, found)| found.deepest).fold(0.0, f64::max);
        let lost = self.frames.iter().map(|(_, found)| found.not_finite).max().unwrap_or(0);
        let lost =
            if lost > 0 { format!("; up to {lost} particles are not finite and not checked") } else { String::new() };
        let path = &self.path;
        let crossings = match (self.frames.as_slice(), crossed) {
            ([(None, _)], 0) => format!("{path}: no crossings at rest"),
            ([(None, _)], _) => format!("{path}: {most} pairs cross at rest, {:.3} mm deep", 1e3 * deepest),
            (frames, 0) => format!("{path}: no crossings in {} frames", frames.len()),
            (frames, _) => format!(
                "{path}: crossings in {crossed} of {} frames, at most {most} pairs, {:.3} mm deep",
                frames.len(),
                1e3 * deepest
            ),
        };
        crossings + &lost
    }

    fn words(&self, place: &Place) -> String {
        let grid = self.grid(place);
        format!("{grid} ({}, {})", place.texel[0], place.texel[1])
    }

    fn grid(&self, place: &Place) -> &str {
        self.cloths.get(place.cloth).and_then(|cloth| cloth.grids().get(place.grid)).map_or("", |grid| &grid.name)
    }

    fn json(&self) -> serde_json::Value {
        let place = |place: &Place| {
            let cloth = self.cloths.get(place.cloth).map(Cloth::name);
            json!({"cloth": cloth, "piece": self.grid(place), "texel": place.texel, "triangle": place.triangle})
        };
        let pair = |c: &Crossing| json!({"first": place(&c.first), "second": place(&c.second), "depth_m": c.depth});
        let frame = |(frame, found): &(Option<u32>, Crossings)| {
            json!({"frame": frame, "within": found.within, "between": found.between, "touching": found.touching,
                   "double": found.double, "deepest_m": found.deepest, "triangles": found.triangles, "degenerate": found.degenerate,
                   "not_finite": found.not_finite, "worst": found.worst.iter().map(pair).collect::<Vec<_>>()})
        };
        json!({"path": self.path, "cloths": self.cloths.iter().map(Cloth::name).collect::<Vec<_>>(),
               "frames": self.frames.iter().map(frame).collect::<Vec<_>>()})
    }
}
