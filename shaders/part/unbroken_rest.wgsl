// Cut springs have no rest length.
fn unbroken(edge: Edge) -> bool {
  return rest_at(edge.stored)[edge.direction] > 0.0;
}
