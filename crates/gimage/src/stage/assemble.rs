//! Finished pieces -> the maps and the manifest of a bundle.

pub(crate) mod accessory;
pub(crate) mod attributes;
pub mod backstops;
pub mod blends;
pub mod limits;
pub mod mass;
mod parts;
pub mod pins;
pub mod springs;
mod texels;

use gimage_bundle::manifest::{Cut, Quality as ManifestQuality, Surface as SurfaceEntry};
use gimage_bundle::{Bundle, Image, MapKind, Particle};
use rayon::prelude::*;
use serde_json::json;

use crate::base::locate::Locator;
use crate::base::mesh::Mesh;
use crate::base::surface::Surface;
use crate::error::{Error, Result};
use crate::options::{BuildOptions, Range, RestLength, stage_options};
use crate::record::Finding;
use crate::stage::assemble::attributes::{attributes, places};
use crate::stage::assemble::backstops::Backstop;
use crate::stage::assemble::blends::Blend;
use crate::stage::assemble::limits::{Limit, Stored};
use crate::stage::assemble::mass::{Masses, mass};
use crate::stage::assemble::pins::{Pin, PinRule, unmet};
use crate::stage::assemble::springs::{Rest, RestLengths, springs};
use crate::stage::assemble::texels::{Texels, pinned};
use crate::stage::component::Component;
use crate::stage::cut::CutRecord;
use crate::stage::cut::disk::NONE;
use crate::stage::hold::Held;
use crate::stage::image::PieceImage;
use crate::stage::measure::stretch::spring_anisotropy;
use crate::stage::measure::{MeasureOptions, Quality, measure};

pub use parts::Family;
pub(crate) use parts::part_components;

stage_options! {
    /// Options of [`assemble`].
    pub struct AssembleOptions of "assemble" {
        /// Rest lengths: straight distance (chord), or distance along the surface (arc).
        pub rest: RestLength = RestLength::Chord => "rest" [""] Range::Any;
        /// Pin particles, may be repeated: above:Y, below:Y, box:X0,Y0,Z0,X1,Y1,Z1 (metres), top:SHARE (of the height of each
        /// garment), loop:K (boundary loop, longest first), loop:top, loop:bottom (by mean height), loop:any, material:NAME, node:NAME (* stands for any text), joint:NAME<D
        /// (within D metres of a joint), attr:_NAME>T or color:r>T; combined by not, and, or and parentheses. The bundle then stores tethers: the distance of each
        /// particle to the nearest pin.
        pub pins: Vec<Pin> = Vec::new() => "pin" [""] Range::Any;
        /// Pins beside those of --pin: none (flags); where an attribute _PIN of the file is above 0.5 (file, the default of gimage
        /// build); also where garments rest on the body, with limits that grow from there (auto, the default of gimage dress
        /// without --pin and _PIN).
        pub rule: Option<PinRule> = None => "pins" [""] Range::Any;
        /// Keep particles within this distance of their positions at rest, may be repeated; EXPR as for --pin. The smallest
        /// distance counts, also of those in an attribute _LIMIT or _MAX_DISTANCE of the file.
        pub limits: Vec<Limit> = Vec::new() => "limit" ["m"] Range::Any;
        /// Keep particles out of a sphere behind them that begins this distance behind their positions at rest, with a radius of 0.1 m
        /// or RADIUS, may be repeated; EXPR as for --pin. The smallest distance counts, also of those in an attribute _BACKSTOP of
        /// the file.
        pub backstops: Vec<Backstop> = Vec::new() => "backstop" ["m"] Range::Any;
        /// Draw the render mesh on the skin (0), on the cloth (1) or between them where particles meet an expression, may be
        /// repeated; EXPR as for --pin. The last one counts, before those of an attribute _BLEND of the file and of --blend-width.
        pub blends: Vec<Blend> = Vec::new() => "blend" [""] Range::Any;
    }
}

/// A piece on its way into the bundle.
#[derive(Clone, Debug)]
pub struct Piece<'a> {
    /// The component, or the part of one, that it is.
    pub component: &'a Component,
    /// Its surface.
    pub surface: Surface,
    /// The image of that.
    pub image: PieceImage,
}

