//! The boundary loops of a component.

use serde::Serialize;

use crate::base::halfedge::{boundary_loops, twins};
use crate::base::mesh::Mesh;
use crate::base::vec3::distance;
use crate::stage::component::{Component, extract};

/// A boundary loop of a component.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BoundaryLoop {
    /// Its index K in the pin expression `loop:K` of a build with the same choice of parts; `None` for a component that the
    /// build leaves out or makes an accessory.
    pub pin: Option<usize>,
    /// Number of edges.
    pub edges: usize,
    /// Length \[m\].
    pub length: f64,
    /// Lowest and highest y \[m\].
    pub height: [f64; 2],
}

/// The boundary loops of a component, longest first.
pub(super) fn loops(mesh: &Mesh, component: &Component) -> Vec<BoundaryLoop> {
    if component.loops == 0 {
        return Vec::new();
    }
    // As the build numbers vertices, so that loops of equal lengths have its order.
    let surface = extract(mesh, component);
    let found = twins(&surface.triangles).ok().and_then(|twin| boundary_loops(&surface.triangles, &twin));
    let at = |v: u32| surface.positions[v as usize];
    let measure = |ring: &Vec<u32>| BoundaryLoop {
        pin: None,
        edges: ring.len(),
        length: (0..ring.len()).map(|k| distance(at(ring[k]), at(ring[(k + 1) % ring.len()]))).sum(),
        height: ring
            .iter()
            .map(|&v| at(v)[1])
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], y| [lo.min(y), hi.max(y)]),
    };
    let mut loops: Vec<BoundaryLoop> = found.iter().flatten().map(measure).collect();
    loops.sort_by(|a, b| b.length.total_cmp(&a.length));
    loops
}

/// Numbers the loops of all components that become pieces as pin expressions do: longest first, then by component.
pub(super) fn number(all: &mut [&mut Vec<BoundaryLoop>]) {
    let mut order: Vec<(usize, usize)> = Vec::new();
    all.iter().enumerate().for_each(|(k, loops)| order.extend((0..loops.len()).map(|l| (k, l))));
    order.sort_by(|a, b| all[b.0][b.1].length.total_cmp(&all[a.0][a.1].length).then(a.cmp(b)));
    order.into_iter().enumerate().for_each(|(pin, (k, l))| all[k][l].pin = Some(pin));
}
