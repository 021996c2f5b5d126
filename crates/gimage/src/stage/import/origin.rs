//! Where the vertices of an imported mesh came from.

/// The primitive of a glTF file that a part of the mesh was.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin {
    /// The node; none in a file without nodes.
    pub node: Option<usize>,
    /// The mesh.
    pub mesh: usize,
    /// The number of the primitive in the mesh.
    pub primitive: usize,
    /// The transform of the instance in the space of the node, column by column, if the node lists instances.
    pub instance: Option<[f64; 16]>,
    /// The vertices of the primitive that are vertices of the mesh, ascending. They follow those of the part before.
    pub vertices: Vec<u32>,
}
