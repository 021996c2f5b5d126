//! Runs all stages of a build, from a file to a bundle.

mod budget;
mod dress;
mod entries;
mod findings;
mod outcome;
mod pins;
mod room;

use std::path::Path;
use std::time::Instant;

use gimage_bundle::Bundle;
use rayon::prelude::*;

pub use self::dress::dress;
use self::findings::{closed, merged, nothing_left, remarks, resolution, set_apart, split_up};
use self::outcome::Gathered;
pub use self::pins::PINNED_TOP;
use self::pins::{Plan, worn_on};
use crate::base::mesh::Semantic;
use crate::error::{Error, Result};
use crate::options::BuildOptions;
use crate::progress::{Progress, Stage};
use crate::report::{Report, StageTime, peak_memory};
use crate::stage::assemble::accessory::{Rider, anchor};
use crate::stage::assemble::blends;
use crate::stage::assemble::mass::check_mean;
use crate::stage::assemble::{Piece, assemble, measure_piece, summary};
use crate::stage::blend::{BlendWidth, WIDTH, blend, border};
use crate::stage::caps::{Caps, open_caps};
use crate::stage::component::Component;
use crate::stage::gate;
use crate::stage::image::PieceImage;
use crate::stage::import::{IDENTITY, import};
use crate::stage::render::trace::Trace;
use crate::stage::render::{self, RenderMesh, Subdivision};
use crate::stage::repair::repair;
use crate::stage::select::{demand_cloth, divided, select};
use crate::stage::shell::thin;
use crate::stage::stitch::stitch;
use crate::stage::strands::leave_strands;

/// A finished build, not yet written.
#[derive(Clone, Debug)]
pub struct Built {
    /// The bundle in memory; write it with [`gimage_bundle::dir::write_dir`].
    pub bundle: Bundle,
    /// Stages, times and findings.
    pub report: Report,
}

/// Times the stages and keeps their findings.
struct Run<'a> {
    progress: &'a dyn Progress,
    report: Report,
}

impl Run<'_> {
    fn stage<T>(&mut self, stage: Stage, steps: usize, work: impl FnOnce(&mut Report) -> Result<T>) -> Result<T> {
        if self.progress.cancelled() {
            return Err(Error::Cancelled);
        }
        self.progress.begin(stage, steps as u64);
        let start = Instant::now();
        let out = work(&mut self.report)?;
        let seconds = start.elapsed().as_secs_f64();
        self.report.stages.push(StageTime { stage, seconds, peak_bytes: peak_memory() });
        Ok(out)
    }
}

/// Builds a bundle from a garment file. The same file and options give the same bytes whatever the number of threads.
///
/// Errors: those of the import; [`Error::Empty`] if no component is large enough to be a piece;
/// [`Error::GridTooSmall`] if an exact size cannot hold the border of a piece; [`Error::Option`] if `--pins auto` finds no body;
/// [`Error::Cancelled`].
pub fn build(path: &Path, options: &BuildOptions, progress: &dyn Progress) -> Result<Built> {
    build_as(path, options, false, progress, |_, _| ())
}

