//! The render mesh: the file as it is, with every vertex of what is cloth bound to the pieces.
//!
//! A vertex belongs to the piece that its component became. Its point on the drawn surface is the one whose interpolated normal leads to
//! the vertex (Kobbelt, Vorsatz, Seidel, "Multiresolution hierarchies on unstructured triangle meshes", 1999, call it normal
//! displacement), else the nearest one; the rest is an offset in the frame there.

mod apart;
mod attach;
mod bind;
mod classes;
mod finite;
mod halves;
mod hems;
mod layout;
mod lids;
mod options;
mod placed;
pub(crate) mod plain;
mod subdivide;
mod surface;
pub(crate) mod trace;

use std::borrow::Cow;
use std::path::Path;

use gimage_bundle::manifest::RenderEntry;
use gimage_bundle::{Bundle, MapKind, RenderFile};
use serde_json::Value;

use self::attach::{Attached, Skin};
use self::bind::{Anchor, Binding, UNBOUND, bind_all};
use self::classes::Classes;
use self::hems::Hems;
use self::placed::{of_nodes, of_origins};
use self::subdivide::{Divided, subdivide};
use self::surface::{Spot, Surface, Texels};
use self::trace::Trace;
use crate::base::mesh::NONE;
use crate::base::vec3::{distance, norm};
use crate::base::words;
use crate::error::{Error, Result};
use crate::options::BuildOptions;
use crate::record::{Finding, Severity};
use crate::stage::assemble::accessory::Rider;
use crate::stage::assemble::{Family, Piece};
use crate::stage::import::{Origin, Source, embed};

pub(crate) use self::options::CELLS;
pub use self::options::{RenderMesh, RenderOptions, Subdivision};

/// Share of the diagonal of the cloth above which a vertex is reported as far from its piece.
const FAR: f64 = 0.05;
/// Share of the diagonal of the cloth up to which an accessory is moved as one rigid body.
const RIGID: f64 = 0.05;

/// A document without references to other files.
pub(crate) struct Document {
    pub json: Value,
    pub bin: Vec<u8>,
    /// For each node the vertices of the imported mesh; empty for a glTF file, which has [`Origin`]s.
    pub vertices: Vec<Vec<u32>>,
}

/// The file as it was imported.
pub(crate) struct Imported<'a> {
    pub path: &'a Path,
    pub source: &'a Source,
    pub origins: &'a [Origin],
    pub transform: [f64; 16],
    /// The document of a mesh whose file is not glTF.
    pub plain: Option<Document>,
    /// The longest edge of drawn cloth, as a multiple of the distance of two texels; `None` leaves all.
    pub cells: Option<f64>,
}

/// The results of the stages that the mesh went through.
pub(crate) struct Made<'a> {
    pub trace: &'a Trace,
    pub pieces: &'a [Piece<'a>],
    pub families: &'a [Family<'a>],
    pub riders: &'a [Rider<'a>],
}

