//! How far the particles of a cloth are from its pins.

use std::collections::VecDeque;

use crate::cloth::Cloth;

/// No way leads there.
const NONE: u32 = u32::MAX;
/// The share of particles that counts: corners of an image lie far from all others.
const SHARE: f64 = 0.95;

/// The way to the nearest pin that 95 % of the particles do not exceed, in cells along rows, columns and seams; infinite if more than the rest have no
/// such way. Takes time linear in the particles.
pub fn to_pins(cloth: &Cloth) -> f64 {
    let cells = cells(cloth);
    let there = cells.iter().zip(cloth.particles()).filter(|(_, p)| p.exists());
    let mut there: Vec<u32> = there.map(|(cells, _)| *cells).collect();
    if there.is_empty() {
        return 0.0;
    }
    let place = (SHARE * (there.len() - 1) as f64) as usize;
    match *there.select_nth_unstable(place).1 {
        NONE => f64::INFINITY,
        cells => f64::from(cells),
    }
}

/// The way of each particle.
fn cells(cloth: &Cloth) -> Vec<u32> {
    let particles = cloth.particles();
    let (mut cells, mut ring_of) = (vec![NONE; cloth.len()], vec![NONE; cloth.len()]);
    for ring in 0..cloth.ring_count() {
        cloth.ring(ring).iter().for_each(|k| ring_of[*k as usize] = ring as u32);
    }
    let mut next: VecDeque<usize> = (0..cloth.len()).filter(|k| particles[*k].is_pinned()).collect();
    next.iter().for_each(|k| cells[*k] = 0);
    while let Some(k) = next.pop_front() {
        let own = cells[k];
        // Duplicates of a seam point are one point.
        if ring_of[k] != NONE {
            for twin in cloth.ring(ring_of[k] as usize).iter().map(|twin| *twin as usize) {
                if cells[twin] > own {
                    cells[twin] = own;
                    next.push_front(twin);
                }
            }
        }
        let Some(grid) = cloth.grids().iter().rev().find(|grid| grid.first as usize <= k) else { continue };
        let (first, width, height) = (grid.first as usize, grid.width as usize, grid.height as usize);
        let (i, j) = ((k - first) % width, (k - first) / width);
        let mut go = |there: bool, other: usize| {
            if there && particles[other].exists() && cells[other] > own + 1 {
                cells[other] = own + 1;
                next.push_back(other);
            }
        };
        go(i > 0, k.wrapping_sub(1));
        go(i + 1 < width, k + 1);
        go(j > 0, k.wrapping_sub(width));
        go(j + 1 < height, k + width);
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloth::Flat;

    #[test]
    fn ways_are_counted_from_the_nearest_pin() {
        let mut cloth = Flat::square("sheet", 9).cloth().unwrap();
        assert_eq!(to_pins(&cloth), f64::INFINITY);
        cloth.set_pinned(0, true).unwrap();
        assert_eq!(cells(&cloth)[80], 16);
        assert_eq!(to_pins(&cloth), 14.0);
        (0..9).for_each(|k| cloth.set_pinned(k, true).unwrap());
        assert_eq!(to_pins(&cloth), 8.0);
    }
}
