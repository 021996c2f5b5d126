// What air does to each particle, as an acceleration, only to be read.
@group(0) @binding(9) var<storage, read> field: array<vec4<f32>>;
