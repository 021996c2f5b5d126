// Cut springs have no rest length.
@group(0) @binding(4) var<storage, read> rest: array<vec4<f32>>;

fn unbroken(edge: Edge) -> bool {
  return rest[edge.stored][edge.direction] > 0.0;
}
