//! Carries the numbers of components ([`component_numbers`]) through repair, as an attribute of corners.

use super::super::select::component_numbers;
use crate::base::mesh::{Channel, Mesh, Semantic};
use crate::stage::component::Component;

/// The name of the attribute: no file has it, as names of custom attributes begin with an underscore.
const NAME: &str = "component number";

/// Marks the corners of an imported mesh.
pub(super) fn mark(mesh: &mut Mesh) {
    let (numbers, count) = component_numbers(mesh);
    let values = (0..count).map(|number| number as f32).collect();
    let corners = numbers.into_iter().flat_map(|number| [number; 3]).collect();
    mesh.channels.push(Channel { semantic: Semantic::Custom(NAME.into()), width: 1, values, corners });
}

/// The numbers that a component of the repaired mesh has, ascending.
pub(super) fn of(mesh: &Mesh, component: &Component) -> Vec<u32> {
    let Some(marks) = mesh.channel(&Semantic::Custom(NAME.into())) else { return Vec::new() };
    let mark = |t: &u32| (0..3).find_map(|c| marks.at(*t as usize, c)?.first().map(|number| *number as u32));
    let mut numbers: Vec<u32> = component.triangles.iter().filter_map(mark).collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}