/// Binds the mesh of the source and puts it into the bundle, which has its images and accessories. A file that cannot be embedded is
/// left out, with a warning.
///
/// O(n log n) in vertices and texels.
pub(crate) fn add(
    bundle: &mut Bundle,
    imported: Imported<'_>,
    made: &Made<'_>,
    options: &BuildOptions,
) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let mut document = match (imported.plain, embed(imported.path, &options.import, imported.source)) {
        (Some(plain), _) => plain,
        (None, Ok(Some(embedded))) => {
            if !embedded.lost_images.is_empty() {
                let message = "Images that could not be read are white in the render mesh.";
                findings.push(finding("lost-images", embedded.lost_images.len(), embedded.lost_images, message.into()));
            }
            Document { json: embedded.json, bin: embedded.bin, vertices: Vec::new() }
        }
        (None, Ok(None)) => return Ok(findings),
        (None, Err(error)) => {
            let message = format!("The bundle has no render mesh: {error}.");
            findings.push(finding("no-render-mesh", 1, Vec::new(), message));
            return Ok(findings);
        }
    };
    let counts = finite::make_finite(&mut document.json, &mut document.bin);
    let messages = [
        (
            "non-finite-positions",
            "Vertices of the render mesh have no finite position: their triangles are collapsed to points.",
        ),
        ("non-finite-attributes", "Numbers of the render mesh other than positions are not finite: they are 0."),
    ];
    for ((kind, message), count) in messages.into_iter().zip(counts).filter(|(_, count)| *count > 0) {
        let finding = finding(kind, count, Vec::new(), message.into());
        findings.push(Finding { severity: Severity::Repair, ..finding });
    }
    let texels = Texels::new(bundle).map_err(|e| Error::Internal(e.to_string()))?;
    let mut placed = match document.vertices.is_empty() {
        true => of_origins(imported.origins),
        false => of_nodes(&document.vertices),
    };
    let mut trace = Cow::Borrowed(made.trace);
    if let Some(cells) = imported.cells {
        let limits = (cells * texels.spacing(), texels.triangles.len());
        let divided = subdivide(&mut document, &mut placed, trace.to_mut(), limits);
        findings.extend(divided.map(|divided| finer(&divided, cells)));
    }
    let bindings = bind(bundle, &texels, &Made { trace: &trace, ..*made })?;
    findings.extend(bindings.findings);
    let bound: Vec<attach::Bound> = placed.into_iter().map(|placed| placed.bound(&bindings.list)).collect();
    let blends = |k: &usize| bundle.image(*k, &MapKind::Blend).is_some();
    let blending: Vec<usize> = (0..bundle.manifest.pieces.len()).filter(blends).collect();
    let skin = Skin { trace: &trace, blending: &blending };
    let attached = Attached::new(document.json, document.bin, &bound, &skin);
    let (vertices, bound) = (attached.counts.vertices, attached.counts.bound);
    let problem = match attached.into_bytes() {
        Ok(bytes) if bytes.len() as u64 <= gimage_bundle::MAX_RENDER_BYTES => {
            let problem = unreadable(&bytes);
            bundle.render = problem.is_none().then_some(bytes);
            problem
        }
        _ => Some("it is larger than 2 GiB; use smaller textures".into()),
    };
    if let Some(problem) = problem {
        let message = format!("The bundle has no render mesh: {problem}.");
        findings.push(finding("no-render-mesh", 1, Vec::new(), message));
        return Ok(findings);
    }
    bundle.manifest.render = Some(RenderEntry {
        file: gimage_bundle::RENDER_FILE.into(),
        vertices,
        bound,
        largest_offset: bindings.largest,
        transform: imported.transform,
    });
    Ok(findings)
}

/// A fault of parts of the source that the import does not read, such as tangents.
fn unreadable(bytes: &[u8]) -> Option<String> {
    // The advice of the error is for readers of a bundle.
    RenderFile::parse(bytes).and_then(|file| file.primitives()).err().map(|error| match error {
        gimage_bundle::Error::Render { element, problem } => format!("{element}: {problem}; export the file again"),
        other => other.to_string(),
    })
}

/// The binding of each vertex of the imported mesh.
struct Bindings {
    list: Vec<Binding>,
    /// The largest offset \[m\] of a vertex that is not on a rigid accessory.
    largest: f64,
    findings: Vec<Finding>,
}

