//! The whole build, stage by stage: file -> bundle.

mod budget;

use std::path::Path;
use std::time::Instant;

use gimage_bundle::Bundle;
use gimage_bundle::manifest::{Joint, Repair, Skeleton, Source};
use rayon::prelude::*;

use self::budget::Made;
use crate::base::mesh::{Mesh, Semantic};
use crate::base::surface::Surface;
use crate::base::words;
use crate::error::{Error, Result};
use crate::options::{BuildOptions, ImageSize};
use crate::progress::{Progress, Stage};
use crate::record::{Finding, MAX_EXAMPLES, Severity};
use crate::report::{Report, StageTime, peak_memory};
use crate::stage::assemble::accessory::{Rider, anchor};
use crate::stage::assemble::mass::check_mean;
use crate::stage::assemble::{Family, assemble, measure_piece, part_components, summary};
use crate::stage::component::{ALWAYS_PIECE, Component, extract, split};
use crate::stage::gate;
use crate::stage::image::judge::Verdict;
use crate::stage::image::ladder::{Rung, Tried, WORTH, badness, is_sound, passes};
use crate::stage::image::{ImageOptions, PieceImage, image};
use crate::stage::import::import;
use crate::stage::repair::repair;
use crate::stage::sample::FitRecord;
use crate::stage::split::{Parts, image_parts};

