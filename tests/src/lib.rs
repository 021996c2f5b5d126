//! Helpers of the tests across the crates: where files are, meshes made by rule, and what every build must keep.

pub mod glb;
pub mod shapes;
pub mod skip;

// The code of these pages compiles.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
mod readme {}
#[cfg(doctest)]
#[doc = include_str!("../../docs/runtime.md")]
mod runtime_page {}
#[cfg(doctest)]
#[doc = include_str!("../../docs/crowds.md")]
mod crowds_page {}
#[cfg(doctest)]
#[doc = include_str!("../../docs/characters.md")]
mod characters_page {}
#[cfg(doctest)]
#[doc = include_str!("../../docs/screen.md")]
mod screen_page {}
#[cfg(doctest)]
#[doc = include_str!("../../docs/recovery.md")]
mod recovery_page {}

use std::path::{Path, PathBuf};

use gimage::Result;
use gimage::options::{BuildOptions, ImageSize, PieceOptions, Sample};
use gimage::pipeline::Built;
use gimage::progress::Quiet;
use gimage::reconstruct::{PieceView, Reconstruction, reconstruct};
use gimage::topology::Topology;
use gimage_bundle::{Bundle, MapKind};

pub use shapes::Shape;

/// The folder of shared data: `$GIMAGE_SHARED`, or `shared` beside the repository.
pub fn shared() -> PathBuf {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    std::env::var_os("GIMAGE_SHARED").map_or_else(beside, PathBuf::from)
}

/// The folder of shared garments, or one line that the test is skipped.
pub fn garments_or_skip(test: &str) -> Option<PathBuf> {
    let folder = shared().join("garments");
    if folder.is_dir() {
        return Some(folder);
    }
    skip::skip(&format!("{test}: no shared garments (set GIMAGE_SHARED to the folder that holds garments/)"));
    None
}

/// A file in `assets/`.
pub fn asset(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets").join(name)
}

/// Default options at a budget of texels.
pub fn texels(n: u32) -> BuildOptions {
    let image = PieceOptions { size: ImageSize::Texels(n), ..PieceOptions::default() };
    BuildOptions { image, ..BuildOptions::default() }
}

/// The same with texels exactly on the surface.
pub fn point(n: u32) -> BuildOptions {
    let mut options = texels(n);
    options.image.sample = Sample::Point;
    options
}

/// As [`texels`], with pins.
pub fn pinned(n: u32, pins: &[&str]) -> BuildOptions {
    let mut options = texels(n);
    options.assemble.pins = pins.iter().map(|pin| pin.parse().expect("a pin expression")).collect();
    options
}

/// Builds without progress.
pub fn build(path: &Path, options: &BuildOptions) -> Result<Built> {
    gimage::pipeline::build(path, options, &Quiet)
}

/// Builds a mesh by way of an OBJ file.
pub fn build_shape(shape: &Shape, options: &BuildOptions) -> Result<Built> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("shape.obj");
    std::fs::write(&path, shape.obj()).expect("the temporary folder can be written");
    build(&path, options)
}

/// The bundle as another program would read it: encoded and decoded.
pub fn reread(bundle: &Bundle) -> Bundle {
    Bundle::from_files(&bundle.encode().expect("the bundle encodes")).expect("the bundle decodes")
}

/// x, y, z, w of every texel of a piece.
pub fn texels_of(bundle: &Bundle, piece: usize) -> Vec<[f32; 4]> {
    let image = bundle.image(piece, &MapKind::Position).expect("every piece has positions");
    image.data.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect()
}

/// u, v of every texel of a piece, if it has them.
pub fn uv_of(bundle: &Bundle, piece: usize) -> Option<Vec<[f32; 2]>> {
    let image = bundle.image(piece, &MapKind::Uv(0))?;
    Some(image.data.chunks_exact(image.channels as usize).map(|p| [p[0], p[1]]).collect())
}

/// The welded surface of a bundle.
pub fn surface(bundle: &Bundle) -> Reconstruction {
    let entries = &bundle.manifest.pieces;
    let data: Vec<_> = (0..entries.len()).map(|k| (texels_of(bundle, k), uv_of(bundle, k))).collect();
    let views: Vec<PieceView> = entries
        .iter()
        .zip(&data)
        .map(|(entry, (position, uv))| PieceView {
            name: &entry.name,
            width: entry.width as usize,
            height: entry.height as usize,
            first_particle: entry.first_particle,
            position,
            uv: uv.as_deref(),
        })
        .collect();
    reconstruct(&views).expect("a sound bundle reconstructs")
}

/// The topology of one piece of a reconstruction.
pub fn topology(surface: &Reconstruction, piece: usize) -> Topology {
    Topology::of(&surface.triangles[surface.pieces[piece].triangles.clone()])
}

/// Peak signal-to-noise ratio \[dB\] of the whole bundle.
pub fn psnr(bundle: &Bundle) -> f64 {
    bundle.manifest.quality.psnr.unwrap_or(f64::INFINITY)
}

/// Every way in which a build breaks what all builds promise; empty for a good one. The bundle must read back as it was,
/// break no rule of the format, map without flips, close its seams without a gap, and weld to the topology of each piece.
pub fn faults(built: &Built) -> Vec<String> {
    let mut out = Vec::new();
    let bundle = reread(&built.bundle);
    if bundle.images != built.bundle.images {
        out.push("the images read back differ from those written".into());
    }
    out.extend(gimage_bundle::validate(&bundle).iter().take(4).map(|f| f.to_string()));
    match bundle.seam_gap() {
        Ok(0.0) => {}
        gap => out.push(format!("the seam gap is {gap:?}")),
    }
    if !out.is_empty() {
        return out;
    }
    let welded = surface(&bundle);
    for (k, piece) in bundle.manifest.pieces.iter().enumerate() {
        let mut say =
            |what: String| out.push(format!("piece {} ({} x {}): {what}", piece.name, piece.width, piece.height));
        if piece.quality.flips != Some(0) {
            say(format!("flips {:?}", piece.quality.flips));
        }
        if piece.quality.seam_gap != Some(0.0) {
            say(format!("seam gap {:?} in the manifest", piece.quality.seam_gap));
        }
        let Some(own) = &piece.surface else {
            say("the manifest does not tell its topology".into());
            continue;
        };
        let t = topology(&welded, k);
        if (t.euler, t.boundary_loops) != (i64::from(own.euler), own.loops as usize) {
            let (euler, loops) = (own.euler, own.loops);
            say(format!("welds to Euler number {}, {} loops instead of {euler}, {loops}", t.euler, t.boundary_loops));
        }
        // A surface of one side has edges that its triangles run along the same way, which the report states.
        let one_sided = built.report.findings.iter().any(|f| f.kind == "not-orientable");
        // A part may touch itself at points; that the whole does not is checked with the bundle.
        if piece.part_of.is_some() && (t.non_manifold_edges, t.components) == (0, 1) {
            continue;
        }
        if (t.non_manifold_edges, t.singular_vertices, t.components) != (0, 0, 1)
            || t.misoriented_edges > 0 && !one_sided
        {
            say(format!("welds to no manifold: {t:?}"));
        }
    }
    let told = built.report.findings.iter().find(|f| f.kind == "topology");
    out.extend(told.map(|f| format!("the report says: {}", f.message)));
    out
}

/// Panics with every fault of a build.
pub fn check(what: &str, built: &Built) {
    let found = faults(built);
    assert!(found.is_empty(), "{what}: {}", found.join("; "));
}
