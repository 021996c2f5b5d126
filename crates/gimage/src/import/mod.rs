//! Files to meshes.
