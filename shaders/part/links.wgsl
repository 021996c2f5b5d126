// Links to coarser grids after a cut: which of the four nodes around it each particle follows, and the mass that it
// adds to them; after the particles the same for the nodes of all levels. Laid out as `LinkRow` in
// crates/runtime/src/layout.rs.
struct Link {
  follows: u32,
  mass: f32,
}
@group(0) @binding(42) var<storage, read> links: array<Link>;

fn followed(k: u32) -> u32 {
  return links[k].follows;
}

fn followed_by_node(n: u32) -> u32 {
  return links[arrayLength(&links) - arrayLength(&nodes) / 2u + n].follows;
}
