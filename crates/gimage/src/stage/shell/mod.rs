//! Garments modelled with a thickness: recognises closed thin shells and pairs of facing sheets, and makes one layer of each.
//!
//! Rays through the fabric pair each triangle with the one that faces it on the other side. Neighbours across flat edges lie on one sheet,
//! facing triangles on two, which labels both; the band between them is the rim. The outer sheet stays, with its triangles and
//! attributes, and moves halfway to the other one. The inner sheet and the rim get no image. Parts of one layer stay as they
//! are. A doubtful case is kept as it is, with a warning.

mod alone;
mod doubled;
mod layers;
mod middle;
mod rays;
mod report;
mod sides;
mod verdict;
mod zone;

use crate::base::mesh::{Mesh, NONE};
use crate::base::rebuild::rebuild;
use crate::base::vec3::{add, cross, dot, scale, sub};
use crate::options::{Choice, Range, stage_options};
use crate::record::Finding;
use crate::stage::component::{ALWAYS_PIECE, Component, ComponentOptions, Split, split, split_counting};
use verdict::{Doubt, Evidence, Found, Verdict};
use zone::Zone;

pub(crate) use rays::Sheets;

/// The layer of a thin shell that becomes cloth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// The outer sheet, moved halfway to the inner one.
    Mid,
    /// The outer sheet where it is.
    Outer,
    /// Both sheets, as they are.
    Keep,
}

impl Choice for Layer {
    const ALL: &'static [(&'static str, Self)] = &[("mid", Self::Mid), ("outer", Self::Outer), ("keep", Self::Keep)];
}

stage_options! {
    /// Options of [`thin`].
    #[derive(Copy)]
    pub struct ShellOptions of "shell" {
        /// Fabric modelled with a thickness (a closed thin shell, or two facing sheets): its outer sheet becomes cloth,
        /// moved halfway to the inner one (mid) or where it is (outer), or both sheets do (keep).
        pub shell: Layer = Layer::Mid => "shell" [""] Range::Any;
    }
}

/// A thin shell of which one sheet is left.
#[derive(Clone, Debug, PartialEq)]
pub struct Shell {
    /// The name of its largest component.
    pub name: String,
    /// Median distance of the two sheets \[m\].
    pub thickness: f64,
    /// Distances \[m\] that 5 % and 95 % of the area lie below.
    pub range: [f64; 2],
    /// Share of its area that had an opposite sheet; the rest was rims, or faced a hole.
    pub share: f64,
    /// The layer that is left: [`Layer::Mid`] or [`Layer::Outer`].
    pub layer: Layer,
    /// Triangles that are left, those of one layer among them.
    pub triangles: usize,
    /// Triangles of one layer, which are left where they are.
    pub alone: usize,
    /// Their area \[m2\].
    pub area: f64,
    /// Area of both sheets and the rim \[m2\].
    pub source_area: f64,
    /// Triangles of the inner sheet and the rim, which get no image.
    pub bound_triangles: usize,
    /// Their area \[m2\].
    pub bound_area: f64,
}

/// A mesh whose thin shells are single layers.
#[derive(Clone, Debug, PartialEq)]
pub struct Thinned {
    /// The mesh. Triangles keep their order, winding and attributes; without a thin shell it is the same mesh.
    pub mesh: Mesh,
    /// The shells, the largest first.
    pub shells: Vec<Shell>,
    /// For each triangle of the mesh the index of its shell, or [`NONE`]; empty without shells.
    pub shell_of: Vec<u32>,
    /// The decisions, as findings.
    pub findings: Vec<Finding>,
}

impl Thinned {
    /// The shell that a component of the mesh is the layer of.
    pub fn shell(&self, component: &Component) -> Option<&Shell> {
        self.shells.get(self.shell_index(component)?)
    }

    /// The index of that shell.
    pub(crate) fn shell_index(&self, component: &Component) -> Option<usize> {
        let k = *self.shell_of.get(*component.triangles.first()? as usize)?;
        (k != NONE).then_some(k as usize)
    }

    /// The components of the mesh, of which shells count with both sheets.
    pub fn split(&self, options: &ComponentOptions) -> Split {
        let beside = |c: &Component| self.shell(c).map_or(0.0, |s| (s.source_area / s.area - 1.0) * c.area);
        split_counting(&self.mesh, options, &beside)
    }
}