/// Everything of one piece but its place in the bundle.
struct Made {
    maps: Vec<(MapKind, Image)>,
    findings: Vec<Finding>,
    pinned: Vec<bool>,
    /// For each pin whether a particle of the piece meets it.
    met: Vec<bool>,
    /// The limit \[m\] of each texel, infinite for none; `None` if no texel has one.
    limits: Option<Vec<f32>>,
    /// For each option of limits whether a particle of the piece meets it.
    limits_met: Vec<bool>,
    /// Distance and radius \[m\] of the backstop of each texel, an infinite distance for none; `None` if no texel has one.
    backstops: Option<Vec<[f32; 2]>>,
    /// For each option of backstops whether a particle of the piece meets it.
    backstops_met: Vec<bool>,
    /// The blend of each texel; `None` if it is 1 everywhere.
    blends: Option<Vec<f32>>,
    /// For each option of blends whether a particle of the piece meets it.
    blends_met: Vec<bool>,
    rest: RestLengths,
    mass: Masses,
}

impl Made {
    /// With more pins, limits and backstops.
    fn with(mut self, held: Option<&Held>) -> Self {
        let Some(held) = held else { return self };
        self.pinned.iter_mut().zip(&held.pinned).for_each(|(all, one)| *all |= one);
        let mut limits = self.limits.take().unwrap_or_else(|| vec![f32::INFINITY; self.pinned.len()]);
        limits.iter_mut().zip(&held.limits).for_each(|(all, one)| *all = all.min(*one));
        self.limits = limits.iter().any(|x| x.is_finite()).then_some(limits);
        self.backstops = backstops::nearest(self.backstops.take(), &held.behind);
        self
    }
}

