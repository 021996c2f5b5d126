//! Divides parts of a file: connected components that the flags choose by number, as a file may be one mesh of one material, and solid pieces
//! beside garments, such as a headband that has the material of a sash.

use std::collections::BTreeMap;

use super::facts::{self, pieces};
use super::{Pattern, Role, SelectOptions, rule};
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

/// The mesh with parts of their own for the components that the flags choose by number ([`component_numbers`]), and, where the rule chooses the cloth,
/// for the solid pieces of parts that only their joints tell about and that lie beside garments in one mesh; these are after all other parts. The same
/// mesh if there are none. A part of which all triangles are in others stays, without triangles. O(n log n).
pub fn divided(mut mesh: Mesh, options: &SelectOptions) -> Mesh {
    if options.has_numbers() {
        let is_chosen = |number: u32| {
            options.chosen().iter().any(|(_, patterns, _)| patterns.iter().any(|p| p.component() == Some(number)))
        };
        let numbers = component_numbers(&mesh).0;
        apart(&mut mesh, |t| Some(Some(numbers[t])).filter(|_| is_chosen(numbers[t])));
    }
    let unnamed = if options.cloth.is_empty() { rule::unnamed_beside_garments(&mesh) } else { Vec::new() };
    if unnamed.contains(&true) {
        let (solid, part) = (facts::solid(&mesh), mesh.triangle_part.clone());
        let mut has = vec![[false; 2]; mesh.parts.len()];
        part.iter().zip(&solid).for_each(|(p, solid)| has[*p as usize][usize::from(*solid)] = true);
        let goes = |t: usize| solid[t] && unnamed[part[t] as usize] && has[part[t] as usize] == [true; 2];
        apart(&mut mesh, |t| Some(None).filter(|_| goes(t)));
    }
    mesh
}

/// Gives triangles that `of` chooses a part of their own, for each part and component number.
fn apart(mesh: &mut Mesh, of: impl Fn(usize) -> Option<Option<u32>>) {
    let mut made: BTreeMap<(u32, Option<u32>), u32> = BTreeMap::new();
    for t in 0..mesh.triangles.len() {
        let Some(component) = of(t) else { continue };
        let part = mesh.triangle_part[t];
        mesh.triangle_part[t] = *made.entry((part, component)).or_insert_with(|| {
            mesh.parts.push(Part { component, ..mesh.parts[part as usize].clone() });
            mesh.parts.len() as u32 - 1
        });
    }
}
