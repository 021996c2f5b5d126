// Normals; w is the length of what they were made from.
@group(0) @binding(8) var<storage, read_write> normals: array<vec4<f32>>;
