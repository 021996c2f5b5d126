// The multipliers of bending, of each texel; w is 1 where there is one.
@group(0) @binding(27) var<storage, read_write> moments: array<vec4<f32>>;
