//! How large tiles are.

use super::Tile;
use crate::cloth::Grid;
use crate::cpu::tile::tiles;
use crate::fused::{NOTES, Room};

/// Sizes of tiles, in columns and rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Shape {
    /// What a tile owns; both even.
    pub inner: [u32; 2],
    /// How many it has on every side beside these, where the grid has any.
    pub around: [u32; 2],
    /// 1 where the first tile lacks a column or row, so that tiles begin at odd ones.
    pub lacks: [u32; 2],
    /// Columns and rows that there is room for.
    pub room: [u32; 2],
}

/// Bytes of a particle in a workgroup's memory.
const BYTES: u32 = 16;
/// Particles that every device has room for. Larger tiles relax less that they do not own.
const USUAL: u32 = 1024;
/// Beyond, more would gain little.
const LARGE: u32 = 2304;
/// A tile that loads so many times what it owns makes no further round of springs.
const DEAR: u64 = 4;

impl Tile {
    /// With sizes, if a device has room for it.
    pub(super) fn fit(self, grids: &[Grid], room: &Room) -> Option<Self> {
        let (around, lacks) = self.around();
        let beside = if self.contact.is_some_and(|k| k.many) { NOTES } else { 0 };
        let most = (room.memory.saturating_sub(beside) / BYTES).min(LARGE);
        let shape = |places: u32| best(Shape { around, lacks, ..Shape::default() }, grids, places);
        // Large ones only where there are enough of them to keep a device busy.
        let large = shape(most).filter(|s| count(s, grids) >= room.busy || most <= USUAL);
        let shape = large.or_else(|| shape(most.min(USUAL)))?;
        let particles: u64 = grids.iter().map(|g| u64::from(g.width) * u64::from(g.height)).sum();
        if self.polish > 0 && loads(&shape, grids) > DEAR * particles {
            return None;
        }
        // As many as a colour has springs.
        let threads = (shape.room[0] * shape.room[1] / 2).next_power_of_two().clamp(64, room.threads.min(512));
        Some(Tile { shape, threads, ..self })
    }
}

/// Tiles of all grids.
fn count(shape: &Shape, grids: &[Grid]) -> u32 {
    grids.iter().map(|g| tiles(g, shape.inner, shape.lacks)).map(|[x, y]| x * y).sum()
}

/// Particles that all tiles have room for.
fn loads(shape: &Shape, grids: &[Grid]) -> u64 {
    u64::from(count(shape, grids)) * u64::from(shape.room[0]) * u64::from(shape.room[1])
}

/// The shape that loads least, of all that `places` particles are enough for.
fn best(like: Shape, grids: &[Grid], places: u32) -> Option<Shape> {
    let [width, height] = [|g: &Grid| g.width, |g: &Grid| g.height].map(|s| grids.iter().map(s).max().unwrap_or(0));
    let Shape { around, lacks, .. } = like;
    let columns = (width + lacks[0]).next_multiple_of(2);
    let shapes = (2..=columns).step_by(2).filter_map(|x| {
        let wide = (x + 2 * around[0]).min(width);
        let high = places / wide.max(1);
        let whole = (height + lacks[1]).next_multiple_of(2);
        let most = if high >= height { whole } else { high.checked_sub(2 * around[1])? & !1 };
        // As many as that takes, but alike.
        let parts = (height + lacks[1]).div_ceil(Some(most).filter(|m| *m > 0)?);
        let y = (height + lacks[1]).div_ceil(parts).next_multiple_of(2);
        Some(Shape { inner: [x, y], room: [wide, (y + 2 * around[1]).min(height)], ..like })
    });
    shapes.min_by_key(|s| (loads(s, grids), s.room[0].abs_diff(s.room[1])))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(width: u32, height: u32) -> Grid {
        Grid { name: String::new(), first: 0, width, height }
    }

    #[test]
    fn tiles_fit_the_memory_and_cover_the_grid() {
        for (width, height) in [(2, 2), (2, 1000), (70, 70), (129, 65), (512, 512), (3, 17)] {
            for (places, n) in [(1024, 5), (992, 7), (2304, 5), (1024, 0)] {
                let like = Shape { around: [n; 2], lacks: [n & 1; 2], ..Shape::default() };
                let grids = [grid(width, height)];
                let shape = best(like, &grids, places).unwrap();
                assert!(shape.room[0] * shape.room[1] <= places, "{shape:?}");
                assert!(shape.inner.iter().all(|s| s % 2 == 0 && *s > 0), "{shape:?}");
                let room = [0, 1].map(|d| shape.room[d] >= (shape.inner[d] + 2 * n).min([width, height][d]));
                assert_eq!(room, [true; 2], "{shape:?}");
            }
        }
        // What fits is one tile.
        let like = Shape { around: [5; 2], lacks: [1; 2], ..Shape::default() };
        assert_eq!(count(&best(like, &[grid(2, 500)], 1024).unwrap(), &[grid(2, 500)]), 1);
        let large = [grid(512, 512)];
        let square = best(like, &large, 1024).unwrap();
        assert!(square.inner.iter().all(|s| (18..=28).contains(s)), "{square:?}");
        assert!(loads(&square, &large) < 9 * 512 * 512 / 4, "{square:?}");
    }
}
