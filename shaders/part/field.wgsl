// What air does to each particle, as an acceleration.
@group(0) @binding(9) var<storage, read_write> field: array<vec4<f32>>;
