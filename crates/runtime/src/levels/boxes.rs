//! Boxes of tiles of a cloth and those above them, and the numbers of contact, as shaders read them.

use crate::cloth::{Cloth, Grid, Kin};

/// Columns, and rows, of particles in a tile.
pub const TILE: u32 = 4;

/// The levels of a grid, from tiles to one box: first box, columns and rows. `tiles` is the first tile of the grid, `end` the number of
/// boxes so far.
pub fn levels(grid: &Grid, tiles: u32, end: &mut u32) -> Vec<[u32; 3]> {
    let mut level = [tiles, grid.width.div_ceil(TILE), grid.height.div_ceil(TILE)];
    let mut all = vec![level];
    while level[1].max(level[2]) > 1 {
        level = [*end, level[1].div_ceil(2), level[2].div_ceil(2)];
        *end += level[1] * level[2];
        all.push(level);
    }
    all
}

/// The levels of all grids, tiles before all other boxes, and the number of boxes.
pub fn tables(cloth: &Cloth) -> (Vec<Vec<[u32; 3]>>, u32) {
    let tiles = |grid: &Grid| grid.width.div_ceil(TILE) * grid.height.div_ceil(TILE);
    let (mut end, mut first) = (cloth.grids().iter().map(tiles).sum(), 0);
    let each = cloth.grids().iter().map(|grid| {
        let levels = levels(grid, first, &mut end);
        first += tiles(grid);
        levels
    });
    let all = each.collect();
    (all, end)
}

/// Number of boxes of a cloth.
pub fn count(cloth: &Cloth) -> usize {
    tables(cloth).1 as usize
}

/// The numbers of contact as shaders/partners.wgsl reads them: the bits of distance \[m\] and friction, where four lists begin, and these
/// lists: two numbers per grid (where its levels begin, and how many they are) and three per level, the first duplicate of each particle,
/// and [`Kin::starts`] and [`Kin::members`].
pub fn kin(cloth: &Cloth, thickness: f32) -> Vec<u32> {
    let Some(contact) = &cloth.contact else { return Vec::new() };
    let (kin, (tables, _)) = (Kin::of(cloth), tables(cloth));
    let mut words = vec![cloth.contact_distance(thickness).to_bits(), contact.friction.to_bits(), 8, 0, 0, 0, 0, 0];
    let mut rows = words[2] + 2 * tables.len() as u32;
    for levels in &tables {
        words.extend([rows, levels.len() as u32]);
        rows += 3 * levels.len() as u32;
    }
    words.extend(tables.iter().flatten().flatten());
    for (n, list) in [&kin.first, &kin.starts, &kin.members].into_iter().enumerate() {
        words[3 + n] = words.len() as u32;
        words.extend(list);
    }
    words
}
