//! Rest lengths of springs that lie in one line.

use crate::cloth::{Cloth, Rest};

/// Largest rest length over that of the next spring of the same row or column, for cloth that hangs by springs alone: fine
/// ones between coarse ones are held by particles too light for what hangs on them.
pub const MOST_LENGTHS: f64 = 5.0;

/// The largest rest length over that of the next spring in its row or column; 1 where all are alike.
pub fn ratio(cloth: &Cloth) -> f64 {
    let mut ratio = 1f64;
    for (g, grid) in cloth.grids().iter().enumerate().filter(|_| matches!(cloth.rest(), Rest::Image(_))) {
        for (k, d) in (0..grid.texels()).flat_map(|k| [(k, 0), (k, 1)]) {
            let Some(next) = cloth.neighbour(g, k, d) else { continue };
            let [a, b] = [k, next - grid.first as usize].map(|k| f64::from(cloth.spring(g, k, d)));
            if a > 0.0 && b > 0.0 {
                ratio = ratio.max(a / b).max(b / a);
            }
        }
    }
    ratio
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Flat, Parts};

    #[test]
    fn the_ratio_is_that_of_neighbours_in_line() {
        let even = Flat::square("x", 4).cloth().unwrap();
        assert_eq!(ratio(&even), 1.0);
        // Rows are 0.2, 0.4 and 3.2 m apart, columns 1 m.
        let rest = (0..16).map(|k| [1.0, [0.2, 0.4, 3.2, 0.0][k / 4], 0.0, 0.0]).collect();
        let parts = Parts {
            name: "x".into(),
            grids: even.grids().to_vec(),
            positions: even.positions().to_vec(),
            particles: even.particles().to_vec(),
            rest: Rest::Image(rest),
            mass: crate::Mass::Constant(1e-3),
        };
        assert!((ratio(&Cloth::new(parts).unwrap()) - 8.0).abs() < 1e-5);
    }
}
