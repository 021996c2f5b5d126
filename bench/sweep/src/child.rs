//! The child: one build from a file, measured, as JSON to a file.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use gimage::component::{Component, ComponentOptions, Split, split};
use gimage::import::{ImportOptions, import};
use gimage::pipeline::{Built, build};
use gimage::progress::Quiet;
use gimage::repair::repair;
use gimage::report::peak_memory;
use gimage::shell::{Thinned, thin};
use gimage::{Error, Mesh};
use gimage_bundle::MapKind;
use serde_json::Value;

use crate::Failure;
use crate::args::OneArgs;
use crate::limit;
use crate::probe::{self, Surface};
use crate::record::{Finding, Piece, Probe, Record, Status};

/// Runs it.
pub fn run(args: &OneArgs) -> Result<(), Failure> {
    limit::set(args.limit_seconds, args.limit_mib)?;
    let start = Instant::now();
    let result = build(&args.mesh, &args.options(), &Quiet);
    let mut record = Record { cpu: limit::cpu_seconds(), wall: start.elapsed().as_secs_f64(), ..Record::default() };
    record.mib = peak_memory().map_or(0.0, |b| b as f64 / f64::from(1 << 20));
    match result {
        Err(e) => {
            // Tables of different machines agree on the file's name, not on its folder.
            let folder = args.mesh.parent().map_or(String::new(), |p| format!("{}/", p.display()));
            let message = if folder.len() > 1 { e.to_string().replace(&folder, "") } else { e.to_string() };
            record.status = Status::Refused { kind: kind(&e), message };
            record.triangles = Source::read(&args.mesh, args).map_or(0, |s| s.mesh.triangles.len());
            if matches!(e, Error::Poor { .. }) {
                // The figures of what the gate refused are worth having.
                let mut options = args.options();
                options.gate.accept_poor = true;
                if let Ok(built) = build(&args.mesh, &options, &Quiet) {
                    describe(&built, args, &mut record)?;
                }
            }
        }
        Ok(built) => {
            record.status = Status::Built;
            describe(&built, args, &mut record)?;
        }
    }
    std::fs::write(&args.out, serde_json::to_vec(&record)?)?;
    Ok(())
}

/// The kind of an error of the gate.
pub const GATE: &str = "gate: poor image";

/// A short name of an error.
fn kind(error: &Error) -> String {
    match error {
        Error::Io { .. } => "io".into(),
        Error::Malformed { .. } => "malformed file".into(),
        Error::Unsupported { .. } => "unsupported file".into(),
        Error::Empty { .. } => "nothing to build".into(),
        Error::TooLarge { .. } => "too large".into(),
        Error::GridTooSmall { .. } => "grid too small".into(),
        Error::Piece { stage, .. } => format!("piece: {stage}"),
        Error::Poor { .. } => GATE.into(),
        Error::Option { .. } => "option".into(),
        Error::Cancelled => "cancelled".into(),
        Error::Bundle(_) => "bundle".into(),
        Error::Internal(_) => "internal error".into(),
        // The name of a variant that this program does not know yet.
        other => format!("{other:?}").split(|c: char| !c.is_alphanumeric()).next().unwrap_or("other").to_lowercase(),
    }
}

