//! The grid to which a file has rounded positions.
//!
//! Draco moves the positions of a primitive to the nodes of a grid of 2^b - 1 cells along the longest side of their box. Each primitive has a
//! grid of its own, so what was one point on the borders of two of them comes out as two. Files that were
//! compressed once and then written without compression still have the cracks, so the grid is found from the numbers.

/// Numbers of bits that are looked for. Grids of fewer would be wider than a thousandth of the box, and those of more are as fine as numbers of
/// 32 bits far from zero.
const BITS: std::ops::RangeInclusive<u32> = 10..=18;
/// Coordinates inside of the box that have to lie on a grid: fewer do so by chance.
const LEAST: usize = 24;
/// Roundings of a number of 32 bits on its way from a node to a coordinate.
const ROUNDINGS: f64 = 4.0;

/// The width of the cells of the grid on which positions lie, three numbers each; 0 if there is none. O(n).
pub(crate) fn of(positions: &[f32]) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in positions.as_chunks::<3>().0 {
        for c in 0..3 {
            low[c] = low[c].min(p[c].into());
            high[c] = high[c].max(p[c].into());
        }
    }
    let range = (0..3).map(|c| high[c] - low[c]).fold(0.0, f64::max);
    let largest = low.iter().chain(&high).fold(0.0f64, |most, x| most.max(x.abs()));
    if !(range > 0.0 && largest.is_finite()) {
        return 0.0;
    }
    let slack = ROUNDINGS * f64::from(f32::EPSILON) / 2.0 * (largest + range);
    let fits = |cell: f64| {
        let mut inside = 0;
        for p in positions.as_chunks::<3>().0 {
            for c in 0..3 {
                let at = (f64::from(p[c]) - low[c]) / cell;
                if (at - at.round()).abs() * cell > slack {
                    return false;
                }
                let ends = f64::from(p[c]) == low[c] || f64::from(p[c]) == high[c];
                inside += usize::from(!ends);
            }
        }
        inside >= LEAST
    };
    // Where slack takes a good part of a cell, anything would fit.
    let cells = BITS.map(|bits| range / f64::from((1u32 << bits) - 1)).filter(|cell| slack < 0.2 * cell);
    cells.into_iter().find(|cell| fits(*cell)).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positions that are on no grid.
    fn cloud() -> Vec<f32> {
        (0..300).map(|n| (f64::from(n) * 0.618_034).fract() as f32 * [1.3, 0.8, 0.4][n as usize % 3] - 0.2).collect()
    }

    /// As Draco rounds them.
    fn rounded(positions: &[f32], bits: u32) -> (Vec<f32>, f32) {
        let of = |c: usize| positions.iter().skip(c).step_by(3).copied();
        let low = [0, 1, 2].map(|c| of(c).fold(f32::INFINITY, f32::min));
        let high = [0, 1, 2].map(|c| of(c).fold(f32::NEG_INFINITY, f32::max));
        let cell = (0..3).map(|c| high[c] - low[c]).fold(0.0, f32::max) / ((1u32 << bits) - 1) as f32;
        let at = |(n, x): (usize, &f32)| low[n % 3] + ((x - low[n % 3]) / cell).round() * cell;
        (positions.iter().enumerate().map(at).collect(), cell)
    }

    #[test]
    fn the_cells_of_rounded_positions_are_found() {
        for bits in [10, 11, 12, 14, 16] {
            let (positions, cell) = rounded(&cloud(), bits);
            let found = of(&positions);
            assert!((found / f64::from(cell) - 1.0).abs() < 1e-3, "{bits} bits: {found}, not {cell}");
        }
    }

    #[test]
    fn other_positions_have_no_grid() {
        assert_eq!(of(&cloud()), 0.0);
        assert_eq!(of(&[]), 0.0);
        assert_eq!(of(&[1.0; 300]), 0.0);
        assert_eq!(of(&[f32::NAN; 300]), 0.0);
        // Few points lie on many grids.
        assert_eq!(of(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]), 0.0);
        let sheet: Vec<f32> = (0..3600).flat_map(|k| [(k % 60) as f32 / 59.0, (k / 60) as f32 / 59.0, 0.0]).collect();
        assert_eq!(of(&sheet), 0.0);
    }
}