/// As [`build`]; if `dressed`, with the defaults of [`dress`]. `add` adds to the bundle before it is validated.
fn build_as(
    path: &Path,
    options: &BuildOptions,
    dressed: bool,
    progress: &dyn Progress,
    add: impl FnOnce(&mut Bundle, &mut Report),
) -> Result<Built> {
    options.check()?;
    let mut run = Run { progress, report: Report::default() };
    let imported = run.stage(Stage::Import, 1, |report| {
        let imported = import(path, &options.import)?;
        report.findings.extend(imported.findings.iter().cloned());
        Ok(imported)
    })?;
    let (mut mesh, source) = (imported.mesh, imported.source);
    let plain = || imported.origins.is_empty().then(|| render::plain::document(&mesh));
    let is_drawn = options.render.render_mesh == RenderMesh::On;
    let plain = if is_drawn { plain() } else { None };
    mesh = divided(mesh, &options.select);
    if dressed {
        demand_cloth(&source.file_name, &mesh, &options.select)?;
    }
    let body = worn_on(&mesh, options, dressed)?;
    let width = blend_width(options, dressed);
    let edges = if width.is_some() { border(&mesh, &options.select)? } else { Vec::new() };
    let is_painted = mesh.channel(&Semantic::Custom(blends::ATTRIBUTE.into())).is_some();
    let may_open = options.caps.caps != Caps::Keep && !mesh.skeleton.joints.is_empty();
    let may_blend = may_open || !edges.is_empty() || !options.assemble.blends.is_empty() || is_painted;
    let mut trace = is_drawn.then(|| {
        let trace = Trace::start(&mut mesh);
        if may_blend { trace.with_joints(&mesh) } else { trace }
    });
    let mesh = run.stage(Stage::Repair, 1, |report| {
        let selected = select(mesh, &options.select)?;
        report.findings.extend(selected.findings);
        trace.iter_mut().for_each(|trace| trace.selected(&selected.mesh));
        let repaired = repair(selected.mesh, &options.repair)?;
        report.findings.extend(repaired.findings);
        Ok(repaired.mesh)
    })?;
    let plan = Plan::new(path, &mesh, body.as_ref(), options, dressed)?;
    drop(body);
    run.report.findings.extend(plan.findings.iter().cloned());
    let options = &plan.options;
    let mut thinned = run.stage(Stage::Shell, 1, |report| {
        let stripped = leave_strands(mesh, &options.strands);
        report.findings.extend(stripped.finding);
        let mesh = stripped.mesh;
        let corners = trace.as_ref().filter(|_| may_open).map(|trace| trace.corners_of(&mesh));
        let opened = open_caps(mesh, &options.caps);
        if let (Some(trace), Some(corners)) = (&mut trace, corners) {
            trace.capped(&corners, &opened.caps);
        }
        report.findings.extend(opened.finding);
        let thinned = thin(opened.mesh, &options.shell, &options.component);
        report.findings.extend(thinned.findings.iter().cloned());
        Ok(thinned)
    })?;
    trace.iter_mut().for_each(|trace| trace.finish(&mut thinned.mesh));
    let mesh = &thinned.mesh;
    let parts = run.stage(Stage::Component, 1, |report| {
        let parts = thinned.split(&options.component);
        if parts.pieces.is_empty() {
            return Err(nothing_left(path, mesh, &parts.accessories, options));
        }
        report.findings.extend(resolution(mesh));
        report.findings.extend(closed(&parts.pieces));
        Ok(parts)
    })?;
    let total: f64 = parts.pieces.iter().map(|p| p.area).sum();
    check_mean(total, &options.mass)?;
    let made = run.stage(Stage::Image, parts.pieces.len(), |report| {
        let (made, finding) = outcome::images(mesh, &parts.pieces, options, progress)?;
        report.findings.extend(finding);
        Ok(made)
    })?;
    let named = outcome::name_parts(&parts.pieces, &parts.accessories, &made);
    let Gathered { pieces, mut riders, families } = outcome::gather(&parts.pieces, made, &named);
    if pieces.is_empty() {
        return Err(nothing_left(path, mesh, &parts.pieces, options));
    }
    let small = format!("area under {} % of the whole", 100.0 * options.component.accessory_area);
    let reason =
        |c: &Component| c.lies_on.as_ref().map_or(small.clone(), |larger| format!("lies on {larger} all over"));
    riders.extend(parts.accessories.iter().map(|component| Rider { component, reason: reason(component) }));
    run.report.findings.extend(set_apart(&riders));
    run.report.findings.extend(split_up(&families));
    run.report.findings.extend(merged(pieces.iter().flat_map(|p| remarks(&p.component.name, &p.image))));

    let mut bundle = run.stage(Stage::Maps, pieces.len(), |report| {
        let mut bundle = Bundle::new(concat!("gimage ", env!("CARGO_PKG_VERSION")));
        let mut held = plan.hold(&pieces, &families, &mut report.findings);
        if let Some(width) = width {
            let found = blend(&mut held, &edges, &pieces, &families, width, plan.is_automatic());
            report.findings.extend(found);
        }
        let step = || progress.step(Stage::Maps);
        let findings = assemble(&mut bundle, mesh, &pieces, &families, &held, options, &step)?;
        report.findings.extend(findings);
        Ok(bundle)
    })?;
    run.stage(Stage::Stitch, 1, |report| {
        report.findings.extend(stitch(&mut bundle, &pieces, &families, &options.stitch)?);
        Ok(())
    })?;
    if options.gate.metrics {
        run.stage(Stage::Measure, pieces.len(), |_| {
            measure(&mut bundle, &pieces, total, progress);
            Ok(())
        })?;
    }
    gate::scale_parts(&mut bundle.manifest.pieces, &pieces);
    run.report.findings.extend(gate::check(&bundle.manifest.pieces, &pieces, &options.gate)?);
    let images: Vec<&PieceImage> = pieces.iter().map(|p| &p.image).collect();
    bundle.manifest.accessories = anchor(mesh, &riders, &images);
    entries::shells(&mut bundle, &pieces, &riders, &thinned);
    if let Some(trace) = &trace {
        let made = render::Made { trace, pieces: &pieces, families: &families, riders: &riders };
        // Without a glTF file the mesh is written as it was imported.
        let transform = if plain.is_some() { IDENTITY } else { imported.transform };
        let origins = &imported.origins;
        let cells = drawn_cells(options, dressed);
        let imported = render::Imported { path, source: &source, origins, transform, plain, cells };
        run.stage(Stage::Render, 1, |report| {
            report.findings.extend(render::add(&mut bundle, imported, &made, options)?);
            Ok(())
        })?;
    }
    entries::describe(&mut bundle, mesh, &source, options, &run.report.findings);
    add(&mut bundle, &mut run.report);
    run.stage(Stage::Encode, 1, |_| {
        bundle.count()?;
        sound(&bundle)
    })?;
    Ok(Built { bundle, report: run.report })
}

