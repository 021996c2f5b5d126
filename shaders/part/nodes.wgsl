// Nodes of coarser grids, two entries each: where it is now, with 1 / mass or 0 for a pinned one, and where it was, with 1 / mass.
@group(0) @binding(21) var<storage, read_write> nodes: array<vec4<f32>>;
