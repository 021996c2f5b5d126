//! Parts that the flags choose by the number of a connected component: a file may be one mesh of one material.

use std::collections::BTreeMap;

use super::facts::pieces;
use super::{Pattern, Role, SelectOptions};
use crate::base::mesh::{Mesh, Part};

impl SelectOptions {
    /// The patterns of each flag and the role that they give.
    pub(super) fn chosen(&self) -> [(&'static str, &[Pattern], Role); 3] {
        [("cloth", &self.cloth, Role::Cloth), ("body", &self.body, Role::Body), ("rigid", &self.rigid, Role::Rigid)]
    }

    /// Whether any flag chooses a component by its number.
    fn has_numbers(&self) -> bool {
        self.chosen().iter().any(|(_, patterns, _)| patterns.iter().any(|p| p.component().is_some()))
    }

    /// The role that a flag gives to the component that a part is, which goes before roles by name.
    pub(crate) fn of_component(&self, part: &Part) -> Option<Role> {
        let number = part.component?;
        let has = |patterns: &[Pattern]| patterns.iter().any(|p| p.component() == Some(number));
        self.chosen().into_iter().find(|(_, patterns, _)| has(patterns)).map(|(.., role)| role)
    }
}

/// The number of the connected component of each triangle, and how many there are: 0 for the largest by area, then in the order of
/// their first triangles. Vertices at equal positions are joined. `gimage list` shows these numbers, and `component:K` chooses by them; they
/// do not depend on options of a build other than those of the import. O(n log n).
pub fn component_numbers(mesh: &Mesh) -> (Vec<u32>, usize) {
    let piece = pieces(mesh);
    let of = |t: usize| piece[mesh.triangles[t][0] as usize];
    let mut areas: BTreeMap<u32, (f64, usize)> = BTreeMap::new();
    for t in 0..mesh.triangles.len() {
        areas.entry(of(t)).or_insert((0.0, t)).0 += mesh.triangle_area(t);
    }
    let mut order: Vec<(u32, f64, usize)> =
        areas.into_iter().map(|(piece, (area, first))| (piece, area, first)).collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.2.cmp(&b.2)));
    let number: BTreeMap<u32, u32> = order.iter().zip(0..).map(|((piece, ..), number)| (*piece, number)).collect();
    ((0..mesh.triangles.len()).map(|t| number[&of(t)]).collect(), order.len())
}

/// The mesh with parts of their own for the components that the flags choose by number ([`component_numbers`]), after all other parts; the same mesh
/// if they choose none. A part of which all components are chosen stays, without triangles. O(n log n).
pub fn divided(mut mesh: Mesh, options: &SelectOptions) -> Mesh {
    if !options.has_numbers() {
        return mesh;
    }
    let is_chosen = |number: u32| {
        options.chosen().iter().any(|(_, patterns, _)| patterns.iter().any(|p| p.component() == Some(number)))
    };
    let mut made: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for (t, number) in component_numbers(&mesh).0.into_iter().enumerate().filter(|(_, number)| is_chosen(*number)) {
        let part = mesh.triangle_part[t];
        mesh.triangle_part[t] = *made.entry((part, number)).or_insert_with(|| {
            mesh.parts.push(Part { component: Some(number), ..mesh.parts[part as usize].clone() });
            mesh.parts.len() as u32 - 1
        });
    }
    mesh
}
