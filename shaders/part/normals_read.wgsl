// Normals, only to be read.
@group(0) @binding(8) var<storage, read> normals: array<vec4<f32>>;
