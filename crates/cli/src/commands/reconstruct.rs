//! `gimage reconstruct`: the welded surface of a bundle as a mesh.

use std::path::Path;

use gimage::export;
use gimage::reconstruct::{PieceView, reconstruct};
use gimage_bundle::{Bundle, Image, MapKind, dir};

use crate::args::ReconstructArgs;
use crate::exit::{Exit, Failure};
use crate::files::{Pending, check_file_target};
use crate::output::{Output, Tone};
use crate::units::grouped;

enum Format {
    Obj,
    Glb,
}

/// Runs it.
pub fn run(args: &ReconstructArgs, out: &Output) -> Result<Exit, Failure> {
    let format = format(&args.output)?;
    check_file_target(&args.output, args.force)?;
    let bundle = dir::read_dir(&args.bundle).map_err(|e| Failure::bundle(&args.bundle, &e))?;
    if bundle.manifest.pieces.is_empty() {
        return Err(Failure::refused(format!("{}: the bundle has no piece", args.bundle.display())));
    }
    let uv: Vec<_> = (0..bundle.manifest.pieces.len()).map(|p| uv(&bundle, p)).collect();
    let views: Vec<_> = uv.iter().enumerate().map(|(p, uv)| view(&bundle, p, uv.as_deref())).collect();
    let damaged = |e: gimage::Error| {
        let failure = Failure::from(e);
        Failure { message: format!("{}: {failure}", args.bundle.display()), ..failure }
    };
    let surface = reconstruct(&views).map_err(damaged)?;
    if surface.triangles.is_empty() {
        let problem = "there is no triangle in it: no quad of its images has three particles";
        return Err(Failure::refused(format!("{}: {problem}; build it again", args.bundle.display())));
    }
    let bytes = match format {
        Format::Obj => export::obj(&surface).into_bytes(),
        Format::Glb => export::glb(&surface)?,
    };
    Pending::write(&args.output, &bytes)?.commit()?;
    let mut exit = Exit::Done;
    for piece in surface.pieces.iter().filter(|piece| piece.triangles.is_empty()) {
        out.remark(
            Tone::Warning,
            "warning",
            &format!("piece {}: it has no triangles, and is not in the mesh", piece.name),
        );
        exit = Exit::Findings;
    }
    let (vertices, triangles) = (grouped(surface.positions.len() as u64), grouped(surface.triangles.len() as u64));
    out.say(&format!("wrote {}: {vertices} vertices, {triangles} triangles", args.output.display()));
    Ok(exit)
}

fn format(path: &Path) -> Result<Format, Failure> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("obj") => Ok(Format::Obj),
        Some("glb") => Ok(Format::Glb),
        _ => Err(Failure::refused(format!("{}: unknown kind of mesh; end it in .obj or .glb", path.display()))),
    }
}

fn texels<const N: usize>(image: Option<&Image>) -> &[[f32; N]] {
    // Of any other number of channels nothing is taken, and the size will be found wrong.
    image.filter(|i| i.channels as usize == N).map_or(&[], |i| i.data.as_chunks().0)
}

fn uv(bundle: &Bundle, piece: usize) -> Option<Vec<[f32; 2]>> {
    let image = bundle.image(piece, &MapKind::Uv(0))?;
    Some(texels::<3>(Some(image)).iter().map(|&[u, v, _]| [u, v]).collect())
}

fn view<'a>(bundle: &'a Bundle, piece: usize, uv: Option<&'a [[f32; 2]]>) -> PieceView<'a> {
    let entry = &bundle.manifest.pieces[piece];
    PieceView {
        name: &entry.name,
        width: entry.width as usize,
        height: entry.height as usize,
        first_particle: entry.first_particle,
        position: texels(bundle.image(piece, &MapKind::Position)),
        uv,
    }
}
