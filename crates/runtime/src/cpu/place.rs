//! Twin of shaders/place.wgsl: puts particles at given positions, at rest, and gives them other inverse masses.

use crate::number::real::{Real, cast, with_w};

/// A change of one particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    pub particle: u32,
    /// Position \[m\], if it moves.
    pub at: Option<[f32; 3]>,
    /// Inverse mass \[1/kg\], 0 if it is pinned, if that changes.
    pub inverse_mass: Option<f32>,
}

/// Bits of a row beside the particle, in the shader: whether it moves, and whether its inverse mass changes.
pub const PLACE_MOVES: u32 = 1 << 30;
pub const PLACE_WEIGHS: u32 = 1 << 31;

/// In the order of the rows: of several for one particle the last counts.
pub fn run<T: Real>(now: &mut [[T; 4]], before: &mut [[T; 4]], rows: &[Placed]) {
    for row in rows {
        let k = row.particle as usize;
        if let Some(at) = row.at {
            let at = cast(at);
            (now[k], before[k]) = (with_w(at, now[k][3]), with_w(at, before[k][3]));
        }
        if let Some(w) = row.inverse_mass {
            (now[k][3], before[k][3]) = (T::of(w.into()), T::of(w.into()));
        }
    }
}

/// One row per particle, in the order of particles, with the same result.
pub fn merged(rows: &[Placed]) -> Vec<Placed> {
    let mut rows = rows.to_vec();
    // Stable: the order of the rows of one particle stays.
    rows.sort_by_key(|row| row.particle);
    rows.dedup_by(|later, kept| {
        let same = later.particle == kept.particle;
        if same {
            kept.at = later.at.or(kept.at);
            kept.inverse_mass = later.inverse_mass.or(kept.inverse_mass);
        }
        same
    });
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merged_rows_do_the_same() {
        let row = |particle, at, inverse_mass| Placed { particle, at, inverse_mass };
        let rows = [
            row(2, Some([1.0; 3]), None),
            row(0, None, Some(0.0)),
            row(2, None, Some(5.0)),
            row(0, Some([2.0; 3]), Some(3.0)),
            row(2, Some([4.0; 3]), None),
        ];
        let apply = |rows: &[Placed]| {
            let (mut now, mut before) = (vec![[7f32; 4]; 3], vec![[8f32; 4]; 3]);
            run(&mut now, &mut before, rows);
            (now, before)
        };
        let merged = merged(&rows);
        assert_eq!(merged.len(), 2);
        assert_eq!(apply(&merged), apply(&rows));
        assert_eq!(apply(&rows).0, [[2.0, 2.0, 2.0, 3.0], [7.0; 4], [4.0, 4.0, 4.0, 5.0]]);
    }
}
