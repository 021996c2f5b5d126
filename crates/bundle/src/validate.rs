//! Validation of a bundle against the rules of the format, texel by texel.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;

use crate::body;
use crate::bundle::Bundle;
use crate::counts::{count_pieces, piece_particles, spring_fits};
use crate::error::{Error, Result};
use crate::manifest::{MANIFEST_FILE, PieceEntry};
use crate::map::{Image, MapKind};
use crate::particle::Particle;
use crate::render::{RENDER_FILE, check_render};
use crate::rings::{LinkFault, Rings, find_rings};
use crate::stitch;
use crate::welded::welded;

/// Largest number of listed faults per kind; one more fault counts the rest.
pub const MAX_LISTED: usize = 20;

/// The rule that is broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum FaultKind {
    /// A file is missing, damaged, too large or of the wrong size.
    Unreadable,
    /// A file is not the one that was written.
    Checksum,
    /// A file has no record in the manifest, so that damage to it would go unseen.
    Unlisted,
    /// The manifest contradicts itself.
    Manifest,
    /// A number is NaN or infinite where a particle exists.
    NotFinite,
    /// A particle code is not legal.
    Code,
    /// A seam link leads nowhere, or its ring does not close.
    Ring,
    /// Duplicates of a seam point differ in a map that must agree.
    Seam,
    /// Duplicates of a seam point are not all free or all pinned.
    Pin,
    /// A rest length is negative, or not 0 where no spring can be.
    Rest,
    /// A mass is not positive.
    Mass,
    /// A tether is negative, or its anchor is not a pinned particle.
    Tether,
    /// The radius of a backstop is not above 0.
    Backstop,
    /// A share of the blend from skin to cloth is not between 0 and 1.
    Blend,
    /// A stitch leads to no point of a piece, or its length is negative.
    Stitch,
    /// A joint index is not that of a joint.
    Joint,
    /// Weights are negative or do not sum to 1.
    Weight,
    /// A count in the manifest is not that of the images.
    Count,
    /// The parts of a component do not weld to its surface.
    Topology,
    /// The mesh of the source is damaged, or a vertex is not bound to a point of a piece.
    Render,
}

/// One broken rule.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fault {
    /// The file, manifest.json included.
    pub file: String,
    /// The piece by name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub piece: Option<String>,
    /// The texel: column, row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texel: Option<(u32, u32)>,
    /// The rule.
    pub kind: FaultKind,
    /// One sentence for people, without the place.
    pub message: String,
}

impl Fault {
    /// The fault that corresponds to a reading error.
    pub fn from_error(error: &Error) -> Self {
        let (file, piece, texel, kind) = match error {
            Error::Checksum { file } => (file.clone(), None, None, FaultKind::Checksum),
            Error::Missing { file } | Error::Exr { file, .. } | Error::Size { file, .. } => {
                (file.clone(), None, None, FaultKind::Unreadable)
            }
            Error::Render { .. } => (RENDER_FILE.into(), None, None, FaultKind::Render),
            Error::Map { piece, .. } => (MANIFEST_FILE.into(), Some(piece.clone()), None, FaultKind::Unreadable),
            Error::Code { piece, i, j, .. } => {
                (MANIFEST_FILE.into(), Some(piece.clone()), Some((*i, *j)), FaultKind::Code)
            }
            Error::Manifest { .. } | Error::NotFinite { .. } | Error::FileName { .. } => {
                (MANIFEST_FILE.into(), None, None, FaultKind::Manifest)
            }
            Error::Io { path, .. } => {
                let name = path.file_name().unwrap_or(path.as_os_str());
                (name.to_string_lossy().into_owned(), None, None, FaultKind::Unreadable)
            }
            _ => (MANIFEST_FILE.into(), None, None, FaultKind::Unreadable),
        };
        Fault { file, piece, texel, kind, message: error.to_string() }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.file)?;
        if let Some(piece) = &self.piece {
            write!(f, "piece {piece}: ")?;
        }
        if let Some((i, j)) = self.texel {
            write!(f, "texel ({i}, {j}): ")?;
        }
        write!(f, "{}", self.message)
    }
}

