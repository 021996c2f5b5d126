// A dispatch of several cloths: which of them a workgroup works for.

// Whether the pass runs only in steps with forces of air, which cloths may have at different times.
override blows: bool = false;

var<private> cloth: Job;

// Takes the numbers of the step. `n` counts the cloths of the dispatch.
fn member(n: u32) {
  cloth = jobs_at(batch.x + n);
  find_lists(cloth);
  base = cloth.first;
  row = cloth.row;
  first_solid = cloth.solid;
  if (blows && part.x % cloth.hold != 0u) {
    cloth.count = 0u;
    cloth.grids = 0u;
  }
  begin(part.x, cloth);
}

// The grid of layer n. A cloth has as many layers as the cloth with the most grids: has_grid() tells whether the layer has a grid.
fn member_grid(n: u32) -> u32 {
  member(n / batch.y);
  return cloth.grid + min(n % batch.y, max(cloth.grids, 1u) - 1u);
}

fn has_grid(n: u32) -> bool {
  return n % batch.y < cloth.grids;
}
