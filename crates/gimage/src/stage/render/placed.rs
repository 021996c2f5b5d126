//! The primitives of a document, and which vertices of the imported mesh theirs became.

use super::attach;
use super::bind::{Binding, UNBOUND};
use crate::stage::import::Origin;

/// A primitive as a node places it.
pub(super) struct Placed {
    pub node: Option<usize>,
    pub mesh: usize,
    pub primitive: usize,
    pub instance: Option<[f64; 16]>,
    /// Its vertices that are vertices of the imported mesh, ascending, and which of these they are.
    pub vertices: Vec<u32>,
    pub imported: Vec<u32>,
}

impl Placed {
    /// With the binding of each vertex, from those of the vertices of the imported mesh.
    pub fn bound(self, list: &[Binding]) -> attach::Bound {
        let Placed { node, mesh, primitive, instance, vertices, imported } = self;
        let of = |v: &u32| list.get(*v as usize).copied().unwrap_or(UNBOUND);
        let vertices = vertices.into_iter().zip(imported.iter().map(of)).collect();
        attach::Bound { node, mesh, primitive, instance, vertices, imported }
    }
}

/// The primitives of a glTF file.
pub(super) fn of_origins(origins: &[Origin]) -> Vec<Placed> {
    let mut first = 0;
    let one = |origin: &Origin| {
        let own = first..first + origin.vertices.len() as u32;
        first = own.end;
        let Origin { node, mesh, primitive, instance, ref vertices } = *origin;
        Placed { node, mesh, primitive, instance, vertices: vertices.clone(), imported: own.collect() }
    };
    origins.iter().map(one).collect()
}

/// Those of a document with one node per mesh and one primitive per mesh.
pub(super) fn of_nodes(nodes: &[Vec<u32>]) -> Vec<Placed> {
    let one = |(node, own): (usize, &Vec<u32>)| Placed {
        node: Some(node),
        mesh: node,
        primitive: 0,
        instance: None,
        vertices: (0..own.len() as u32).collect(),
        imported: own.clone(),
    };
    nodes.iter().enumerate().map(one).collect()
}