/// The exit code of `gimage validate`: 0 sound, 1 findings, 2 unreadable.
pub fn exit_code(faults: &[Fault]) -> u8 {
    match faults {
        [] => 0,
        _ if faults.iter().any(|f| f.kind == FaultKind::Unreadable) => 2,
        _ => 1,
    }
}

/// Every rule that the bundle breaks; empty for a sound one. Of each kind the first [`MAX_LISTED`] are listed. Never
/// panics, whatever the manifest and the images hold.
pub fn validate(bundle: &Bundle) -> Vec<Fault> {
    let mut found = Findings { bundle, listed: Vec::new(), counts: BTreeMap::new() };
    if let Err(error) = bundle.manifest.check() {
        // Without sound ranges and sizes nothing further has a meaning.
        return vec![Fault::from_error(&error)];
    }
    if let Some(field) = bundle.manifest.not_finite() {
        found.manifest(FaultKind::NotFinite, None, format!("{field} is not a finite number"));
    }
    check_shapes(&mut found);
    if !found.listed.is_empty() {
        return found.finish();
    }
    check_colliders(&mut found);
    let particles = read_codes(&mut found);
    for (index, piece) in bundle.manifest.pieces.iter().enumerate() {
        check_piece(&mut found, index, piece, &particles);
    }
    let (rings, links) = find_rings(&particles);
    for (index, link) in links {
        let message = match link {
            LinkFault::OutOfRange(to) => format!("the seam link leads to particle {to}, past the last one"),
            LinkFault::Itself => "the seam link leads to its own texel".into(),
            LinkFault::NotASeam(to) => format!("the seam link leads to particle {to}, which is not on a seam"),
            LinkFault::Shared(to) => format!("the ring does not close: another link leads to particle {to} too"),
        };
        found.particle(FaultKind::Ring, index, &MapKind::Position, message);
    }
    check_rings(&mut found, &particles, &rings);
    check_counts(&mut found, &particles, &rings);
    if found.listed.is_empty() {
        check_components(&mut found, &particles, &rings);
        check_render(bundle, &particles).into_iter().for_each(|fault| found.push(fault));
    }
    found.finish()
}

/// Reads a bundle as [`Bundle::decode_lenient`] and validates what could be read. Errors only where the manifest cannot
/// be read or the images take more memory than a bundle may, which is exit code 2.
pub fn validate_files(read: impl FnMut(&str, u64) -> Result<Vec<u8>>) -> Result<(Bundle, Vec<Fault>)> {
    let (bundle, mut faults) = Bundle::decode_lenient(read)?;
    for (piece, file) in bundle.manifest.pieces.iter().flat_map(|p| p.maps.values().map(move |file| (p, file))) {
        if !bundle.manifest.files.contains_key(file) {
            let message = "the manifest records no SHA-256 for the file".into();
            let piece = Some(piece.name.clone());
            faults.push(Fault { file: file.clone(), piece, texel: None, kind: FaultKind::Unlisted, message });
        }
    }
    if bundle.manifest.render.is_some() && !bundle.manifest.files.contains_key(RENDER_FILE) {
        let message = "the manifest records no SHA-256 for the file".into();
        let file = RENDER_FILE.into();
        faults.push(Fault { file, piece: None, texel: None, kind: FaultKind::Unlisted, message });
    }
    for file in bundle.manifest.body.iter().flat_map(body::files) {
        if !bundle.manifest.files.contains_key(&file.name) {
            let message = "the manifest records no SHA-256 for the file".into();
            faults.push(Fault { file: file.name, piece: None, texel: None, kind: FaultKind::Unlisted, message });
        }
    }
    // Counts, links and positions of a bundle with holes would only repeat that there are holes.
    if faults.iter().all(|f| f.kind != FaultKind::Unreadable) {
        faults.extend(validate(&bundle));
    }
    Ok((bundle, faults))
}

struct Findings<'a> {
    bundle: &'a Bundle,
    listed: Vec<Fault>,
    counts: BTreeMap<FaultKind, (usize, String)>,
}