/// Describes the result, by the build's own word and by the probe's.
fn describe(built: &Built, args: &OneArgs, record: &mut Record) -> Result<(), Failure> {
    let manifest = serde_json::to_value(&built.bundle.manifest)?;
    let report = serde_json::to_value(&built.report)?;
    record.findings = serde_json::from_value(report["findings"].clone()).unwrap_or_default();
    let source = Source::read(&args.mesh, args)?;
    record.triangles = source.mesh.triangles.len();
    let areas: Vec<f64> = list(&manifest["accessories"]).iter().filter_map(|a| a["area"].as_f64()).collect();
    record.accessories = areas.len();
    record.largest_accessory = areas.iter().copied().fold(0.0, f64::max) / source.area().max(f64::MIN_POSITIVE);
    for (k, entry) in list(&manifest["pieces"]).iter().enumerate() {
        let mut piece = described(entry);
        let image = built.bundle.images.get(&(k, MapKind::Position));
        if let Some(image) = image {
            let image = Surface::of_image(image);
            piece.probe = source.compare(&piece.name, &image);
        }
        record.pieces.push(piece);
    }
    Ok(())
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

/// A piece as the manifest has it.
fn described(entry: &Value) -> Piece {
    let quality = &entry["quality"];
    // A part is judged at the size of its component, as the gate does.
    let scale = quality["component_scale"].as_f64().unwrap_or(1.0);
    let whole = |v: &Value| v.as_u64().and_then(|x| u32::try_from(x).ok()).unwrap_or_default();
    Piece {
        name: entry["name"].as_str().unwrap_or_default().into(),
        width: whole(&entry["width"]),
        height: whole(&entry["height"]),
        triangles: whole(&entry["surface"]["triangles"]),
        euler: entry["surface"]["euler"].as_i64().and_then(|x| i32::try_from(x).ok()).unwrap_or_default(),
        loops: whole(&entry["surface"]["loops"]),
        psnr: quality["psnr"].as_f64().map(|x| x + 20.0 * scale.log10()),
        hausdorff: quality["hausdorff_rel"].as_f64().map(|x| x / scale),
        l2: quality["stretch_l2"].as_f64(),
        stretch: quality["stretch_max"].as_f64(),
        energy: quality["symmetric_dirichlet"].as_f64(),
        normal: quality["normal_degrees"].as_f64(),
        fold: quality["fold_area"].as_f64(),
        flips: quality["flips"].as_u64(),
        rungs: serde_json::from_value(entry["ladder"].clone()).unwrap_or_default(),
        probe: Default::default(),
    }
}

/// The mesh after import and repair, by component, with thin shells as both sheets and as one layer.
struct Source {
    mesh: Mesh,
    pieces: BTreeMap<String, Component>,
    /// Thin shells as the one layer that the image was made of.
    thinned: Thinned,
    layers: BTreeMap<String, Component>,
}

impl Source {
    fn read(path: &Path, args: &OneArgs) -> Result<Self, Failure> {
        let options = args.options();
        let mesh = repair(import(path, &ImportOptions::default())?.mesh, &options.repair)?.mesh;
        let by_name = |s: Split| s.pieces.into_iter().chain(s.accessories).map(|c| (c.name.clone(), c)).collect();
        let parts = ComponentOptions::default();
        let pieces = by_name(split(&mesh, &parts));
        let thinned = thin(mesh.clone(), &options.shell, &parts);
        let layers = by_name(thinned.split(&parts));
        Ok(Self { mesh, pieces, thinned, layers })
    }

    fn area(&self) -> f64 {
        self.pieces.values().map(|c| c.area).sum()
    }

    /// Of a thin shell the image is compared with its one layer. Its largest distance is that from both sheets, so that
    /// a layer far from them counts against the build.
    fn compare(&self, piece: &str, image: &Surface) -> Probe {
        let whole = || surface(&self.mesh, 0..self.mesh.triangles.len());
        let component = |m: &Mesh, c: &Component| surface(m, c.triangles.iter().map(|&t| t as usize));
        let sheets = self.pieces.get(piece);
        let measured =
            probe::compare(&sheets.map_or_else(whole, |c| component(&self.mesh, c)), image, sheets.is_some());
        match self.layers.get(piece).filter(|c| self.thinned.shell(c).is_some()) {
            None => measured,
            Some(layer) => {
                let of_layer = probe::compare(&component(&self.thinned.mesh, layer), image, true);
                let hausdorff = measured.hausdorff.into_iter().chain(of_layer.hausdorff).reduce(f64::max);
                Probe { hausdorff, ..of_layer }
            }
        }
    }
}

fn surface(mesh: &Mesh, triangles: impl Iterator<Item = usize>) -> Surface {
    Surface::new(triangles.map(|t| mesh.corners(t)).collect())
}

/// Severities that count as a word about the result.
pub const WARNINGS: [&str; 2] = ["warning", "error"];

impl Finding {
    /// Whether this warns of the result of a piece. Stages before the image speak of the input.
    pub fn warns_of(&self, piece: &str) -> bool {
        let about = |e: &String| e.contains(piece);
        WARNINGS.contains(&self.severity.as_str())
            && !["import", "repair", "component"].contains(&self.stage.as_str())
            && (self.examples.iter().any(about)
                || self.examples.is_empty()
                || self.message.contains(piece)
                || self.count > self.examples.len() as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_about_the_input_or_another_piece_does_not_count() {
        let finding = |severity: &str, stage: &str, example: &str, count| Finding {
            severity: severity.into(),
            stage: stage.into(),
            count,
            examples: vec![example.into()],
            ..Finding::default()
        };
        assert!(finding("warning", "image", "piece shirt", 1).warns_of("shirt"));
        assert!(finding("warning", "image", "piece dress", 9).warns_of("shirt"));
        assert!(!finding("warning", "image", "piece dress", 1).warns_of("shirt"));
        assert!(!finding("note", "image", "piece shirt", 1).warns_of("shirt"));
        assert!(!finding("warning", "repair", "piece shirt", 1).warns_of("shirt"));
    }

    #[test]
    fn an_error_has_the_name_of_its_stage() {
        let e = Error::Piece { piece: "x".into(), stage: "cut", problem: String::new(), hint: String::new() };
        assert_eq!((kind(&e).as_str(), kind(&Error::Cancelled).as_str()), ("piece: cut", "cancelled"));
    }
}
