// Nodes of coarser grids, as shaders/part/nodes.wgsl, only to be read.
@group(0) @binding(21) var<storage, read> nodes: array<vec4<f32>>;
