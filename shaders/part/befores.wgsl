// Positions one step before.
@group(0) @binding(3) var<storage, read_write> before: array<vec4<f32>>;