/// Adds all pieces with their maps to an empty bundle, those of a family joined; returns what is worth saying about the maps.
/// `held` has more pins and limits for each piece, or is empty; `step` is called from any thread after each piece.
///
/// Errors: [`Error::TooLarge`] for a position that f32 cannot hold, and what the bundle finds wrong.
pub fn assemble(
    bundle: &mut Bundle,
    mesh: &Mesh,
    pieces: &[Piece<'_>],
    families: &[Family<'_>],
    held: &[Held],
    options: &BuildOptions,
    step: &(dyn Fn() + Sync),
) -> Result<Vec<Finding>> {
    check_range(pieces)?;
    let loops = loop_order(pieces);
    let owner = parts::owners(pieces.len(), families);
    let heights = by_height(pieces, &owner, &loops);
    let spans = spans(pieces, &owner);
    let made: Vec<Result<Made>> = pieces
        .par_iter()
        .enumerate()
        .map(|(k, piece)| {
            let family = Kin { owner: owner[k], span: spans[k], loops: &loops, heights: &heights };
            let found = held.get(k).map_or(&[][..], |held| &held.blend);
            let out = make(mesh, &family, piece, found, options).map(|made| made.with(held.get(k)));
            step();
            out
        })
        .collect();
    let mut made = made.into_iter().collect::<Result<Vec<Made>>>()?;
    parts::agree(&mut made, pieces, families);
    let links = parts::links(pieces, families);
    let mut findings = Vec::new();
    let (mut met, mut limits_met) =
        (vec![false; options.assemble.pins.len()], vec![false; options.assemble.limits.len()]);
    let mut backstops_met = vec![false; options.assemble.backstops.len()];
    let mut backstops = Vec::new();
    let (mut blends, mut blends_met) = (Vec::new(), vec![false; options.assemble.blends.len()]);
    let mut is_pinned = false;
    for ((piece, mut made), links) in pieces.iter().zip(made).zip(links) {
        is_pinned |= made.pinned.contains(&true);
        met.iter_mut().zip(&made.met).for_each(|(all, one)| *all |= one);
        limits_met.iter_mut().zip(&made.limits_met).for_each(|(all, one)| *all |= one);
        backstops_met.iter_mut().zip(&made.backstops_met).for_each(|(all, one)| *all |= one);
        backstops.push(made.backstops.take());
        blends_met.iter_mut().zip(&made.blends_met).for_each(|(all, one)| *all |= one);
        blends.push(made.blends.take());
        findings.extend(add(bundle, piece, made, &links, options)?);
    }
    parts::declare(bundle, families);
    backstops::write(bundle, backstops)?;
    blends::write(bundle, blends)?;
    if is_pinned {
        bundle.write_tethers()?;
    }
    let bounds = bounds(pieces);
    findings.extend(unmet("pin", &options.assemble.pins, &met, bounds, loops.len(), mesh));
    findings.extend(unmet("limit", &options.assemble.limits, &limits_met, bounds, loops.len(), mesh));
    findings.extend(unmet("backstop", &options.assemble.backstops, &backstops_met, bounds, loops.len(), mesh));
    findings.extend(unmet("blend", &options.assemble.blends, &blends_met, bounds, loops.len(), mesh));
    Ok(findings)
}

/// Adds a piece with its maps and its entry; `links` are those of its texels. Returns the findings of its maps.
fn add(
    bundle: &mut Bundle,
    piece: &Piece<'_>,
    made: Made,
    links: &[u32],
    options: &BuildOptions,
) -> Result<Vec<Finding>> {
    let Piece { component, image, .. } = piece;
    let k = bundle.add_piece(&component.name, image.width, image.height)?;
    let map = |channels: u32, data: Vec<f32>| Image { width: image.width, height: image.height, channels, data };
    bundle.insert(k, MapKind::Position, map(4, positions(image, &made.pinned, links)?))?;
    let entry = &mut bundle.manifest.pieces[k];
    entry.constants.density = Some(options.mass.density);
    entry.constants.area = Some(component.area);
    entry.cut = Some(cut_entry(&image.cut));
    entry.surface = Some(SurfaceEntry {
        euler: component.euler as i32,
        loops: component.loops as u32,
        area: component.area,
        triangles: component.triangles.len() as u32,
    });
    entry.quality = map_quality(image, &made.rest, &made.mass);
    crate::stage::gate::note(entry, piece);
    match made.rest {
        RestLengths::Constant(c) => entry.constants.rest = Some(c),
        RestLengths::Image(lengths) => {
            bundle.insert(k, MapKind::Rest, map(4, lengths.into_iter().flatten().collect()))?;
        }
    }
    match made.mass {
        Masses::Constant(m) => bundle.manifest.pieces[k].constants.mass = Some(m),
        Masses::Image(m) => bundle.insert(k, MapKind::Mass, map(1, m))?,
    }
    match made.limits.and_then(Stored::new) {
        Some(Stored::Constant(limit)) => bundle.manifest.pieces[k].constants.limit = Some(limit),
        Some(Stored::Image(limits)) => bundle.insert(k, MapKind::Limit, map(1, limits))?,
        None => {}
    }
    for (kind, image) in made.maps {
        bundle.insert(k, kind, image)?;
    }
    Ok(made.findings)
}

/// The texels of the position map: x, y, z and the code of the particle.
fn positions(image: &PieceImage, pinned: &[bool], links: &[u32]) -> Result<Vec<f32>> {
    let mut data = Vec::with_capacity(4 * image.grid.positions.len());
    for (at, p) in image.grid.positions.iter().enumerate() {
        let next = (links[at] != NONE).then_some(links[at]);
        let particle = if pinned[at] { Particle::Pinned { next } } else { Particle::Free { next } };
        let code = particle.code().map_err(|e| Error::Internal(format!("particle code: {e}")))?;
        data.extend([p[0] as f32, p[1] as f32, p[2] as f32, code]);
    }
    Ok(data)
}

fn cut_entry(cut: &CutRecord) -> Cut {
    Cut {
        length: cut.length,
        edges: cut.edges,
        method: match (cut.edges > 0, cut.uv_seams) {
            (false, _) => "none".into(),
            (true, true) => format!("uv-seams, grown to {} points", cut.grown),
            (true, false) => format!("shortest, grown to {} points", cut.grown),
        },
        distortion_shortest: cut.bought.map(|b| b[0]),
        distortion: cut.bought.map(|b| b[1]),
    }
}

/// The box around the texels of all pieces \[m\].
fn bounds(pieces: &[Piece<'_>]) -> Option<([f64; 3], [f64; 3])> {
    let mut all = pieces.iter().flat_map(|Piece { image, .. }| &image.grid.positions).copied();
    let first = all.next()?;
    Some(all.fold((first, first), |(lo, hi), p| {
        (std::array::from_fn(|k| lo[k].min(p[k])), std::array::from_fn(|k| hi[k].max(p[k])))
    }))
}

/// f32 holds every position.
fn check_range(pieces: &[Piece<'_>]) -> Result<()> {
    for Piece { component, image, .. } in pieces {
        if image.grid.positions.iter().flatten().any(|x| !(*x as f32).is_finite()) {
            return Err(Error::Piece {
                piece: component.name.clone(),
                stage: "resample",
                problem: "a position does not fit 32 bits".into(),
                hint: "scale the garment with --unit".into(),
            });
        }
    }
    Ok(())
}

/// All boundary loops of the garment as (piece, loop of the piece), longest first.
fn loop_order(pieces: &[Piece<'_>]) -> Vec<(usize, u32)> {
    let mut all: Vec<(f64, usize, u32)> = pieces
        .iter()
        .enumerate()
        .flat_map(|(k, Piece { image, .. })| {
            image.loop_lengths.iter().enumerate().map(move |(l, length)| (*length, k, l as u32))
        })
        .collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    all.into_iter().map(|x| (x.1, x.2)).collect()
}

/// The same loops, the highest first, by the mean height of their texels. `owner` has the piece that names the loops of each piece.
fn by_height(pieces: &[Piece<'_>], owner: &[usize], loops: &[(usize, u32)]) -> Vec<(usize, u32)> {
    let mut sums: std::collections::BTreeMap<(usize, u32), (f64, u32)> = Default::default();
    for (Piece { image, .. }, owner) in pieces.iter().zip(owner) {
        for (of, p) in image.loop_of.iter().zip(&image.grid.positions) {
            let sum = sums.entry((*owner, *of)).or_default();
            (sum.0, sum.1) = (sum.0 + p[1], sum.1 + 1);
        }
    }
    let height = |l: &(usize, u32)| sums.get(l).map_or(f64::NEG_INFINITY, |(sum, n)| sum / f64::from(*n));
    let mut order: Vec<_> = loops.iter().filter(|l| sums.contains_key(l)).copied().collect();
    order.sort_by(|a, b| height(b).total_cmp(&height(a)).then(a.cmp(b)));
    order
}

/// For each piece the lowest and the highest point of its family \[m\].
fn spans(pieces: &[Piece<'_>], owner: &[usize]) -> Vec<[f64; 2]> {
    let mut spans = vec![[f64::INFINITY, f64::NEG_INFINITY]; pieces.len()];
    for (Piece { image, .. }, owner) in pieces.iter().zip(owner) {
        let span = &mut spans[*owner];
        *span = image.grid.positions.iter().fold(*span, |[low, high], p| [low.min(p[1]), high.max(p[1])]);
    }
    owner.iter().map(|k| spans[*k]).collect()
}

/// The garment around a piece, as far as expressions refer to it.
struct Kin<'a> {
    /// As [`Texels::piece`].
    owner: usize,
    /// As [`Texels::span`].
    span: [f64; 2],
    /// As [`Texels::loops`].
    loops: &'a [(usize, u32)],
    /// As [`Texels::heights`].
    heights: &'a [(usize, u32)],
}

fn make(
    mesh: &Mesh,
    kin: &Kin<'_>,
    Piece { component, surface, image }: &Piece<'_>,
    found: &[f32],
    options: &BuildOptions,
) -> Result<Made> {
    let places = places(image, surface);
    let (maps, findings) = attributes(mesh, &component.name, image, &places);
    let rest = match options.assemble.rest {
        RestLength::Chord => springs(&image.grid, Rest::Chord),
        RestLength::Arc => {
            let (w, h) = (image.grid.width - 1, image.grid.height - 1);
            let locator = Locator::new(&image.disk, &image.uv, w, h);
            let point = |u: f64, v: f64| {
                let q = [u.clamp(0.0, w as f64), v.clamp(0.0, h as f64)];
                locator.at(q).map_or([0.0; 3], |s| s.position(&image.disk))
            };
            springs(&image.grid, Rest::Arc(&point))
        }
    };
    let mass = mass(&image.grid, component.area, &options.mass).map_err(|error| match error {
        Error::Option { problem, hint, .. } => {
            Error::Piece { piece: component.name.clone(), stage: "mass", problem, hint }
        }
        other => other,
    })?;
    let Kin { owner: piece, span, loops, heights } = *kin;
    let texels = Texels { mesh, piece, span, image, places: &places, loops, heights };
    let (pinned, met) = pinned(&texels, &options.assemble.pins);
    let (limits, limits_met) = limits::limits(&texels, &options.assemble.limits, options.import.unit);
    let (backstops, backstops_met) = backstops::backstops(&texels, &options.assemble.backstops, options.import.unit);
    let (blends, blends_met) = blends::blends(&texels, &options.assemble.blends, found);
    Ok(Made {
        maps,
        findings,
        pinned,
        met,
        limits,
        limits_met,
        backstops,
        backstops_met,
        blends,
        blends_met,
        rest,
        mass,
    })
}

/// Quality of a map as far as it is known without measuring distances.
fn map_quality(image: &PieceImage, rest: &RestLengths, mass: &Masses) -> ManifestQuality {
    let d = &image.distortion;
    let mut quality = ManifestQuality {
        stretch_l2: Some(d.l2),
        stretch_max: Some(d.linf),
        symmetric_dirichlet: Some(d.symmetric_dirichlet),
        flips: Some(d.flips as u64),
        ..ManifestQuality::default()
    };
    if let Some(a) = spring_anisotropy(&image.grid, rest) {
        quality.spring_anisotropy = Some(a.longest_to_shortest);
        quality.more.insert("spring_p99_to_p1".into(), json!(a.p99_to_p1));
        quality.more.insert("spring_angle_degrees".into(), json!(a.angle_deviation));
    }
    quality.more.insert("mass_p99_to_p1".into(), json!(mass.spread(&image.grid)));
    let gap = |ring: Vec<u32>| {
        let first = image.grid.stored(ring[0]);
        ring.iter().map(|&k| crate::base::vec3::distance(first, image.grid.stored(k))).fold(0.0, f64::max)
    };
    quality.seam_gap = Some(image.grid.rings().map(gap).fold(0.0, f64::max));
    quality
}

/// Distances of one piece, and the weight it has in the whole.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    quality: Option<Quality>,
    area: f64,
}

/// Samples per side for the whole garment; a piece gets its share, and no fewer than [`LEAST_SAMPLES`].
const SAMPLES: f64 = 200_000.0;
const LEAST_SAMPLES: usize = 5_000;

/// Measures a piece against the surface it was made from.
pub(crate) fn measure_piece(surface: &Surface, image: &PieceImage, share: f64) -> Measured {
    let (positions, triangles) = image.grid.welded();
    let samples = ((SAMPLES * share) as usize).max(LEAST_SAMPLES);
    let options = MeasureOptions { samples, ..MeasureOptions::default() };
    Measured {
        quality: measure(&surface.positions, &surface.triangles, &positions, &triangles, &options),
        area: surface.area(),
    }
}

impl Measured {
    /// These distances on top of what is known already.
    pub(crate) fn merged(&self, known: ManifestQuality) -> ManifestQuality {
        match &self.quality {
            Some(q) => distances(q, known),
            None => known,
        }
    }
}

fn distances(q: &Quality, known: ManifestQuality) -> ManifestQuality {
    let rms = q.rms_source_to_image.max(q.rms_image_to_source);
    let mut out = ManifestQuality {
        psnr: q.psnr.is_finite().then_some(q.psnr),
        rms: Some(rms),
        rms_rel: (q.diagonal > 0.0).then(|| rms / q.diagonal),
        hausdorff: Some(q.hausdorff),
        hausdorff_rel: Some(q.hausdorff_relative),
        diagonal: Some(q.diagonal),
        normal_degrees: Some(q.normal_error_mean),
        fold_area: Some(q.fold_area),
        ..known
    };
    out.more.insert("samples".into(), json!(q.samples));
    // Where queries are expensive the largest distances are sampled too.
    out.more.insert("sampled_vertices".into(), json!(q.vertices));
    out
}

/// The whole garment: RMS distances by area, the largest of the largest, the diagonal of all pieces together.
pub(crate) fn summary(measured: &[Measured], pieces: &[Piece<'_>]) -> Measured {
    let known: Vec<(&Quality, f64)> = measured.iter().filter_map(|m| Some((m.quality.as_ref()?, m.area))).collect();
    let area: f64 = known.iter().map(|x| x.1).sum();
    let Some((first, _)) = known.first() else { return Measured { quality: None, area } };
    let mean = |f: &dyn Fn(&Quality) -> f64| known.iter().map(|(q, a)| f(q) * a).sum::<f64>() / area.max(1e-300);
    let top = |f: &dyn Fn(&Quality) -> f64| known.iter().map(|(q, _)| f(q)).fold(0.0, f64::max);
    let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in pieces.iter().flat_map(|Piece { surface, .. }| &surface.positions) {
        (0..3).for_each(|c| (lo[c], hi[c]) = (lo[c].min(p[c]), hi[c].max(p[c])));
    }
    let diagonal = crate::base::vec3::distance(lo, hi);
    let out = mean(&|q| q.rms_source_to_image.powi(2)).sqrt();
    let back = mean(&|q| q.rms_image_to_source.powi(2)).sqrt();
    let hausdorff = top(&|q| q.hausdorff);
    let quality = Quality {
        diagonal,
        rms_source_to_image: out,
        rms_image_to_source: back,
        psnr: 20.0 * (diagonal / out.max(back)).log10(),
        hausdorff_source_to_image: top(&|q| q.hausdorff_source_to_image),
        hausdorff_image_to_source: top(&|q| q.hausdorff_image_to_source),
        hausdorff,
        hausdorff_relative: hausdorff / diagonal.max(1e-300),
        normal_error_mean: mean(&|q| q.normal_error_mean),
        fold_area: mean(&|q| q.fold_area),
        area_ratio: mean(&|q| q.area_ratio),
        samples: first.samples,
        vertices: known.iter().map(|(q, _)| q.vertices).fold(1.0, f64::min),
    };
    Measured { quality: Some(quality), area }
}