/// The width \[m\] of the blend at borders; `None` if they do not blend.
fn blend_width(options: &BuildOptions, dressed: bool) -> Option<f64> {
    match options.blend.width {
        Some(BlendWidth::Within(width)) => Some(width),
        Some(BlendWidth::None) => None,
        None => dressed.then_some(WIDTH),
    }
}

/// The longest edge of drawn cloth, as a multiple of the distance of two texels; `None` leaves all.
fn drawn_cells(options: &BuildOptions, dressed: bool) -> Option<f64> {
    match options.render.subdivide {
        Some(Subdivision::Cells(cells)) => Some(cells),
        Some(Subdivision::None) => None,
        None => dressed.then_some(render::CELLS),
    }
}

/// Checks a bundle against the rules of its format, before anyone sees it. Nothing that a file holds may lead here.
fn sound(bundle: &Bundle) -> Result<()> {
    match gimage_bundle::validate(bundle).first() {
        None => Ok(()),
        Some(fault) => Err(Error::Internal(format!("the bundle breaks a rule of its format: {fault}"))),
    }
}

/// Measures every piece against its surface, and the bundle against all of them. `total` is their area \[m2\].
fn measure(bundle: &mut Bundle, pieces: &[Piece<'_>], total: f64, progress: &dyn Progress) {
    let measured: Vec<_> = pieces
        .par_iter()
        .map(|p| {
            let quality = measure_piece(&p.surface, &p.image, p.surface.area() / total);
            progress.step(Stage::Measure);
            quality
        })
        .collect();
    let whole = summary(&measured, pieces);
    for (entry, quality) in bundle.manifest.pieces.iter_mut().zip(&measured) {
        entry.quality = quality.merged(std::mem::take(&mut entry.quality));
    }
    bundle.manifest.quality = whole.merged(std::mem::take(&mut bundle.manifest.quality));
}
