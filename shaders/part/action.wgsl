// The numbers of a user's action: three corners of a cutting triangle, four columns of a matrix, or a ray.
@group(0) @binding(11) var<storage, read> action: array<vec4<f32>>;