fn bind(bundle: &Bundle, texels: &Texels, made: &Made<'_>) -> Result<Bindings> {
    let Made { trace, pieces, families, riders } = made;
    // The parts of one component are one surface.
    let mut group: Vec<usize> = (0..pieces.len()).collect();
    for family in *families {
        (family.first..family.first + family.count).for_each(|p| group[p] = family.first);
    }
    let mut classes = Classes::new(trace);
    let mut claim = |triangles: &[u32], owner: usize| {
        for &t in triangles {
            let corners = 3 * t as usize..3 * t as usize + 3;
            let sources = trace.corners.get(corners).into_iter().flatten();
            sources.filter(|&&v| v != NONE).for_each(|&v| classes.claim(v, owner as u32));
        }
    };
    pieces.iter().zip(&group).for_each(|(piece, &owner)| claim(&piece.surface.source_triangle, owner));
    riders.iter().enumerate().for_each(|(r, rider)| claim(&rider.component.triangles, pieces.len() + r));
    classes.spread(&trace.triangles);

    let diagonal = diagonal(&classes.positions);
    let members = |owner: usize| group.iter().enumerate().filter(move |(_, g)| **g == owner).map(|(p, _)| p);
    let surfaces: Vec<Option<Surface>> =
        (0..pieces.len()).map(|p| (group[p] == p).then(|| Surface::new(texels, members(p)))).collect();
    // Accessories that are too long to be rigid, such as zips, run along several pieces: each of their vertices rides on the nearest.
    let is_apart = |owner: &u32| *owner as usize >= pieces.len();
    let whole = classes.owner.iter().any(is_apart).then(|| Surface::new(texels, 0..pieces.len()));
    let carrier = |r: usize| bundle.manifest.accessories.get(r).map_or(0, |a| group[a.piece as usize]);
    let surface = |class: usize| match classes.owner[class] as usize {
        owner if owner < pieces.len() => surfaces[owner].as_ref(),
        _ => whole.as_ref(),
    };
    let entries = &bundle.manifest.pieces;
    let hems = Hems::new(bundle, texels);
    let sewn_to =
        |spot: &Spot| hems.target(texels, spot).and_then(|(p, far)| Some((surfaces[*group.get(p)?].as_ref()?, far)));
    let mut bound = bind_all(entries, texels, &classes.positions, (surface, sewn_to));
    let mut is_rigid = vec![false; bound.len()];
    let anchors: Vec<Option<Anchor>> = (riders.iter().enumerate())
        .map(|(r, rider)| {
            let (lo, hi) = rider.component.bounds;
            // A component that lies on a surface bends with it.
            let is_rigid = distance(lo, hi) <= RIGID * diagonal && rider.component.lies_on.is_none();
            let centre = bundle.manifest.accessories.get(r).filter(|_| is_rigid)?.center;
            Anchor::new(entries, texels, &surfaces[carrier(r)].as_ref()?.foot(centre)?)
        })
        .collect();
    for (class, slot) in bound.iter_mut().enumerate() {
        let rider = (classes.owner[class] as usize).checked_sub(pieces.len());
        if let (Some(anchor), Some(slot)) = (rider.and_then(|r| anchors.get(r)?.as_ref()), slot) {
            slot.binding = anchor.bind(classes.positions[class]);
            slot.miss = anchor.miss(&slot.binding, classes.positions[class]);
            is_rigid[class] = true;
        }
    }
    let left = apart::leave(&classes, trace, &mut bound, pieces.len(), FAR * diagonal);
    lids::to_skin(&classes, trace, &mut bound);
    let free = || bound.iter().zip(&is_rigid).zip(&classes.positions).filter(|((_, rigid), _)| !**rigid);
    // Vertices on the skin do not swing.
    let swings = |b: &&bind::Bound| b.binding.blend > 0.0 && b.far > FAR * diagonal;
    let far: Vec<([f64; 3], f64)> =
        free().filter_map(|((b, _), p)| b.as_ref().filter(swings).map(|b| (*p, b.far))).collect();
    let largest = free().filter_map(|((b, _), _)| b.as_ref()).map(|b| b.far).fold(0.0, f64::max);
    let mut findings = Vec::new();
    if !left.is_empty() {
        let names: Vec<String> = left.iter().map(|r| riders[*r].component.name.clone()).collect();
        let message = format!(
            "{} that are farther than {} % of the diagonal from all cloth stay on their joints.",
            words::counted(left.len(), "accessory", "accessories"),
            100.0 * FAR
        );
        let examples = names.into_iter().take(crate::record::MAX_EXAMPLES).collect();
        findings.push(Finding { severity: Severity::Note, ..finding("hint-on-joints", left.len(), examples, message) });
    }
    if !far.is_empty() {
        let message = format!(
            "{} of the render mesh, of {}, are farther than {} % of the diagonal from the piece that moves them.",
            words::vertices(far.len()),
            bound.len(),
            100.0 * FAR
        );
        let example = |(p, d): &([f64; 3], f64)| format!("{} is {} m away", words::point(*p), words::number(*d));
        let examples = far.iter().take(crate::record::MAX_EXAMPLES).map(example).collect();
        findings.push(finding("far-from-cloth", far.len(), examples, message));
    }
    let of = |class: u32| bound.get(class as usize).and_then(|b| b.as_ref()).map_or(UNBOUND, |b| b.binding);
    Ok(Bindings { list: classes.of.iter().map(|&class| of(class)).collect(), largest, findings })
}

fn diagonal(positions: &[[f64; 3]]) -> f64 {
    let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in positions {
        (0..3).for_each(|k| (lo[k], hi[k]) = (lo[k].min(p[k]), hi[k].max(p[k])));
    }
    if positions.is_empty() { 0.0 } else { norm(crate::base::vec3::sub(hi, lo)) }
}

/// That the drawn cloth has more triangles than in the file.
fn finer(divided: &Divided, cells: f64) -> Finding {
    let Divided { before, after } = divided;
    let message = format!(
        "The cloth is drawn by {after} triangles in place of {before}: edges longer than {} times the distance of two particles are halved, so that it can \
         show folds. Keep the triangles of the file with --subdivide none.",
        words::number(cells)
    );
    Finding { severity: Severity::Note, ..finding("hint-subdivided", 1, Vec::new(), message) }
}

fn finding(kind: &'static str, count: usize, examples: Vec<String>, message: String) -> Finding {
    Finding { severity: Severity::Warning, stage: "render", kind, count: count as u64, examples, message }
}