impl Findings<'_> {
    fn push(&mut self, fault: Fault) {
        let (count, _) = self.counts.entry(fault.kind).or_insert((0, fault.file.clone()));
        *count += 1;
        if *count <= MAX_LISTED {
            self.listed.push(fault);
        }
    }

    fn manifest(&mut self, kind: FaultKind, piece: Option<&PieceEntry>, message: String) {
        let piece = piece.map(|p| p.name.clone());
        self.push(Fault { file: MANIFEST_FILE.into(), piece, texel: None, kind, message });
    }

    fn texel(&mut self, kind: FaultKind, piece: usize, k: usize, map: &MapKind, message: String) {
        let entry = &self.bundle.manifest.pieces[piece];
        let texel = Some((k as u32 % entry.width, k as u32 / entry.width));
        let file = self.bundle.file_name(piece, map);
        let piece = Some(entry.name.clone());
        self.push(Fault { file, piece, texel, kind, message });
    }

    fn particle(&mut self, kind: FaultKind, index: u32, map: &MapKind, message: String) {
        if let Some((piece, k)) = self.bundle.locate(index) {
            self.texel(kind, piece, k, map, message);
        }
    }

    fn finish(mut self) -> Vec<Fault> {
        for (kind, (count, file)) in self.counts {
            if count > MAX_LISTED {
                let message = format!("and {} more of this kind", count - MAX_LISTED);
                self.listed.push(Fault { file, piece: None, texel: None, kind, message });
            }
        }
        self.listed
    }
}

/// Sizes, channels and presence: what every later check relies on.
fn check_colliders(found: &mut Findings) {
    for (n, entry) in found.bundle.manifest.colliders.iter().enumerate() {
        if let Some(fault) = entry.fault() {
            found.manifest(FaultKind::Manifest, None, format!("collider {n}: {fault}"));
        }
    }
    let joints = found.bundle.manifest.skeleton.as_ref().map_or(0, |s| s.joints.len());
    if let Some(fault) = found.bundle.body.as_ref().and_then(|body| body.fault(joints)) {
        found.manifest(FaultKind::Manifest, None, fault);
    }
}

fn check_shapes(found: &mut Findings) {
    let bundle = found.bundle;
    for ((index, kind), image) in &bundle.images {
        let Some(piece) = bundle.manifest.pieces.get(*index) else {
            found.manifest(
                FaultKind::Manifest,
                None,
                format!("map {} belongs to piece {index}, which does not exist", kind.name()),
            );
            continue;
        };
        let fits = (image.width, image.height) == (piece.width, piece.height);
        if !fits || !kind.channels().contains(&image.channels) || image.check("").is_err() {
            let message = format!("map {} has the wrong size or number of channels", kind.name());
            found.manifest(FaultKind::Manifest, Some(piece), message);
        }
    }
    for (index, piece) in bundle.manifest.pieces.iter().enumerate() {
        if bundle.image(index, &MapKind::Position).is_none() {
            found.manifest(FaultKind::Manifest, Some(piece), "the piece has no position map".into());
        }
    }
}

/// The particles of the bundle; a texel with a bad code counts as none.
fn read_codes(found: &mut Findings) -> Vec<Particle> {
    let mut particles = Vec::new();
    for (index, piece) in found.bundle.manifest.pieces.iter().enumerate() {
        let positions = found.bundle.image(index, &MapKind::Position);
        for k in 0..piece.width as usize * piece.height as usize {
            let code = positions.and_then(|p| p.at(k).get(3)).copied().unwrap_or(0.0);
            particles.push(Particle::from_code(code).unwrap_or_else(|error| {
                found.texel(FaultKind::Code, index, k, &MapKind::Position, error.to_string());
                Particle::None
            }));
        }
    }
    particles
}

