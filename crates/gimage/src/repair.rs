//! Makes a mesh an oriented manifold.
