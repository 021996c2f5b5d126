//! The peers: Python programs beside this crate, whose images are measured as gimage's own are.

use std::path::{Path, PathBuf};
use std::process::Command;

use gimage::grid::Grid;
use gimage::measure::{MeasureOptions, measure};
use gimage::springs::{Rest, springs};
use gimage::stretch::spring_anisotropy;
use serde::Deserialize;

use crate::Failure;
use crate::args::{PeerArg, name};
use crate::job::output;
use crate::measured::{least, median};
use crate::row::Values;
use crate::source::Reference;

/// The report that a peer's program prints.
#[derive(Debug, Deserialize)]
pub struct Report {
    cut_cpu_s: Option<f64>,
    peak_bytes: Option<f64>,
    flips: Option<f64>,
    l2_stretch: Option<f64>,
    /// Whether charts may lie mirrored, so that normals of the image mean nothing.
    #[serde(default)]
    mirrored: bool,
    /// One a texel budget.
    pub images: Vec<Image>,
}

/// One image that a peer made.
#[derive(Debug, Deserialize)]
pub struct Image {
    /// Side of the square that sets the texel budget.
    pub texels: u32,
    /// Height x width x 3 float32; NaN where a texel is unused.
    pub path: PathBuf,
    /// Width x height of each chart image.
    pub sizes: String,
    cpu_s: Vec<f64>,
}

/// Runs a peer on a mesh at all texel budgets.
pub fn run(
    peer: PeerArg,
    python: &Path,
    mesh: &Path,
    out: &Path,
    texels: &[u32],
    repeat: u32,
) -> Result<Report, Failure> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../peers").join(format!("run_{}.py", name(peer)));
    let texels: Vec<String> = texels.iter().map(u32::to_string).collect();
    let mut command = Command::new(python);
    command.arg(script).arg(mesh).arg(out).args(["--texels", &texels.join(","), "--repeat", &repeat.to_string()]);
    Ok(serde_json::from_slice(&output(&mut command)?)?)
}

impl Report {
    /// The numbers of one image's row.
    pub fn values(&self, image: &Image, reference: &Reference) -> Result<Values, Failure> {
        let mut out = Values::new();
        let mut put = |name: &str, x: Option<f64>| out.extend(x.map(|x| (name.to_owned(), x)));
        put("triangles", Some(reference.triangles.len() as f64));
        put("repeats", Some(image.cpu_s.len() as f64));
        put("cpu_s_min", Some(least(image.cpu_s.iter().copied())));
        put("cpu_s_median", Some(median(image.cpu_s.iter().copied())));
        put("cut_cpu_s", self.cut_cpu_s);
        put("peak_mib", self.peak_bytes.map(|b| b / f64::from(1 << 20)));
        put("flips", self.flips);
        put("l2_stretch", self.l2_stretch);
        let grid = npy(&std::fs::read(&image.path)?)?;
        let triangles = triangulate(&grid);
        let options = MeasureOptions::default();
        if let Some(q) = measure(&reference.positions, &reference.triangles, &grid.positions, &triangles, &options) {
            put("psnr_db", Some(q.psnr));
            put("rms_rel", Some(q.rms_source_to_image.max(q.rms_image_to_source) / q.diagonal));
            put("hausdorff_rel", Some(q.hausdorff_relative));
            put("normal_deg", Some(q.normal_error_mean));
            put("fold_area", Some(q.fold_area));
        }
        // Only an image without holes is a net of springs.
        if grid.positions.iter().all(used) {
            let rest = springs(&grid, Rest::Chord);
            let anisotropy = spring_anisotropy(&grid, &rest);
            put("spring_anisotropy", anisotropy.map(|a| a.longest_to_shortest));
            put("spring_p99_to_p1", anisotropy.map(|a| a.p99_to_p1));
            put("spring_angle_deg", anisotropy.map(|a| a.angle_deviation));
        }
        Ok(out)
    }
}

fn used(p: &[f64; 3]) -> bool {
    p.iter().all(|x| x.is_finite())
}