/// A finished build, not yet written.
#[derive(Clone, Debug)]
pub struct Built {
    /// The bundle in memory; write it with [`gimage_bundle::dir::write_dir`].
    pub bundle: Bundle,
    /// What was done.
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

/// How much larger than its share the image of a small piece may get to hold its border.
const STRETCH: u32 = 4;

/// How much larger than its share an image may be before that is worth a warning: the next size that welds is up to twice as
/// large.
const OVER: f64 = 2.1;

/// Bytes of freed memory that stages hand on. An allocator such as glibc's returns every large buffer to the system, and
/// each page of the next is a fault again, until one of this size was freed; it is never touched.
const HANDED_ON: usize = 8 << 20;

/// Builds a bundle from a garment file. The same file and options give the same bytes whatever the number of threads.
///
/// Errors: whatever the import finds unreadable; [`Error::Empty`] when nothing is left to make a piece of;
/// [`Error::GridTooSmall`] when an exact size cannot hold a piece's border; [`Error::Cancelled`].
pub fn build(path: &Path, options: &BuildOptions, progress: &dyn Progress) -> Result<Built> {
    options.check()?;
    drop(std::hint::black_box(Vec::<u8>::with_capacity(HANDED_ON)));
    let mut run = Run { progress, report: Report::default() };
    let imported = run.stage(Stage::Import, 1, |report| {
        let imported = import(path, &options.import)?;
        report.findings.extend(imported.findings.iter().cloned());
        Ok(imported)
    })?;
    let (mesh, source) = (imported.mesh, imported.source);
    let mesh = run.stage(Stage::Repair, 1, |report| {
        let repaired = repair(mesh, &options.repair)?;
        report.findings.extend(repaired.findings);
        Ok(repaired.mesh)
    })?;
    let parts = run.stage(Stage::Component, 1, |report| {
        let parts = split(&mesh, &options.component);
        if parts.pieces.is_empty() {
            return Err(nothing_left(path, &mesh, &parts.accessories, options));
        }
        report.findings.extend(resolution(&mesh));
        Ok(parts)
    })?;
    let total: f64 = parts.pieces.iter().map(|p| p.area).sum();
    check_mean(total, &options.mass)?;
    let made = run.stage(Stage::Image, parts.pieces.len(), |report| {
        let one = |component: &Component, share| {
            if progress.cancelled() {
                return Err(Error::Cancelled);
            }
            make(&mesh, component, total, share, options)
        };
        let shares = shares(&parts.pieces, options)?;
        let made: Vec<Result<Outcome>> = parts
            .pieces
            .par_iter()
            .zip(&shares)
            .map(|(component, &share)| {
                let out = one(component, share);
                progress.step(Stage::Image);
                out
            })
            .collect();
        let mut made = made.into_iter().collect::<Result<Vec<_>>>()?;
        if let ImageSize::Texels(texels) = options.size {
            report.findings.extend(keep_budget(&parts.pieces, &shares, &mut made, texels, &one)?);
        }
        Ok(made)
    })?;
    let split_components = name_parts(&parts.pieces, &parts.accessories, &made);
    let (mut pieces, mut riders, mut families) = (Vec::new(), Vec::new(), Vec::new());
    for ((component, outcome), named) in parts.pieces.iter().zip(made).zip(&split_components) {
        match outcome {
            Outcome::Piece(surface, image) => pieces.push((component, surface, *image)),
            Outcome::Parts(Parts { parts, rings }) => {
                families.push(Family { whole: component, first: pieces.len(), count: parts.len(), rings });
                pieces.extend(named.iter().zip(parts).map(|(c, p)| (c, p.surface, p.image)));
            }
            Outcome::Accessory(reason) => riders.push(Rider { component, reason }),
        }
    }
    if pieces.is_empty() {
        return Err(nothing_left(path, &mesh, &parts.pieces, options));
    }
    let small = format!("area under {} % of the whole", 100.0 * options.component.accessory_area);
    riders.extend(parts.accessories.iter().map(|component| Rider { component, reason: small.clone() }));
    run.report.findings.extend(set_apart(&riders));
    run.report.findings.extend(split_up(&families));
    run.report.findings.extend(merged(pieces.iter().flat_map(|(c, _, i)| remarks(&c.name, i))));

    let mut bundle = run.stage(Stage::Maps, pieces.len(), |report| {
        let mut bundle = Bundle::new(concat!("gimage ", env!("CARGO_PKG_VERSION")));
        let findings = assemble(&mut bundle, &mesh, &pieces, &families, options, &|| progress.step(Stage::Maps))?;
        report.findings.extend(findings);
        Ok(bundle)
    })?;
    if options.metrics {
        run.stage(Stage::Measure, pieces.len(), |_| {
            let measured: Vec<_> = pieces
                .par_iter()
                .map(|(_, surface, image)| {
                    let quality = measure_piece(surface, image, surface.area() / total);
                    progress.step(Stage::Measure);
                    quality
                })
                .collect();
            let whole = summary(&measured, &pieces);
            for (entry, quality) in bundle.manifest.pieces.iter_mut().zip(&measured) {
                entry.quality = quality.merged(std::mem::take(&mut entry.quality));
            }
            bundle.manifest.quality = whole.merged(std::mem::take(&mut bundle.manifest.quality));
            Ok(())
        })?;
    }
    gate::scale_parts(&mut bundle.manifest.pieces, &pieces);
    run.report.findings.extend(gate::check(&bundle.manifest.pieces, &pieces, options)?);
    let images: Vec<PieceImage> = pieces.into_iter().map(|p| p.2).collect();
    bundle.manifest.accessories = anchor(&mesh, &riders, &images);
    bundle.manifest.source =
        Source { file: source.file_name.clone(), sha256: source.sha256.clone(), extras: source.extras.clone() };
    bundle.manifest.options = options.record();
    bundle.manifest.skeleton = skeleton(&mesh, &bundle);
    bundle.manifest.repairs = run.report.findings.iter().map(repair_entry).collect();
    run.stage(Stage::Encode, 1, |_| {
        bundle.count()?;
        sound(&bundle)
    })?;
    Ok(Built { bundle, report: run.report })
}

/// Checks a bundle against the rules of its format, before anyone sees it. Nothing that a file holds may lead here.
fn sound(bundle: &Bundle) -> Result<()> {
    match gimage_bundle::validate(bundle).first() {
        None => Ok(()),
        Some(fault) => Err(Error::Internal(format!("the bundle breaks a rule of its format: {fault}"))),
    }
}

/// What became of a component.
enum Outcome {
    Piece(Surface, Box<PieceImage>),
    Parts(Parts),
    Accessory(String),
}

/// The parts of every component that was split, as components of their own.
fn name_parts(pieces: &[Component], accessories: &[Component], made: &[Outcome]) -> Vec<Vec<Component>> {
    let mut taken = pieces.iter().chain(accessories).map(|c| c.name.to_lowercase()).collect();
    let named = |(whole, outcome): (&Component, &Outcome)| match outcome {
        Outcome::Parts(parts) => part_components(whole, parts, &mut taken),
        _ => Vec::new(),
    };
    pieces.iter().zip(made).map(named).collect()
}

/// An image this many times as large as its budget is too large: the component is split into parts, if those fit.
const TOO_LARGE: f64 = 1.5;

/// What a component may have of the texels.
#[derive(Clone, Copy)]
enum Share {
    /// An exact size, whatever the area.
    Exact,
    /// So many texels.
    Texels(u32),
    /// Too few for an image.
    TooSmall,
}

/// The share of each component, in their order.
fn shares(components: &[Component], options: &BuildOptions) -> Result<Vec<Share>> {
    let total: f64 = components.iter().map(|c| c.area).sum();
    match options.size {
        ImageSize::Exact(..) => Ok(vec![Share::Exact; components.len()]),
        ImageSize::Texels(n) => {
            let areas: Vec<f64> = components.iter().map(|c| c.area).collect();
            let share = |s: Option<u32>| s.map_or(Share::TooSmall, Share::Texels);
            Ok(budget::share_out(&areas, n).into_iter().map(share).collect())
        }
        ImageSize::Spacing(d) => {
            let share = |component: &Component| {
                let texels = component.area / (d * d);
                if texels > f64::from(gimage_bundle::MAX_PARTICLES) {
                    return Err(Error::TooLarge {
                        what: format!("piece {} at a spacing of {d} m", component.name),
                        need: format!("{texels:.0} texels"),
                        limit: format!("{} texels", gimage_bundle::MAX_PARTICLES),
                        hint: "give a larger spacing".into(),
                    });
                }
                let small = texels.ceil() < f64::from(budget::LEAST_SHARE) && component.area < ALWAYS_PIECE * total;
                Ok(if small { Share::TooSmall } else { Share::Texels(texels.ceil() as u32) })
            };
            components.iter().map(share).collect()
        }
    }
}

fn make(mesh: &Mesh, component: &Component, total: f64, share: Share, options: &BuildOptions) -> Result<Outcome> {
    let texels = match share {
        Share::Exact => None,
        Share::Texels(n) => Some(n),
        Share::TooSmall => {
            let least = budget::LEAST_SHARE;
            return Ok(Outcome::Accessory(format!("its share of the texels is under {least}, too small for a grid")));
        }
    };
    let surface = extract(mesh, component);
    let seam = uv_seams(mesh, &surface);
    let image_options = ImageOptions::new(options, texels);
    let mut image = image(&component.name, &surface, seam.as_deref(), &image_options);
    // The last rung of the ladder: where one image does not hold the surface at its size, or comes out poor.
    let fits = |i: &PieceImage, b: u32| i.closed && f64::from(i.width * i.height) <= TOO_LARGE * f64::from(b);
    // Stretch alone is no reason: parts of a needle are needles.
    let good = |i: &PieceImage, b: u32| fits(i, b) && is_sound(&i.verdict);
    if let Some(b) = texels.filter(|&b| image.as_ref().map_or(true, |i| !good(i, b))) {
        let parts = image_parts(&component.name, &surface, seam.as_deref(), &image_options, b).ok();
        let verdict = parts.as_ref().map(|p| p.verdict(&surface));
        let tried = |kept: bool| Tried { rung: Rung::Split, psnr: verdict.map(|v| v.0.psnr()), kept };
        let better = |i: &PieceImage| {
            let worth = |v: &Verdict, stretch| badness(v, stretch) < WORTH * badness(&i.verdict, i.distortion.linf);
            !fits(i, b) || verdict.is_some_and(|(v, stretch)| passes(&v, stretch) || worth(&v, stretch))
        };
        match (parts, &mut image) {
            (Some(mut parts), image) if image.as_ref().map_or(true, better) => {
                let mut record: Vec<Tried> = image.as_ref().map_or_else(|_| Vec::new(), |i| i.tried.clone());
                record.iter_mut().for_each(|t| t.kept = false);
                record.push(tried(true));
                parts.parts.iter_mut().for_each(|p| p.image.tried.clone_from(&record));
                return Ok(Outcome::Parts(parts));
            }
            (_, Ok(image)) => image.tried.push(tried(false)),
            _ => {}
        }
    }
    let image = image?;
    if let Some(b) = texels
        && component.area < ALWAYS_PIECE * total
        && image.width * image.height > STRETCH * b.max(budget::LEAST_SHARE)
    {
        return Ok(Outcome::Accessory(format!(
            "its border needs {} x {} texels, its share is {b}",
            image.width, image.height
        )));
    }
    Ok(Outcome::Piece(surface, Box::new(image)))
}

/// Makes images again, smaller, until all together have no more texels than asked for; a warning where that fails.
fn keep_budget(
    components: &[Component],
    shares: &[Share],
    outcomes: &mut [Outcome],
    texels: u32,
    one: &(dyn Fn(&Component, Share) -> Result<Outcome> + Sync),
) -> Result<Option<Finding>> {
    let total: f64 = components.iter().map(|c| c.area).sum();
    let size = |o: &Outcome| match o {
        Outcome::Piece(_, i) => i.width * i.height,
        Outcome::Parts(parts) => parts.texels() as u32,
        Outcome::Accessory(_) => 0,
    };
    let pieces: Vec<usize> = (0..outcomes.len()).filter(|&k| size(&outcomes[k]) > 0).collect();
    let mut made: Vec<Made> = pieces
        .iter()
        .map(|&k| {
            let asked = if let Share::Texels(n) = shares[k] { n } else { 0 };
            Made::new(asked, size(&outcomes[k]), components[k].area / total)
        })
        .collect();
    for _ in 0..budget::ROUNDS {
        let again = budget::again(&made, texels);
        if again.is_empty() {
            break;
        }
        let smaller: Vec<Result<Outcome>> =
            again.par_iter().map(|&(m, asked)| one(&components[pieces[m]], Share::Texels(asked))).collect();
        for ((m, asked), outcome) in again.into_iter().zip(smaller) {
            let outcome = match outcome {
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                // There is an image of it already.
                other => other.ok(),
            };
            let keep = made[m].made_again(asked, outcome.as_ref().map(size));
            if let Some(outcome) = outcome.filter(|_| keep) {
                outcomes[pieces[m]] = outcome;
            }
        }
    }
    let names: Vec<&str> = pieces.iter().map(|&k| components[k].name.as_str()).collect();
    Ok(budget::exceeded(&made, &names, texels))
}

/// For each half-edge of the surface whether the first UV set differs across it; `None` without UVs, without seams, or
/// where seams are everywhere and so tell nothing.
fn uv_seams(mesh: &Mesh, surface: &Surface) -> Option<Vec<bool>> {
    let uv = mesh.channel(&Semantic::TexCoord(0))?;
    let twin = crate::base::halfedge::twins(&surface.triangles).ok()?;
    let value = |h: u32| {
        let t = h as usize / 3;
        uv.at(surface.source_triangle[t] as usize, surface.source_corner(t, h as usize % 3))
    };
    let mut seam = vec![false; twin.len()];
    let (mut inner, mut many) = (0usize, 0usize);
    for h in 0..twin.len() as u32 {
        let w = twin[h as usize];
        if w == crate::base::halfedge::BOUNDARY {
            continue;
        }
        inner += 1;
        let next = crate::base::halfedge::next;
        let same_way =
            surface.triangles[h as usize / 3][h as usize % 3] == surface.triangles[w as usize / 3][w as usize % 3];
        let (a, b) = if same_way { (w, next(w)) } else { (next(w), w) };
        seam[h as usize] = value(h) != value(a) || value(next(h)) != value(b);
        many += usize::from(seam[h as usize]);
    }
    (many > 0 && 3 * many < inner).then_some(seam)
}

fn nothing_left(path: &Path, mesh: &Mesh, parts: &[Component], options: &BuildOptions) -> Error {
    let largest = parts.iter().map(|c| c.area).fold(0.0, f64::max);
    let all: f64 = parts.iter().map(|c| c.area).sum();
    if mesh.triangles.is_empty() || all <= 0.0 {
        return Error::Empty {
            path: path.to_path_buf(),
            problem: "no triangle with an area is left after repair".into(),
            hint: "export the garment's mesh again".into(),
        };
    }
    Error::Empty {
        path: path.to_path_buf(),
        problem: format!(
            "none of {} is large enough to be a piece (the largest has {:.2} % of the area, {:.2} % are asked for)",
            words::counted(parts.len(), "loose part", "loose parts"),
            100.0 * largest / all,
            100.0 * options.component.accessory_area
        ),
        hint: "join the parts with --weld METRES, or lower --accessory-area".into(),
    }
}

/// A warning where f32 cannot hold the shape: far from the origin for its size.
fn resolution(mesh: &Mesh) -> Option<Finding> {
    let (lo, hi) = mesh.bounds()?;
    let far = lo.iter().chain(&hi).fold(0.0f64, |m, x| m.max(x.abs()));
    let step = far * f64::from(f32::EPSILON);
    let diagonal = mesh.diagonal();
    (step > 1e-5 * diagonal).then(|| Finding {
        severity: Severity::Warning,
        stage: "component",
        kind: "far-from-origin",
        count: 1,
        examples: vec![format!("coordinates up to {far:.3e} m, diagonal {diagonal:.3e} m")],
        message: format!(
            "The garment is so far from the origin that 32-bit positions are steps of {step:.1e} m; use --center, or move \
             it to the origin."
        ),
    })
}

/// Which components were split.
fn split_up(families: &[Family<'_>]) -> Option<Finding> {
    (!families.is_empty()).then(|| Finding {
        severity: Severity::Note,
        stage: "image",
        kind: "split",
        count: families.len() as u64,
        examples: families.iter().take(MAX_EXAMPLES).map(|f| format!("{} in {} parts", f.whole.name, f.count)).collect(),
        message: "One image does not hold these surfaces at this size: each is several pieces with welded seams between them."
            .into(),
    })
}

fn set_apart(riders: &[Rider<'_>]) -> Option<Finding> {
    (!riders.is_empty()).then(|| Finding {
        severity: Severity::Repair,
        stage: "component",
        kind: "accessories",
        count: riders.len() as u64,
        examples: riders
            .iter()
            .take(MAX_EXAMPLES)
            .map(|r| format!("{} ({}): {}", r.component.name, words::triangles(r.component.triangles.len()), r.reason))
            .collect(),
        message: "Parts that are no cloth get no image and ride on the nearest piece.".into(),
    })
}

/// What the image stage has to say about a piece.
fn remarks(name: &str, image: &PieceImage) -> Vec<Finding> {
    let one = |severity, kind, count: usize, message: &str| Finding {
        severity,
        stage: "image",
        kind,
        count: count as u64,
        examples: vec![format!("piece {name}")],
        message: message.into(),
    };
    let mut out = Vec::new();
    if !image.closed {
        let text = "The image does not weld to a surface of the piece's own topology; give it more texels.";
        out.push(one(Severity::Warning, "topology", 1, text));
    }
    let texels = image.width * image.height;
    if let Some(share) = image.budget.filter(|&b| f64::from(texels) > OVER * f64::from(b.max(budget::LEAST_SHARE))) {
        out.push(Finding {
            examples: vec![format!("piece {name}: {} x {} texels, its share is {share}", image.width, image.height)],
            ..one(
                Severity::Warning,
                "over-budget",
                1,
                "The border needs more texels than the piece's share; close small holes, or split the piece.",
            )
        });
    }
    if image.moved > 0 {
        let text =
            "Texels beside the end of a cut were sampled a fraction of a texel further in, so that the image welds.";
        out.push(one(Severity::Note, "moved-texels", image.moved, text));
    }
    match image.fit {
        Some(FitRecord::Failed) => {
            let text =
                "The least-squares fit broke down; the texels lie where they were sampled. Give other texel counts.";
            out.push(one(Severity::Warning, "fit-failed", 1, text));
        }
        Some(FitRecord::Dropped) => {
            let text =
                "The least-squares fit did not come closer than sampling; the texels lie where they were sampled.";
            out.push(one(Severity::Note, "fit-dropped", 1, text));
        }
        Some(FitRecord::Kept(back)) if back > 0 => {
            let text = "Texels that the fit moved too far lie where they were sampled.";
            out.push(one(Severity::Note, "fit-restrained", back, text));
        }
        _ => {}
    }
    let p = &image.parameterize;
    if p.newton.steps == 0 && !p.newton.converged {
        let text = "The minimiser could not proceed; the flip-free start stands.";
        out.push(one(Severity::Warning, "start-kept", 1, text));
    } else if p.newton.capped {
        let text =
            "The minimiser stopped at its cap of work while the map still improved; fewer triangles get further.";
        out.push(one(Severity::Note, "work-cap", 1, text));
    } else if !p.newton.converged {
        let text = "The minimiser stopped before it converged; the map is flip-free but could be less distorted.";
        out.push(one(Severity::Note, "not-converged", 1, text));
    }
    out
}

/// One finding of each kind for all pieces, in the order they first occur.
fn merged(findings: impl Iterator<Item = Finding>) -> Vec<Finding> {
    let mut out: Vec<Finding> = Vec::new();
    for f in findings {
        match out.iter_mut().find(|o| o.kind == f.kind) {
            Some(o) => {
                o.count += f.count;
                o.examples.extend(f.examples);
                o.examples.truncate(MAX_EXAMPLES);
            }
            None => out.push(f),
        }
    }
    out
}

fn skeleton(mesh: &Mesh, bundle: &Bundle) -> Option<Skeleton> {
    let used = bundle.images.keys().any(|(_, kind)| matches!(kind, gimage_bundle::MapKind::Joints(_)));
    (used && !mesh.skeleton.joints.is_empty()).then(|| Skeleton {
        joints: mesh
            .skeleton
            .joints
            .iter()
            .map(|j| Joint { name: j.name.clone(), parent: j.parent, inverse_bind: j.inverse_bind.map(|x| x as f32) })
            .collect(),
    })
}

fn repair_entry(f: &Finding) -> Repair {
    Repair {
        severity: match f.severity {
            Severity::Note => "note",
            Severity::Repair => "repair",
            Severity::Warning => "warning",
        }
        .into(),
        stage: f.stage.into(),
        kind: f.kind.into(),
        count: f.count,
        examples: f.examples.clone(),
        message: f.message.clone(),
    }
}
