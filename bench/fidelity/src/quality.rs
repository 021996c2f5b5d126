//! How faithful an image is: by gimage's own measurement, and by an independent scorer.

use std::path::{Path, PathBuf};
use std::process::Command;

use gimage_bundle::Manifest;
use gimage_bundle::manifest::MANIFEST_FILE;
use serde_json::Value;

use crate::Failure;
use crate::job::output;
use crate::row::Values;

/// Quality figures in the manifest of a measured bundle, and the sizes of its images.
pub fn of_bundle(bundle: &Path) -> Result<(Values, String), Failure> {
    let manifest = Manifest::from_bytes(&std::fs::read(bundle.join(MANIFEST_FILE))?)?;
    Ok((of_manifest(&manifest), sizes(&manifest)))
}

fn sizes(manifest: &Manifest) -> String {
    manifest.pieces.iter().map(|p| format!("{}x{}", p.width, p.height)).collect::<Vec<_>>().join(" ")
}

/// Distances are of the whole. Stretch is the root mean square over the pieces by area; the rest is the worst piece's.
fn of_manifest(manifest: &Manifest) -> Values {
    let (whole, mut out) = (&manifest.quality, Values::new());
    let mut put = |name: &str, x: Option<f64>| out.extend(x.map(|x| (name.to_owned(), x)));
    put("psnr_db", whole.psnr);
    put("rms_rel", whole.rms_rel);
    put("hausdorff_rel", whole.hausdorff_rel);
    put("normal_deg", whole.normal_degrees);
    put("fold_area", whole.fold_area);
    let pieces = || manifest.pieces.iter();
    let area = |p: &gimage_bundle::manifest::PieceEntry| p.surface.as_ref().map_or(0.0, |s| s.area);
    let stretch = pieces().filter_map(|p| Some((p.quality.stretch_l2?.powi(2), area(p))));
    let (sum, weight) = stretch.fold((0.0, 0.0), |(s, w), (x, a)| (s + x * a, w + a));
    put("l2_stretch", (weight > 0.0).then(|| (sum / weight).sqrt()));
    put("flips", pieces().map(|p| p.quality.flips.map(|f| f as f64)).sum());
    let worst =
        |values: &mut dyn Iterator<Item = f64>| values.fold(None, |m: Option<f64>, x| Some(m.map_or(x, |m| m.max(x))));
    put("spring_anisotropy", worst(&mut pieces().filter_map(|p| p.quality.spring_anisotropy)));
    for (column, name) in [
        ("spring_p99_to_p1", "spring_p99_to_p1"),
        ("spring_angle_deg", "spring_angle_degrees"),
        ("mass_p99_to_p1", "mass_p99_to_p1"),
    ] {
        put(column, worst(&mut pieces().filter_map(|p| p.quality.more.get(name)?.as_f64())));
    }
    let cut: f64 = pieces().filter_map(|p| Some(p.cut.as_ref()?.length)).sum();
    put("cut_rel", whole.diagonal.map(|d| cut / d));
    let bought = pieces().filter_map(|p| {
        let c = p.cut.as_ref()?;
        Some(((c.distortion_shortest? - c.distortion?) * area(p), area(p)))
    });
    let (sum, weight) = bought.fold((0.0, 0.0), |(s, w), (x, a)| (s + x, w + a));
    put("cut_bought", (weight > 0.0).then(|| sum / weight));
    let gap = worst(&mut pieces().filter_map(|p| p.quality.seam_gap));
    put("seam_gap_rel", gap.zip(whole.diagonal).map(|(g, d)| g / d));
    out
}

/// The independent scorer, a Python program.
pub struct Scorer {
    /// The Python that runs it.
    pub python: PathBuf,
    /// The program.
    pub script: PathBuf,
}

impl Scorer {
    /// Scores a `bundle` or an `image` against a mesh.
    pub fn score(&self, kind: &str, mesh: &Path, made: &Path) -> Result<Values, Failure> {
        let mut command = Command::new(&self.python);
        command.arg(&self.script).arg(kind).arg(mesh).arg(made);
        Ok(of_score(&serde_json::from_slice(&output(&mut command)?)?))
    }
}

fn of_score(score: &Value) -> Values {
    let mut out = Values::new();
    let mut put = |name: &str, x: Option<f64>| out.extend(x.map(|x| (name.to_owned(), x)));
    let number = |pointer: &str| score.pointer(pointer).and_then(Value::as_f64);
    put("scorer_psnr_db", number("/psnr"));
    put("scorer_rms_rel", number("/rms_sym"));
    put("scorer_hausdorff_rel", number("/haus"));
    put("scorer_normal_deg", number("/normal_deg_mean"));
    put("scorer_fold_area", number("/fold_area"));
    put("scorer_seam_gap_rel", number("/cracks/seam_gap_max_rel"));
    put("scorer_ring_gap", number("/rings/ring_gap"));
    put("scorer_euler_off", number("/cracks/euler").zip(number("/cracks/euler_orig")).map(|(a, b)| a - b));
    // A list for a bundle, of its pieces: the worst counts.
    let grids = score.get("grid").map_or(Vec::new(), |g| g.as_array().cloned().unwrap_or_else(|| vec![g.clone()]));
    put("scorer_l2_grid", grids.iter().filter_map(|g| g.get("L2")?.as_f64()).reduce(f64::max));
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use gimage_bundle::manifest::{PieceEntry, Quality, Surface};
    use serde_json::json;

    #[test]
    fn stretch_of_pieces_is_weighted_by_area_and_anisotropy_is_the_worst() {
        let piece = |area: f64, l2: f64, ratio: f64| PieceEntry {
            surface: Some(Surface { area, ..Surface::default() }),
            quality: Quality { stretch_l2: Some(l2), spring_anisotropy: Some(ratio), ..Quality::default() },
            ..PieceEntry::default()
        };
        let mut manifest = Manifest::new("test");
        manifest.pieces = vec![piece(3.0, 1.0, 9.0), piece(1.0, 2.0, 4.0)];
        let v = of_manifest(&manifest);
        assert_eq!((v["l2_stretch"], v["spring_anisotropy"]), (1.75f64.sqrt(), 9.0));
        assert!(!v.contains_key("psnr_db") && !v.contains_key("flips"));
    }

    #[test]
    fn scores_of_bundles_and_images_read_alike() {
        let score = |grid: Value| json!({"psnr": 70.5, "grid": grid, "cracks": {"euler": 1, "euler_orig": 2}});
        let one = of_score(&score(json!({"L2": 1.5})));
        let many = of_score(&score(json!([{"L2": 1.25}, {"L2": 1.5}])));
        assert_eq!(one, many);
        assert_eq!((one["scorer_psnr_db"], one["scorer_euler_off"]), (70.5, -1.0));
    }
}
