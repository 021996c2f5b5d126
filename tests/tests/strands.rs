//! A drawstring of one mesh with a garment, from the file to the drawn mesh.

use std::fmt::Write;
use std::path::Path;

use gimage::strands::Strands;
use gimage_runtime::RenderMesh;
use gimage_tests::{build, check, reread, texels, texels_of};

use crate::drawn::stepper;

/// Cells per side of a sheet of 1 m, and the length \[m\] of the string that hangs from the one in the middle.
const CELLS: usize = 80;
const LENGTH: f64 = 0.2;

/// Writes a sheet with a string: four sides, and a closed end.
fn write(path: &Path) {
    let (row, side) = (CELLS + 1, 1.0 / CELLS as f64);
    let mut text = String::new();
    for k in 0..row * row {
        writeln!(text, "v {} {} 0", (k % row) as f64 * side, (k / row) as f64 * side).unwrap();
    }
    let root = CELLS / 2 * row + CELLS / 2;
    let mut last = [root, root + 1, root + row + 1, root + row];
    let corners = last;
    for k in 0..CELLS * CELLS {
        let k = k / CELLS * row + k % CELLS;
        if k != root {
            writeln!(text, "f {} {} {} {}", k + 1, k + 2, k + row + 2, k + row + 1).unwrap();
        }
    }
    for ring in 1..=20 {
        let first = row * row + 4 * (ring - 1);
        for k in corners {
            let z = LENGTH * ring as f64 / 20.0;
            writeln!(text, "v {} {} {z}", (k % row) as f64 * side, (k / row) as f64 * side).unwrap();
        }
        let next = [0, 1, 2, 3].map(|k| first + k);
        for k in 0..4 {
            let [a, b, c, d] = [last[k], last[(k + 1) % 4], next[(k + 1) % 4], next[k]];
            writeln!(text, "f {} {} {} {}", a + 1, b + 1, c + 1, d + 1).unwrap();
        }
        last = next;
    }
    let [a, b, c, d] = last;
    writeln!(text, "f {} {} {} {}", a + 1, b + 1, c + 1, d + 1).unwrap();
    std::fs::write(path, text).unwrap();
}

#[test]
fn a_string_is_drawn_on_the_cloth_that_it_is_no_part_of() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hood.obj");
    write(&path);
    let made = |strands| {
        let mut options = texels(1024);
        options.strands.strands = strands;
        let built = build(&path, &options).unwrap();
        (built.report.findings.iter().any(|f| f.kind == "strands-left-out"), built)
    };
    let highest = |built: &gimage::pipeline::Built| {
        texels_of(&built.bundle, 0).iter().map(|texel| texel[2]).fold(f32::MIN, f32::max)
    };
    let (is_named, built) = made(Strands::Ride);
    assert!(is_named && highest(&built) < 1e-6, "{}", highest(&built));
    check("hood.obj", &built);
    // The drawn mesh has all of it, where the file has it.
    let bundle = reread(&built.bundle);
    let mesh = RenderMesh::from_bundle(&bundle).unwrap().unwrap();
    let mut vertices = Vec::new();
    stepper(&bundle).wrap(0, &mesh, 1.0, &mut vertices).unwrap();
    let on_string = vertices.iter().filter(|v| v.position[2] > 1e-3).count();
    let tip = vertices.iter().map(|v| v.position[2]).fold(0.0, f32::max);
    assert!(on_string >= 80 && (tip - LENGTH as f32).abs() < 1e-5, "{on_string} {tip}");
    let (is_named, built) = made(Strands::Keep);
    assert!(!is_named && highest(&built) > 0.9 * LENGTH as f32, "{}", highest(&built));
}