fn check_piece(found: &mut Findings, index: usize, piece: &PieceEntry, all: &[Particle]) {
    let particles = piece_particles(piece, all);
    let bundle = found.bundle;
    for ((_, kind), image) in bundle.images.range((index, MapKind::Position)..).take_while(|((p, _), _)| *p == index) {
        for (k, particle) in particles.iter().enumerate() {
            let texel = image.at(k);
            if kind == &MapKind::Rest {
                check_rest(found, index, piece, particles, k, texel);
            }
            if !particle.exists() {
                continue;
            }
            if texel.iter().any(|value| !value.is_finite()) {
                found.texel(FaultKind::NotFinite, index, k, kind, "a value is not finite".into());
                continue;
            }
            if let Some((fault, message)) = check_texel(kind, texel, all, bundle) {
                found.texel(fault, index, k, kind, message);
            }
        }
    }
    check_weights(found, index, particles);
    let both = |kind: &MapKind, constant: bool| constant && bundle.image(index, kind).is_some();
    let (rest, mass, limit) = (piece.constants.rest, piece.constants.mass, piece.constants.limit);
    let constants =
        [(MapKind::Rest, rest.is_some()), (MapKind::Mass, mass.is_some()), (MapKind::Limit, limit.is_some())];
    if constants.iter().any(|(kind, constant)| both(kind, *constant)) {
        found.manifest(FaultKind::Manifest, Some(piece), "a value is given both as a constant and as a map".into());
    }
    if rest.is_some_and(|lengths| lengths.iter().any(|&length| length < 0.0)) {
        found.manifest(FaultKind::Rest, Some(piece), "a constant rest length is negative".into());
    }
    if mass.is_some_and(|m| m <= 0.0) {
        found.manifest(FaultKind::Mass, Some(piece), "the constant mass is not positive".into());
    }
}

/// Rules of one texel of one map, for a texel with a particle and finite values.
fn check_texel(kind: &MapKind, texel: &[f32], all: &[Particle], bundle: &Bundle) -> Option<(FaultKind, String)> {
    match kind {
        MapKind::Mass if texel[0] <= 0.0 => Some((FaultKind::Mass, format!("mass {} kg is not positive", texel[0]))),
        MapKind::Backstop if texel[0] >= 0.0 && texel[1] <= 0.0 => {
            Some((FaultKind::Backstop, format!("the radius of a backstop is {} m, not above 0", texel[1])))
        }
        MapKind::Blend if !(0.0..=1.0).contains(&texel[0]) => {
            Some((FaultKind::Blend, format!("the blend {} is not between 0 and 1", texel[0])))
        }
        MapKind::Tether => {
            let (distance, anchor) = (texel[0], texel[1]);
            let whole = anchor >= 0.0 && anchor.fract() == 0.0 && anchor < crate::MAX_PARTICLES as f32;
            let pinned = whole && all.get(anchor as usize).is_some_and(|p| p.is_pinned());
            let sound = distance >= 0.0 && (anchor == -1.0 || pinned);
            (!sound).then(|| (FaultKind::Tether, format!("no tether of {distance} m to pinned particle {anchor}")))
        }
        MapKind::Stitch => stitch::fault(texel, all, bundle).map(|message| (FaultKind::Stitch, message)),
        MapKind::Joints(_) => {
            let joints = bundle.manifest.skeleton.as_ref().map_or(0, |s| s.joints.len());
            let bad = texel.iter().find(|&&v| v < 0.0 || v.fract() != 0.0 || v as usize >= joints)?;
            Some((FaultKind::Joint, format!("{bad} is not the index of one of the {joints} joints")))
        }
        _ => None,
    }
}

fn check_rest(found: &mut Findings, index: usize, piece: &PieceEntry, own: &[Particle], k: usize, texel: &[f32]) {
    for (kind, (&length, name)) in texel.iter().zip(["right", "down", "down-right", "up-right"]).enumerate() {
        if length < 0.0 || !length.is_finite() {
            found.texel(FaultKind::Rest, index, k, &MapKind::Rest, format!("{name} rest length {length} m"));
        } else if length > 0.0 && !spring_fits(piece, own, k, kind) {
            let message = format!("{name} rest length {length} m is not 0, but there is no particle to join");
            found.texel(FaultKind::Rest, index, k, &MapKind::Rest, message);
        }
    }
}

/// The weights of a particle are shares: none negative, 1 in all over all sets.
fn check_weights(found: &mut Findings, index: usize, particles: &[Particle]) {
    let bundle = found.bundle;
    let of_piece = |kind: &MapKind| matches!(kind, MapKind::Weights(_));
    let sets: Vec<&Image> =
        bundle.images.iter().filter(|((p, kind), _)| *p == index && of_piece(kind)).map(|(_, image)| image).collect();
    if sets.is_empty() {
        return;
    }
    for (k, _) in particles.iter().enumerate().filter(|(_, p)| p.exists()) {
        let weights = || sets.iter().flat_map(|image| image.at(k)).copied();
        let sum: f64 = weights().map(f64::from).sum();
        if sum.is_finite() && ((sum - 1.0).abs() > 1e-3 || weights().any(|w| w < 0.0)) {
            let message = format!("the weights sum to {sum:.4}, or one is negative");
            found.texel(FaultKind::Weight, index, k, &MapKind::Weights(0), message);
        }
    }
}

