//! Pairs of tiles whose boxes meet, from the top of the tree down.

use super::tree::{Level, Tree};
use crate::memory::Tally;
use crate::number::real::Real;

/// For each tile the tiles whose particles it may meet.
#[derive(Default)]
pub struct Beside {
    starts: Vec<u32>,
    tiles: Vec<u32>,
}

impl Beside {
    /// Those of `count` tiles.
    pub fn new<T: Real>(tree: &Tree<T>, count: usize) -> Self {
        let pairs = Pairs::of(tree);
        let mut starts = vec![0u32; count + 1];
        let both = |[a, b]: [u32; 2]| [Some((a, b)), (a != b).then_some((b, a))].into_iter().flatten();
        pairs.iter().flat_map(|pair| both(*pair)).for_each(|(a, _)| starts[a as usize + 1] += 1);
        (1..starts.len()).for_each(|n| starts[n] += starts[n - 1]);
        let mut ends = starts.clone();
        let mut tiles = vec![0; starts.last().map_or(0, |end| *end as usize)];
        for (a, b) in pairs.iter().flat_map(|pair| both(*pair)) {
            tiles[ends[a as usize] as usize] = b;
            ends[a as usize] += 1;
        }
        Beside { starts, tiles }
    }

    /// Those of a tile; none before the first search.
    pub fn of(&self, tile: usize) -> &[u32] {
        match self.starts.get(tile..tile + 2) {
            Some(ends) => &self.tiles[ends[0] as usize..ends[1] as usize],
            None => &[],
        }
    }

    /// Numbers that it takes.
    pub fn tally(&self, tally: &mut Tally) {
        tally.state(&self.starts);
        tally.state(&self.tiles);
    }
}

/// Goes down the tree, from pair to pair.
struct Pairs<'a, T: Real> {
    tree: &'a Tree<T>,
    found: Vec<[u32; 2]>,
}

/// A box: the level of its sheet, its column and its row.
#[derive(Clone, Copy, PartialEq)]
struct Cell {
    level: usize,
    column: usize,
    row: usize,
}

impl<T: Real> Pairs<'_, T> {
    /// Pairs of tiles whose boxes meet.
    fn of(tree: &Tree<T>) -> Vec<[u32; 2]> {
        let mut pairs = Pairs { tree, found: Vec::new() };
        for (g, levels) in tree.sheets.iter().enumerate() {
            pairs.within(levels, top(levels));
            for others in &tree.sheets[g + 1..] {
                cross([(tree, levels), (tree, others)], [top(levels), top(others)], &mut pairs.found);
            }
        }
        pairs.found
    }

    /// Pairs in one part of a sheet.
    fn within(&mut self, levels: &[Level], cell: Cell) {
        if cell.level == 0 {
            self.found.push([node(levels, cell) as u32; 2]);
            return;
        }
        let cells = below(levels, cell);
        for (n, a) in cells.clone().enumerate() {
            self.within(levels, a);
            cells.clone().skip(n + 1).for_each(|b| self.beside(levels, a, b));
        }
    }

    /// Pairs of two parts of a sheet on one level.
    fn beside(&mut self, levels: &[Level], a: Cell, b: Cell) {
        let (m, n) = (node(levels, a), node(levels, b));
        if !self.tree.nodes[m].meets(&self.tree.nodes[n]) {
            return;
        }
        if a.level == 0 {
            self.found.push([m as u32, n as u32]);
            return;
        }
        for c in below(levels, a) {
            below(levels, b).for_each(|d| self.beside(levels, c, d));
        }
    }
}

/// The box of a whole sheet.
fn top(levels: &[Level]) -> Cell {
    Cell { level: levels.len() - 1, column: 0, row: 0 }
}

fn node(levels: &[Level], cell: Cell) -> usize {
    let level = levels[cell.level];
    level.first + cell.row * level.columns + cell.column
}

fn below(levels: &[Level], cell: Cell) -> impl Iterator<Item = Cell> + Clone {
    let level = levels[cell.level - 1];
    let (i, j) = (2 * cell.column, 2 * cell.row);
    let columns = i..(i + 2).min(level.columns);
    let cells = (j..(j + 2).min(level.rows)).flat_map(move |row| columns.clone().map(move |column| (column, row)));
    cells.map(move |(column, row)| Cell { level: cell.level - 1, column, row })
}

/// Pairs of tiles of two cloths whose boxes meet.
pub fn between<T: Real>(a: &Tree<T>, b: &Tree<T>) -> Vec<[u32; 2]> {
    let mut found = Vec::new();
    for (one, other) in a.sheets.iter().flat_map(|one| b.sheets.iter().map(move |other| (one, other))) {
        cross([(a, one), (b, other)], [top(one), top(other)], &mut found);
    }
    found
}

/// Pairs of parts of two sheets; the larger one is divided first.
fn cross<T: Real>(sheets: [(&Tree<T>, &[Level]); 2], [a, b]: [Cell; 2], found: &mut Vec<[u32; 2]>) {
    let [(tree, levels), (other, others)] = sheets;
    let (m, n) = (node(levels, a), node(others, b));
    if !tree.nodes[m].meets(&other.nodes[n]) {
        return;
    }
    if a.level == 0 && b.level == 0 {
        found.push([m as u32, n as u32]);
    } else if a.level >= b.level {
        below(levels, a).for_each(|c| cross(sheets, [c, b], found));
    } else {
        below(others, b).for_each(|d| cross(sheets, [a, d], found));
    }
}
