//! Twin of shaders/tile.wgsl: how far a colour of springs reaches, which is what a tile has to have around it. The rules
//! of particles and springs are those of the separate passes.

/// Columns or rows that a colour joins along one side of a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reach {
    /// Nothing.
    None,
    /// Two of them, the first of which has this parity.
    Pair(u32),
    /// Each with the next.
    All,
}

/// The reach of springs of a direction and parity along x and y.
fn reach((direction, parity): (u32, u32)) -> [Reach; 2] {
    match direction {
        0 => [Reach::Pair(parity), Reach::None],
        1 => [Reach::None, Reach::Pair(parity)],
        _ => [Reach::All, Reach::Pair(parity)],
    }
}

/// Columns or rows that are still right after a colour, of those from the first of a range up to, not with, the last,
/// of a grid with `size` of them: springs that join them to others were left out.
fn within([from, to]: [i64; 2], size: i64, reach: Reach) -> [i64; 2] {
    let odd = |at: i64, parity: u32| (at - i64::from(parity)).rem_euclid(2);
    let (less, more) = match reach {
        Reach::None => (0, 0),
        Reach::Pair(parity) => (odd(from, parity), odd(to, parity)),
        Reach::All => (1, 1),
    };
    [if from > 0 { from + less } else { from }, if to < size { to - more } else { to }]
}

