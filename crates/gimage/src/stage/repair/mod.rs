//! Repairs a mesh to an oriented manifold, and reports every repair.
//!
//! In order: join equal positions, drop copies, remove triangles without area, take apart edges with three or more
//! triangles and vertices with more than one fan, wind neighbours alike, drop vertices nothing uses. One file a step.

mod bowtie;
mod degenerate;
mod duplicate;
mod nonmanifold;
mod orient;
mod rounding;
mod split_edge;
mod weld;
mod work;

use crate::base::mesh::{Mesh, NONE};
use crate::base::stray::strays;
use crate::base::words;
use crate::error::Result;
use crate::options::{Range, stage_options};
use crate::record::{Finding, MAX_EXAMPLES, Severity};
use duplicate::Duplicates;
use work::Work;

/// Coordinates beyond this \[m\] are as good as infinite: their squares of squares would be.
const FARTHEST: f64 = 1e75;

stage_options! {
    /// Options of [`repair`].
    pub struct RepairOptions of "repair" {
        /// Join vertices within this distance if both lie on open borders or an edge connects them; no vertex moves farther.
        /// Without it, only equal positions are joined, and borders that differ by the rounding of the numbers in the file. Larger distances mend wider cracks, but drop detail and join
        /// panels whose borders only lie close.
        pub weld: Option<f64> = None => "weld" ["m"] Range::Above(0.0);
    }
}

/// A repaired mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Repaired {
    /// The mesh: every edge has one or two triangles, every vertex is used and has one fan, neighbours wind alike
    /// wherever the piece is orientable, no triangle is without area or a copy. Triangles keep their order.
    pub mesh: Mesh,
    /// The repairs in order; indices are those of the input mesh.
    pub findings: Vec<Finding>,
}

/// Repairs a mesh. Corner attributes follow; unused values of channels stay. Deterministic, O(n log n).
///
/// Equal positions are joined first, so sheets this took apart where they touched would be joined by a second call and
/// taken apart again: use [`repair_joined`] on what was repaired before. An error only for an impossible option.
pub fn repair(mesh: Mesh, options: &RepairOptions) -> Result<Repaired> {
    options.check()?;
    let mut work = Work::new(mesh);
    drop_unusable(&mut work);
    let unused = work.used().iter().filter(|&&u| !u).count();
    weld::exact(&mut work);
    rounding::join(&mut work);
    if let Some(d) = options.weld {
        weld::within(&mut work, d);
    }
    report_strays(&mut work);
    Ok(finish(work, unused))
}

/// The same for a mesh whose vertices are joined as they should be: equal positions stay apart. On the result of
/// [`repair`] it changes nothing and finds nothing but notes.
pub fn repair_joined(mesh: Mesh) -> Repaired {
    let mut work = Work::new(mesh);
    drop_unusable(&mut work);
    let unused = work.used().iter().filter(|&&u| !u).count();
    finish(work, unused)
}

fn finish(mut work: Work, unused: usize) -> Repaired {
    degenerate::drop_collapsed(&mut work);
    let mut copies = Duplicates::default();
    duplicate::drop_duplicates(&mut work, &mut copies);
    degenerate::remove_flat(&mut work);
    duplicate::drop_duplicates(&mut work, &mut copies);
    let Duplicates { same, reversed, examples, doubled } = copies;
    let dropped = words::counted(same + reversed, "copy of a triangle", "copies of triangles");
    let message = format!("{dropped} dropped, {reversed} of them with reversed winding");
    work.report(Severity::Repair, "duplicate-faces", same + reversed, examples, message);

    let mut gluing = nonmanifold::glue(&work, &doubled);
    bowtie::split_vertices(&mut work, &mut gluing);
    orient::orient(&mut work, &gluing);
    compact(&mut work);
    let message = format!("{} that no triangle uses removed", words::vertices(unused));
    work.report(Severity::Note, "unused-vertices", unused, Vec::new(), message);
    Repaired { mesh: work.mesh, findings: work.findings }
}

/// Drops triangles with vertices that do not exist or are nowhere, and forgets attribute values that do not exist.
fn drop_unusable(work: &mut Work) {
    let sound = |p: &[f64; 3]| p.iter().all(|x| x.abs() <= FARTHEST);
    let positions = &work.mesh.positions;
    let keep: Vec<bool> =
        work.mesh.triangles.iter().map(|t| t.iter().all(|&v| positions.get(v as usize).is_some_and(sound))).collect();
    let examples = (0..work.len()).filter(|&t| !keep[t]).take(4).map(|t| work.triangle_words(t)).collect();
    let count = work.retain(&keep);
    let message = format!("{} dropped: a vertex is missing, or its position is not finite", words::triangles(count));
    work.report(Severity::Repair, "unusable-faces", count, examples, message);
    for channel in &mut work.mesh.channels {
        let values = channel.values.len().checked_div(channel.width).unwrap_or(0);
        channel.corners.iter_mut().filter(|k| **k as usize >= values).for_each(|k| *k = NONE);
    }
}

/// Warns of single vertices far off the others. They stay, as nothing tells where they belong.
fn report_strays(work: &mut Work) {
    let (found, _) = strays(&work.mesh.positions, &work.mesh.triangles);
    let examples = found.iter().take(MAX_EXAMPLES).map(|v| work.vertex_words(*v)).collect();
    let message = format!(
        "{} far off the others: the triangles there are spikes, which take up most of the image. Move or delete {} in the file.",
        words::vertices(found.len()),
        if found.len() == 1 { "it" } else { "them" }
    );
    work.report(Severity::Warning, "stray-vertex", found.len(), examples, message);
}

/// Drops vertices no triangle uses; the others keep their order.
fn compact(work: &mut Work) {
    let used = work.used();
    let mut to = vec![0; used.len()];
    let mut next = 0;
    for v in (0..used.len()).filter(|&v| used[v]) {
        to[v] = next;
        work.mesh.positions[next as usize] = work.mesh.positions[v];
        next += 1;
    }
    work.mesh.positions.truncate(next as usize);
    work.mesh.positions.shrink_to_fit();
    work.rename(|v| to[v as usize]);
}

#[cfg(test)]
mod tests;
