// Where particles are. w is the inverse mass, 0 pinned, -1 no particle.
@group(0) @binding(2) var<storage, read_write> now: array<vec4<f32>>;
