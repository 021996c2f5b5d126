//! Cloths whose contact is computed together, as shaders read them: their particles lie one cloth after the other, as do their grids.

use super::boxes::{TILE, levels};
use super::safe::ROUNDS;
use crate::cloth::{Cloth, ContactTier};
use crate::layout::GridRow;

/// Marks a texel without a particle among first duplicates.
const NOBODY: u32 = u32::MAX;
/// Numbers of the head of the table.
const HEAD: u32 = 16;
/// Particles between the first ones of two cloths are a multiple of it: parts of buffers that are bound begin at multiples of 256 bytes.
const STRIDE: usize = 64;

/// Counters of the cloths whose contact is safe, and their number: for each round but the last whether a step needs a further one; pins that left
/// their half-spaces and particles that are too fast, in the step and the most of all steps before it in the frame.
pub const COUNT_MORE: usize = 0;
pub const COUNT_FORCED: usize = ROUNDS as usize - 1;
pub const COUNT_SLOWED: usize = COUNT_FORCED + 1;
pub const COUNT_FORCED_MOST: usize = COUNT_FORCED + 2;
pub const COUNT_SLOWED_MOST: usize = COUNT_FORCED + 3;
pub const COUNTS: usize = (COUNT_FORCED + 4).next_multiple_of(4);

/// Some cloths, laid out together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Joint {
    /// The first particle of each cloth, a multiple of 64.
    pub firsts: Vec<u32>,
    /// Particles that there is room for.
    pub particles: usize,
    /// All grids; their first particles are those of the joint list.
    pub grids: Vec<GridRow>,
    /// Tiles of 4 x 4 particles, and all boxes: tiles come first.
    pub tiles: usize,
    pub boxes: usize,
    /// As shaders read it ([`Joint::of`]).
    pub table: Vec<u32>,
}

impl Joint {
    /// That of some cloths with their contact distances \[m\].
    ///
    /// The table begins with 16 numbers, by their place: 0 the number of grids, 2 where the levels of each grid are listed, 3 where first duplicates begin, 4 the number of
    /// tiles, 5 where the next duplicates begin, 6 where tiles begin, 7 where grids begin, 8 the number of boxes; the others are 0. Then follow: two
    /// numbers per grid (where its levels begin, and how many they are), three per level (first box, columns, rows), the first duplicate of each
    /// particle (all ones for none), the next duplicate of each (itself off the seams), two per tile (grid; column and row, 16 bits each), and eight
    /// per grid: number of the cloth, the bits of its distance \[m\], friction and distance of neighbours \[m\] (0 if it may cross), first particle,
    /// columns, rows, first tile.
    pub fn of(cloths: &[&Cloth], distances: &[f32]) -> Self {
        let mut joint = Joint::default();
        let (mut points, mut mates, mut spots, mut owners) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (number, (cloth, distance)) in cloths.iter().zip(distances).enumerate() {
            let first = joint.particles as u32;
            joint.firsts.push(first);
            let each = cloth.points().into_iter().zip(cloth.particles());
            points.extend(each.map(|(point, p)| if p.exists() { first + point } else { NOBODY }));
            mates.extend((0..cloth.len() as u32).map(|k| first + k));
            for ring in 0..cloth.ring_count() {
                let ring = cloth.ring(ring);
                let next = ring.iter().cycle().skip(1);
                ring.iter().zip(next).for_each(|(k, mate)| mates[(first + k) as usize] = first + mate);
            }
            joint.particles += cloth.len().next_multiple_of(STRIDE);
            points.resize(joint.particles, NOBODY);
            mates.resize(joint.particles, NOBODY);
            let contact = cloth.contact.unwrap_or_default();
            let spacing = if contact.tier == ContactTier::Safe { cloth.spacing() } else { 0.0 };
            let numbers = [*distance, contact.friction, spacing].map(f32::to_bits);
            for grid in cloth.grids() {
                let (g, tile) = (joint.grids.len() as u32, spots.len() as u32);
                let (at, width, height) = (first + grid.first, grid.width, grid.height);
                joint.grids.push(GridRow { first: at, width, height, soft: 0.0, rest: [0.0; 4] });
                let columns = 0..width.div_ceil(TILE);
                spots.extend((0..height.div_ceil(TILE)).flat_map(|j| columns.clone().map(move |i| [g, j << 16 | i])));
                owners.push([number as u32, numbers[0], numbers[1], numbers[2], at, width, height, tile]);
            }
        }
        joint.tiles = spots.len();
        let (mut tile, mut end) = (0, spots.len() as u32);
        let each = cloths.iter().flat_map(|cloth| cloth.grids()).map(|grid| {
            let levels = levels(grid, tile, &mut end);
            tile += levels[0][1] * levels[0][2];
            levels
        });
        let tables: Vec<_> = each.collect();
        joint.boxes = end as usize;
        let mut table = vec![0; HEAD as usize];
        let mut rows = HEAD + 2 * tables.len() as u32;
        for levels in &tables {
            table.extend([rows, levels.len() as u32]);
            rows += 3 * levels.len() as u32;
        }
        table.extend(tables.iter().flatten().flatten());
        (table[0], table[2], table[4], table[8]) = (tables.len() as u32, HEAD, spots.len() as u32, joint.boxes as u32);
        let lists = [(3, points), (5, mates), (6, spots.concat()), (7, owners.concat())];
        for (at, list) in lists {
            table[at] = table.len() as u32;
            table.extend(list);
        }
        joint.table = table;
        joint
    }

    /// Boxes with one per texel of each tile and how each tile's edges spread, which are two more.
    pub fn boxes_of_cells(&self) -> usize {
        self.boxes + (TILE * TILE + 2) as usize * self.tiles
    }
}
