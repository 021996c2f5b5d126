// The grids of a cloth.
@group(0) @binding(1) var<storage, read> grids: array<Grid>;

fn grids_at(g: u32) -> Grid {
  return grids[g];
}