/// Makes one layer of each thin shell of a repaired mesh; small components, which become accessories, are left alone.
/// Deterministic. Cost: O(n log n) to prepare, some rays per component, and one ray or more per triangle of a shell.
pub fn thin(mesh: Mesh, options: &ShellOptions, parts: &ComponentOptions) -> Thinned {
    let same = |mesh| Thinned { mesh, shells: Vec::new(), shell_of: Vec::new(), findings: Vec::new() };
    if options.shell == Layer::Keep || mesh.triangles.is_empty() {
        return same(mesh);
    }
    let components = candidates(&mesh, parts);
    let zone = Zone::new(&mesh, &components);
    if zone.triangles.is_empty() {
        return same(mesh);
    }
    let sides = sides::sides(&zone);
    let layers = layers::layers(&zone, &sides, &mesh.positions);
    let (low, high) = mesh.bounds().unwrap_or_default();
    let evidence = Evidence {
        zone: &zone,
        sides: &sides,
        layers: &layers,
        positions: &mesh.positions,
        components: &components,
        centre: scale(add(low, high), 0.5),
    };
    let (mut found, mut doubts): (Vec<Found>, Vec<Doubt>) = Default::default();
    for verdict in evidence.verdicts() {
        match verdict {
            Verdict::Plain => {}
            Verdict::Doubtful(doubt) => doubts.push(doubt),
            Verdict::Shell(shell) => found.push(shell),
        }
    }
    // Components come by size.
    found.sort_by_key(|f| f.components.clone());
    let mut shells: Vec<Shell> = found.iter().map(|f| entry(f, &zone, &components, options.shell)).collect();
    let findings = report::findings(&shells, &doubts, &components);
    if found.is_empty() {
        return Thinned { findings, ..same(mesh) };
    }
    let (mesh, shell_of) = apply(mesh, &zone, &found, options.shell);
    for (t, k) in shell_of.iter().enumerate().filter(|x| *x.1 != NONE) {
        shells[*k as usize].area += mesh.triangle_area(t);
    }
    Thinned { mesh, shells, shell_of, findings }
}

/// The components that become pieces: others are accessories, with both sheets.
fn candidates(mesh: &Mesh, parts: &ComponentOptions) -> Vec<Component> {
    let mut all = split(mesh, &ComponentOptions { accessory_area: 0.0 }).pieces;
    let total: f64 = all.iter().map(|c| c.area).sum();
    let least = parts.accessory_area.min(ALWAYS_PIECE) * total;
    all.retain(|c| c.area >= least && c.orientable);
    all
}

fn entry(found: &Found, zone: &Zone, components: &[Component], layer: Layer) -> Shell {
    let [thickness, low, high] = found.thickness;
    let area = |list: &[u32]| list.iter().map(|&t| zone.area[t as usize]).sum::<f64>();
    Shell {
        name: components[found.components[0] as usize].name.clone(),
        thickness,
        range: [low, high],
        share: found.share,
        layer,
        triangles: found.kept.len() + found.alone.len(),
        alone: found.alone.len(),
        bound_triangles: found.dropped.len(),
        area: 0.0,
        source_area: area(&found.kept) + area(&found.alone) + area(&found.dropped),
        bound_area: area(&found.dropped),
    }
}

/// Moves the sheets that stay, and drops the rest. Returns the mesh and the shell of each of its triangles.
fn apply(mut mesh: Mesh, zone: &Zone, found: &[Found], layer: Layer) -> (Mesh, Vec<u32>) {
    let mut keep = vec![true; mesh.triangles.len()];
    let mut shell_of = vec![NONE; mesh.triangles.len()];
    for (k, f) in found.iter().enumerate() {
        f.dropped.iter().for_each(|&t| keep[zone.source[t as usize] as usize] = false);
        f.kept.iter().chain(&f.alone).for_each(|&t| shell_of[zone.source[t as usize] as usize] = k as u32);
    }
    if layer == Layer::Mid {
        // All before any moves: shells share no vertex that stays with what another faces.
        let moved: Vec<_> = found.iter().flat_map(|f| halfway(&mesh, zone, f)).collect();
        moved.into_iter().for_each(|(v, place)| mesh.positions[v as usize] = place);
    }
    let (mesh, kept) = rebuild(mesh, &keep);
    let shell_of = kept.iter().map(|&t| shell_of[t as usize]).collect();
    (mesh, shell_of)
}

fn halfway(mesh: &Mesh, zone: &Zone, found: &Found) -> Vec<(u32, [f64; 3])> {
    let outwards = |&t: &u32| {
        let [a, b, c] = zone.triangles[t as usize];
        let [p, q, r] = [a, b, c].map(|v| mesh.positions[v as usize]);
        if dot(cross(sub(q, p), sub(r, p)), zone.normal[t as usize]) < 0.0 { [a, c, b] } else { [a, b, c] }
    };
    let triangles: Vec<[u32; 3]> = found.kept.iter().map(outwards).collect();
    let facing: Vec<_> = found.facing.iter().map(|&t| mesh.corners(zone.source[t as usize] as usize)).collect();
    middle::middle(&mesh.positions, &triangles, &facing, found.thickness[0])
}

#[cfg(test)]
mod tests;