/// All duplicates of a point hold the same bits, and are all free or all pinned.
fn check_rings(found: &mut Findings, particles: &[Particle], rings: &Rings) {
    let bundle = found.bundle;
    let mut kinds: Vec<&MapKind> =
        bundle.images.keys().map(|(_, kind)| kind).filter(|k| k.agrees_across_seams()).collect();
    // A piece without a limit map has a constant limit, or none: it is compared all the same.
    let limits = bundle.limits().map(|_| MapKind::Limit);
    kinds.extend(&limits);
    kinds.sort();
    kinds.dedup();
    for ring in rings.iter() {
        let first = ring[0];
        for &other in &ring[1..] {
            if particles[first as usize].is_pinned() != particles[other as usize].is_pinned() {
                let message = format!("it is pinned and its duplicate, particle {first}, is not, or the reverse");
                found.particle(FaultKind::Pin, other, &MapKind::Position, message);
            }
            for kind in &kinds {
                // The fourth number of a position is the link, which differs.
                let count = if **kind == MapKind::Position { 3 } else { 4 };
                let value = |index: u32| {
                    let (piece, k) = bundle.locate(index)?;
                    if **kind == MapKind::Limit {
                        return Some(vec![bundle.limit(piece, k).to_bits()]);
                    }
                    let texel = bundle.image(piece, kind)?.at(k);
                    Some(texel.iter().take(count).map(|v| v.to_bits()).collect::<Vec<_>>())
                };
                if value(first) != value(other) {
                    let message = format!("{} differs from its duplicate, particle {first}", kind.name());
                    found.particle(FaultKind::Seam, other, kind, message);
                }
            }
        }
    }
}

/// The parts of every component weld to one connected surface with its Euler number and boundary loops.
fn check_components(found: &mut Findings, particles: &[Particle], rings: &Rings) {
    let manifest = &found.bundle.manifest;
    for (index, component) in manifest.components.iter().enumerate() {
        let part = |k: &usize| manifest.pieces[*k].part_of == Some(index as u32);
        let parts: Vec<usize> = (0..manifest.pieces.len()).filter(part).collect();
        let Some(&first) = parts.first() else {
            let message = format!("no piece is a part of component {}", component.name);
            found.manifest(FaultKind::Manifest, None, message);
            continue;
        };
        let got = welded(found.bundle, &parts, particles, rings);
        let said = &component.surface;
        let same = (got.euler, got.loops as u64) == (i64::from(said.euler), u64::from(said.loops));
        if !same || got.components != 1 || got.non_manifold_edges > 0 {
            let message = format!(
                "the parts of component {} weld to Euler number {} with {} boundary loops in {} components ({} edges with \
                 more than two triangles), not to {} with {} in one",
                component.name, got.euler, got.loops, got.components, got.non_manifold_edges, said.euler, said.loops
            );
            found.manifest(FaultKind::Topology, Some(&manifest.pieces[first]), message);
        }
    }
}

fn check_counts(found: &mut Findings, particles: &[Particle], rings: &Rings) {
    let counts = count_pieces(found.bundle, particles, rings);
    for (piece, real) in found.bundle.manifest.pieces.iter().zip(counts) {
        let said = piece.counts;
        let pairs = [
            ("particles", said.particles, real.particles),
            ("seam_texels", said.seam_texels, real.seam_texels),
            ("seam_points", said.seam_points, real.seam_points),
            ("largest_ring", said.largest_ring, real.largest_ring),
            ("pinned", said.pinned, real.pinned),
            ("springs", said.springs, real.springs),
        ];
        for (name, said, real) in pairs.into_iter().filter(|(_, said, real)| said != real) {
            let message = format!("counts.{name} is {said}, but the images hold {real}");
            found.manifest(FaultKind::Count, Some(piece), message);
        }
    }
}

#[cfg(test)]
#[path = "validate_tests.rs"]
mod tests;
