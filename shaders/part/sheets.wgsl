// The table of all cloths with contact (crates/runtime/src/levels/joint.rs).
@group(0) @binding(67) var<storage, read> kin: array<u32>;

const NOBODY: u32 = 0xffffffffu;

// A grid: the distance of neighbours of its cloth, 0 for cloth that may cross, its first particle, columns and rows, and its first tile.
struct Sheet {
  number: u32,
  spacing: f32,
  first: u32,
  width: u32,
  height: u32,
  tile: u32,
}

fn sheet_at(g: u32) -> Sheet {
  let row = kin[7] + 8u * g;
  return Sheet(g, bitcast<f32>(kin[row + 3u]), kin[row + 4u], kin[row + 5u], kin[row + 6u], kin[row + 7u]);
}

// The grid of a tile, and its first texel.
fn sheet_of_tile(tile: u32) -> Sheet {
  return sheet_at(kin[kin[6] + 2u * tile]);
}

fn corner_of_tile(tile: u32) -> vec2<u32> {
  let corner = kin[kin[6] + 2u * tile + 1u];
  return 4u * vec2<u32>(corner & 0xffffu, corner >> 16u);
}

// The place of a texel among those of tiles.
fn place_of(sheet: Sheet, at: vec2<u32>) -> u32 {
  let tile = sheet.tile + at.y / 4u * ((sheet.width + 3u) / 4u) + at.x / 4u;
  return tile * 16u + at.y % 4u * 4u + at.x % 4u;
}

// Where the boxes of cells, and how tiles spread, lie among boxes.
fn cell_at(place: u32) -> u32 {
  return 2u * (kin[8] + place);
}

fn spread_at(tile: u32) -> u32 {
  return 2u * (kin[8] + 16u * kin[4]) + 4u * tile;
}

fn point_of(k: u32) -> u32 {
  return kin[kin[3] + k];
}

fn largest(v: vec3<f32>) -> f32 {
  return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

// The least gap of features at a place, with room for the rounding of positions.
fn floor_at(spacing: f32, at: vec3<f32>) -> f32 {
  return max(spacing * FLOOR_SHARE, largest(at) * (8.0 * HELD_ROUNDING));
}

fn bit(bits: u32, n: u32) -> bool {
  return ((bits >> n) & 1u) == 1u;
}
