//! The test piece: a disk that a plate holds, as a grid of rings around the plate.

use std::f64::consts::TAU;

use gimage_runtime::{Cloth, Grid, Mass, Material, Particle, Parts, Rest};

use crate::Failure;

/// Radii \[m\] of the plate and of the piece: those of G. E. Cusick, "The measurement of fabric drape", J. Textile Inst. 59 (1968).
pub const PLATE: f64 = 0.09;
/// See [`PLATE`].
pub const RIM: f64 = 0.15;
/// Cells around the piece for one from the plate to the rim; cells in the middle are then squares.
const AROUND: u32 = 12;
/// Height \[m\] by which the rim starts above or below the plate, at most.
const BUMP: f64 = 1e-3;
/// Waves of that height around the rim.
const WAVES: std::ops::Range<u32> = 2..13;

/// A piece at its start: rows are rings, from one ring inside of the plate's edge to the rim; the first and the last column
/// are sewn.
pub struct Piece {
    /// The cloth.
    pub cloth: Cloth,
    cells: [u32; 2],
}

impl Piece {
    /// A piece of `along` cells from the plate to the rim. `start` says which waves its rim starts with, the same on every
    /// grid.
    pub fn new(along: u32, start: u32, fabric: &Material, damping: f32) -> Result<Self, Failure> {
        let around = AROUND * along;
        let (width, height) = (around + 1, along + 2);
        // Duplicates are equal bit for bit.
        let place = |k: u32| -> [f64; 2] {
            let angle = TAU * f64::from(k % width % around) / f64::from(around);
            let radius = PLATE + (RIM - PLATE) * (f64::from(k / width) - 1.0) / f64::from(along);
            [radius * angle.cos(), radius * angle.sin()]
        };
        let count = width * height;
        let flat: Vec<[f64; 2]> = (0..count).map(place).collect();
        let far = |a: u32, b: u32| {
            let (a, b) = (flat[a as usize], flat[b as usize]);
            (a[0] - b[0]).hypot(a[1] - b[1]) as f32
        };
        let rest = (0..count).map(|k| {
            let (right, down, up) = (k % width + 1 < width, k / width + 1 < height, k >= width);
            let to = |there: bool, other: u32| if there { far(k, other) } else { 0.0 };
            let falls = to(right && down, k + width + 1);
            [to(right, k + 1), to(down, k + width), falls, to(right && up, (k + 1).wrapping_sub(width))]
        });
        let particle = |k: u32| Particle::Free {
            next: match k % width {
                0 => Some(k + around),
                i if i == around => Some(k - around),
                _ => None,
            },
        };
        let wave = Waves::new(start);
        let mut cloth = Cloth::new(Parts {
            name: "piece".into(),
            grids: vec![Grid { name: "piece".into(), first: 0, width, height }],
            positions: flat.iter().map(|p| [p[0] as f32, wave.height(*p) as f32, p[1] as f32]).collect(),
            particles: (0..count).map(particle).collect(),
            rest: Rest::Image(rest.collect()),
            mass: Mass::Constant(1.0),
        })?;
        cloth.set_grain(Some(flat.iter().map(|p| p.map(|x| x as f32)).collect()))?;
        cloth.set_material(fabric)?;
        cloth.damping = damping;
        // Two rings hold the slope at the edge of the plate.
        cloth.pin(&(0..2 * width).collect::<Vec<u32>>())?;
        Ok(Piece { cloth, cells: [around, along] })
    }

    /// Cells around the rim and from the plate to the rim.
    pub fn cells(&self) -> [u32; 2] {
        self.cells
    }

    /// Where its particles lie on a table.
    pub fn flat(&self) -> Vec<[f64; 4]> {
        self.cloth.positions().iter().map(|p| [p[0].into(), 0.0, p[2].into(), 1.0]).collect()
    }

    /// The points of its rim, in a circle.
    pub fn rim<'a>(&self, now: &'a [[f64; 4]]) -> &'a [[f64; 4]] {
        let around = self.cells[0] as usize;
        now.len().checked_sub(around + 1).map_or(&[], |first| &now[first..first + around])
    }

    /// Corners of the cells outside of the plate.
    pub fn quads(&self) -> impl Iterator<Item = [usize; 4]> {
        let [around, along] = self.cells.map(|n| n as usize);
        let width = around + 1;
        (1..=along)
            .flat_map(move |j| (0..around).map(move |i| j * width + i))
            .map(move |k| [k, k + 1, k + width + 1, k + width])
    }
}

/// Waves around the rim, which grow from the plate outwards.
struct Waves(Vec<[f64; 2]>);

impl Waves {
    fn new(start: u32) -> Self {
        // Weyl sequences: any two starts differ, and no random numbers are needed.
        let part = |k: u32, by: f64| (f64::from(1 + start * 64 + k) * by).fract();
        Waves(WAVES.map(|k| [part(k, 0.618_033_988_75), TAU * part(k, 0.754_877_666_25)]).collect())
    }

    fn height(&self, [x, z]: [f64; 2]) -> f64 {
        let (angle, out) = (z.atan2(x), ((x.hypot(z) - PLATE) / (RIM - PLATE)).max(0.0));
        let each = self.0.iter().zip(WAVES).map(|([size, phase], k)| size * (f64::from(k) * angle + phase).cos());
        // The slope at the plate's edge is 0.
        BUMP * out * out * each.sum::<f64>() / self.0.len() as f64
    }
}