/// How many columns and rows a tile needs on every side of an even number of them, for these colours to leave those right;
/// and whether tiles had better begin at odd ones, as then they need fewer.
pub fn around(colours: &[(u32, u32)]) -> ([u32; 2], [u32; 2]) {
    // Far from the border of a grid, which nothing reaches across.
    const FAR: i64 = 1 << 20;
    let enough = |axis: usize, first: i64, n: i64| {
        let all = [FAR + first - n, FAR + first + 2 + n];
        let [from, to] = colours.iter().fold(all, |range, colour| within(range, i64::MAX, reach(*colour)[axis]));
        from <= FAR + first && to >= FAR + first + 2
    };
    let least = |axis: usize, first: i64| (0..).find(|n| enough(axis, first, *n)).unwrap_or(0);
    let of = |axis: usize| {
        let [even, odd] = [least(axis, 0), least(axis, 1)];
        if odd < even { (odd as u32, 1) } else { (even as u32, 0) }
    };
    let [x, y] = [of(0), of(1)];
    ([x.0, y.0], [x.1, y.1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::TileShape;

    const ALL: [(u32, u32); 8] = [(2, 0), (2, 1), (3, 0), (3, 1), (0, 0), (0, 1), (1, 0), (1, 1)];

    /// A spring that leaves a trace of everything it has met, and of the order.
    fn mix(a: &mut u64, b: &mut u64) {
        let of = |x: u64, y: u64| (x ^ y.rotate_left(17)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(23);
        (*a, *b) = (of(*a, *b), of(*b, a.wrapping_add(1)));
    }

    /// Springs of a colour that have both ends in a part of a grid.
    fn relax(all: &mut [u64], width: usize, [x, y]: [[i64; 2]; 2], (direction, parity): (u32, u32)) {
        let (right, down) = (i64::from(direction != 1), i64::from(direction != 0));
        for (j, i) in (y[0]..y[1] - down).flat_map(|j| (x[0]..x[1] - right).map(move |i| (j, i))) {
            if if direction == 0 { i } else { j } % 2 != i64::from(parity) {
                continue;
            }
            let (top, low) = (j as usize * width + i as usize, (j + down) as usize * width + i as usize);
            let right = right as usize;
            let (a, b) = if direction == 3 { (low, top + right) } else { (top, low + right) };
            let (mut p, mut q) = (all[a], all[b]);
            mix(&mut p, &mut q);
            (all[a], all[b]) = (p, q);
        }
    }

    #[test]
    fn what_a_tile_owns_comes_out_as_without_tiles() {
        let lists = [&ALL[..], &ALL[4..], &ALL[2..3], &[ALL, ALL].concat(), &[&ALL[..], &ALL[4..], &ALL[4..]].concat()];
        for (colours, (width, height)) in
            lists.iter().flat_map(|c| [(31, 26), (2, 40), (17, 3), (24, 24)].map(|s| (*c, s)))
        {
            let begin: Vec<u64> = (0..width * height).collect();
            let whole = [[0, width as i64], [0, height as i64]];
            let mut expected = begin.clone();
            colours.iter().for_each(|c| relax(&mut expected, width as usize, whole, *c));
            let (around, lacks) = around(colours);
            for inner in [[2u32, 2], [4, 10], [12, 6], [40, 40]] {
                let shape = TileShape { inner, lacks, ..TileShape::default() };
                let [columns, rows] = shape.tiles([width as u32, height as u32]);
                let mut seen = 0;
                for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
                    let size = [width as i64, height as i64];
                    let own = [0, 1].map(|d| {
                        let first = i64::from([column, row][d] * inner[d]) - i64::from(lacks[d]);
                        [first.max(0), (first + i64::from(inner[d])).min(size[d])]
                    });
                    let wide = |d: usize| {
                        let n = i64::from(around[d]);
                        [(own[d][0] - n).max(0), (own[d][1] + n).min(size[d])]
                    };
                    let (mut part, mut particles) = ([wide(0), wide(1)], begin.clone());
                    for colour in colours {
                        relax(&mut particles, width as usize, part, *colour);
                        part = [0, 1].map(|d| within(part[d], size[d], reach(*colour)[d]));
                    }
                    for (j, i) in (own[1][0]..own[1][1]).flat_map(|j| (own[0][0]..own[0][1]).map(move |i| (j, i))) {
                        let k = (j * size[0] + i) as usize;
                        assert_eq!(particles[k], expected[k], "{colours:?} {inner:?} ({i}, {j})");
                        seen += 1;
                    }
                }
                assert_eq!(seen, width * height);
            }
        }
    }

    /// `within` as the shader has it, in unsigned numbers; arithmetic out of their range is `None`.
    fn within_unsigned([from, to]: [u32; 2], size: u32, reach: Reach) -> Option<[u32; 2]> {
        let (less, more) = match reach {
            Reach::None => (0, 0),
            Reach::Pair(parity) => ((from ^ parity) & 1, (to ^ parity) & 1),
            Reach::All => (1, 1),
        };
        let (less, more) = (if from > 0 { less } else { 0 }, if to < size { more } else { 0 });
        Some([from.checked_add(less)?, to.max(more).checked_sub(more)?])
    }

    /// Rows of springs of a colour, and of particles that tethers hold, which the shader goes through.
    fn loops([x, y]: [[u32; 2]; 2], (direction, parity): (u32, u32)) -> [u32; 2] {
        let pairs = |[from, to]: [u32; 2]| [(from + 1 - parity) / 2, (to.max(parity) - parity) / 2];
        let cells = match direction {
            0 => [pairs(x), y],
            _ => [[x[0], x[1].max(1) - u32::from(direction != 1)], pairs(y)],
        };
        let rows = |[x, y]: [[u32; 2]; 2]| if x[1] > x[0] { y[1].max(y[0]) - y[0] } else { 0 };
        [rows(cells), rows([x, y])]
    }

    #[test]
    fn a_tile_past_the_end_of_its_grid_has_nothing_to_do() {
        let colours = [&ALL[..], &ALL[4..], &ALL[4..], &ALL[4..]].concat();
        let (around, lacks) = around(&colours);
        // Tiles of a larger grid, on grids that end before them, in them, or not at all.
        let sizes = (1..70u32).flat_map(|width| [1, 2, 3, 8, 21, 33, 64].map(|height| [width, height]));
        for (size, tile) in sizes.flat_map(|s| (0..4u32).flat_map(move |j| (0..4u32).map(move |i| (s, [i, j])))) {
            let inner = 16;
            let own = [0, 1].map(|d| {
                let low = (tile[d] * inner).max(lacks[d]) - lacks[d];
                [low.min(size[d]), ((tile[d] + 1) * inner - lacks[d]).min(size[d])]
            });
            let empty = own.iter().any(|o| o[0] >= o[1]);
            let mut part = [0, 1].map(|d| {
                let low = own[d][0].max(around[d]) - around[d];
                [low, if empty { low } else { (own[d][1] + around[d]).min(size[d]) }]
            });
            for colour in &colours {
                let done = loops(part, *colour);
                assert!(!empty || done == [0, 0], "{size:?} {tile:?} {colour:?}: {done:?}");
                let signed = [0, 1].map(|d| within(part[d].map(i64::from), i64::from(size[d]), reach(*colour)[d]));
                let next = [0, 1].map(|d| within_unsigned(part[d], size[d], reach(*colour)[d]));
                assert!(next.iter().all(Option::is_some), "{size:?} {tile:?} {colour:?}");
                part = next.map(Option::unwrap_or_default);
                assert!(empty || signed == part.map(|p| p.map(i64::from)), "{size:?} {tile:?} {colour:?}");
            }
        }
    }

    #[test]
    fn eight_colours_reach_five_particles_far() {
        assert_eq!(around(&ALL), ([5, 5], [1, 1]));
        assert_eq!(around(&ALL[4..]), ([1, 1], [1, 1]));
        assert_eq!(around(&[&ALL[..], &ALL[4..]].concat()), ([7, 7], [1, 1]));
        assert_eq!(around(&[]), ([0, 0], [0, 0]));
    }
}