/// Reads a height x width x 3 array of little-endian float32, which is all that the peers write.
fn npy(bytes: &[u8]) -> Result<Grid, Failure> {
    let bad = || Failure::from("a peer's image is not a float32 array of height x width x 3");
    let length = bytes.get(8..10).map(|b| usize::from(u16::from_le_bytes([b[0], b[1]]))).ok_or_else(bad)?;
    let head = bytes.get(10..10 + length).ok_or_else(bad)?;
    let head = String::from_utf8_lossy(head);
    let plain = bytes.starts_with(b"\x93NUMPY\x01") && head.contains("'<f4'") && head.contains("False");
    let shape = head.split_once('(').and_then(|(_, rest)| rest.split_once(')')).ok_or_else(bad)?.0;
    let shape: Vec<usize> = shape.split(',').filter_map(|x| x.trim().parse().ok()).collect();
    let &[height, width, 3] = shape.as_slice() else { return Err(bad()) };
    let number = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let texel = |b: &[u8]| [number(&b[0..4]), number(&b[4..8]), number(&b[8..12])];
    let positions: Vec<[f64; 3]> = bytes[10 + length..].chunks_exact(12).map(texel).collect();
    if !plain || height.checked_mul(width) != Some(positions.len()) {
        return Err(bad());
    }
    Ok(Grid::new(width, height, positions))
}

/// Two triangles a quad by the shorter diagonal, as in a full grid, and one where three corners are used.
fn triangulate(grid: &Grid) -> Vec<[u32; 3]> {
    let w = grid.width;
    let full = |k: usize| used(&grid.positions[k]);
    let quad = |i: usize, j: usize| [j * w + i, j * w + i + 1, (j + 1) * w + i + 1, (j + 1) * w + i];
    let least = |t: &[u32; 3], f: fn(usize, usize) -> usize| t.iter().map(|&k| f(k as usize, w)).min().unwrap_or(0);
    let whole = |t: &[u32; 3]| quad(least(t, |k, w| k % w), least(t, |k, w| k / w)).into_iter().all(full);
    let mut out: Vec<[u32; 3]> = grid.triangulate().into_iter().filter(whole).collect();
    for j in 0..grid.height.saturating_sub(1) {
        for i in 0..w.saturating_sub(1) {
            let quad = quad(i, j);
            let holes: Vec<usize> = (0..4).filter(|&k| !full(quad[k])).collect();
            if let [hole] = holes[..] {
                out.push([1, 2, 3].map(|k| quad[(hole + k) % 4] as u32));
            }
        }
    }
    out
}

impl Report {
    /// Takes out of a row what its images cannot tell.
    pub fn clear(&self, values: &mut Values) {
        if self.mirrored {
            values.retain(|name, _| !name.ends_with("normal_deg") && !name.ends_with("fold_area"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(shape: &str, values: &[f32]) -> Vec<u8> {
        let head = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}\n");
        let mut out = b"\x93NUMPY\x01\x00".to_vec();
        out.extend((head.len() as u16).to_le_bytes());
        out.extend(head.as_bytes());
        out.extend(values.iter().flat_map(|x| x.to_le_bytes()));
        out
    }

    #[test]
    fn an_array_becomes_a_grid_and_a_wrong_one_an_error() {
        let values: Vec<f32> = (0..18).map(|k| k as f32).collect();
        let grid = npy(&file("(2, 3, 3)", &values)).unwrap();
        assert_eq!((grid.width, grid.height, grid.positions[4]), (3, 2, [12.0, 13.0, 14.0]));
        for wrong in [file("(2, 4, 3)", &values), file("(18,)", &values), b"\x93NUMPY".to_vec(), Vec::new()] {
            assert!(npy(&wrong).is_err());
        }
    }

    #[test]
    fn a_hole_takes_the_triangles_at_it_and_leaves_the_rest() {
        let mut grid = Grid::new(3, 2, (0..6).map(|k| [f64::from(k % 3), f64::from(k / 3), 0.0]).collect());
        assert_eq!(triangulate(&grid).len(), 4);
        grid.positions[0] = [f64::NAN; 3];
        let triangles = triangulate(&grid);
        assert_eq!(triangles.len(), 3);
        assert!(triangles.contains(&[1, 4, 3]));
        grid.positions[1] = [f64::NAN; 3];
        assert_eq!(triangulate(&grid), [[2, 5, 4]]);
    }
}
