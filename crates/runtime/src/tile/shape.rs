//! The sizes of tiles.

use super::reach::around;
use crate::form::{Tile, TileShape};
use crate::fused::{NOTES, Room};
use crate::passes::Pass;
use crate::shaders::{Over, over};

/// Bytes of a particle in a workgroup's memory, and of its springs' multipliers.
const BYTES: u32 = 16;
/// Particles that every device has room for. Larger tiles relax less that they do not own.
const USUAL: u32 = 1024;
/// Beyond, more would gain little.
const LARGE: u32 = 2304;
/// A tile that loads more than this number of times what it owns makes no further round of springs.
const DEAR: u64 = 4;

impl Tile {
    /// With sizes, if a device has room for it.
    pub(super) fn fit(self, grids: &[[u32; 2]], room: &Room) -> Option<Self> {
        let colours: Vec<_> = self.colours().collect();
        let (around, lacks) = around(&colours);
        let near = self.passes.iter().any(|p| matches!(over(*p), Over::Near));
        let sums = self.passes.iter().any(|p| matches!(p, Pass::Stretch { again: true, .. }));
        let beside = if near { NOTES } else { 0 };
        let most = (room.memory.saturating_sub(beside) / if sums { 2 * BYTES } else { BYTES })
            .min(if room.tuning.particles().is_some() { u32::MAX } else { LARGE });
        let shape = |places: u32| best(TileShape { around, lacks, ..TileShape::default() }, grids, places);
        // Large ones only where there are enough of them to keep a device busy, unless the host has measured what suits it.
        let measured = room.tuning.particles().map(|n| n.min(most));
        let large = measured
            .or(Some(most))
            .and_then(shape)
            .filter(|s| measured.is_some() || count(s, grids) >= room.busy || most <= USUAL);
        let shape = large.or_else(|| shape(most.min(USUAL)))?;
        let particles: u64 = grids.iter().map(|[w, h]| u64::from(*w) * u64::from(*h)).sum();
        let rounds = colours.iter().filter(|c| Some(*c) == colours.last()).count();
        if rounds > 1 && loads(&shape, grids) > DEAR * particles {
            return None;
        }
        // As many as a colour has springs.
        let threads = (shape.room[0] * shape.room[1] / 2)
            .next_power_of_two()
            .clamp(64, room.tuning.for_tile(room.threads, 512.min(room.threads)));
        Some(Tile { shape, threads, ..self })
    }
}

/// Tiles of all grids.
fn count(shape: &TileShape, grids: &[[u32; 2]]) -> u32 {
    grids.iter().map(|g| shape.tiles(*g)).map(|[x, y]| x * y).sum()
}

/// Particles that all tiles read.
pub(super) fn loads(shape: &TileShape, grids: &[[u32; 2]]) -> u64 {
    let along = |g: &[u32; 2], d: usize| shape.extents(g[d], d).map(u64::from).sum::<u64>();
    grids.iter().map(|g| along(g, 0) * along(g, 1)).sum()
}

impl TileShape {
    /// Columns, or rows, that tiles read along a side of a grid: those at its ends have nothing beyond.
    fn extents(&self, side: u32, axis: usize) -> impl Iterator<Item = u32> {
        let (inner, around, lacks) = (self.inner[axis], self.around[axis], self.lacks[axis]);
        (0..(side + lacks).div_ceil(inner)).map(move |tile| {
            let (low, high) = ((tile * inner).max(lacks) - lacks, ((tile + 1) * inner - lacks).min(side));
            (high + around).min(side) - (low.max(around) - around)
        })
    }
}

/// The shape that loads least, of all that `places` particles are enough for.
fn best(like: TileShape, grids: &[[u32; 2]], places: u32) -> Option<TileShape> {
    let sides = [0, 1].map(|d| grids.iter().map(|g| g[d]).max().unwrap_or(0));
    let whole = |d: usize| (sides[d] + like.lacks[d]).next_multiple_of(2);
    let widest = |shape: &TileShape, d: usize| shape.extents(sides[d], d).max().unwrap_or(0);
    let shapes = (2..=whole(0)).step_by(2).filter_map(|x| {
        let mut shape = TileShape { inner: [x, 2], ..like };
        shape.room[0] = widest(&shape, 0);
        let high = places / shape.room[0].max(1);
        // All rows, half of them, or what there is room for; then as many parts, but alike.
        let some = high.saturating_sub(2 * like.around[1]) & !1;
        let all = [whole(1), (whole(1) / 2).next_multiple_of(2), some];
        let fits = |y: u32| y > 0 && widest(&TileShape { inner: [x, y], ..like }, 1) <= high;
        let y = all.into_iter().find(|y| fits(*y))?;
        let parts = (sides[1] + like.lacks[1]).div_ceil(y);
        shape.inner[1] = (sides[1] + like.lacks[1]).div_ceil(parts).next_multiple_of(2);
        shape.room[1] = widest(&shape, 1);
        Some(shape)
    });
    shapes.min_by_key(|s| (loads(s, grids), s.room[0].abs_diff(s.room[1])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::TileSpan;
    use crate::passes::{Air, Kinds, Soft};
    use crate::tuning::Tuning;

    const COLOURS: [(u32, u32); 8] = [(2, 0), (2, 1), (3, 0), (3, 1), (0, 0), (0, 1), (1, 0), (1, 1)];

    #[test]
    fn tiles_fit_the_memory_and_cover_the_grid() {
        for (width, height) in [(2, 2), (2, 1000), (70, 70), (129, 65), (512, 512), (3, 17)] {
            for (places, n) in [(1024, 5), (992, 7), (2304, 5), (1024, 0)] {
                let like = TileShape { around: [n; 2], lacks: [n & 1; 2], ..TileShape::default() };
                let grids = [[width, height]];
                let shape = best(like, &grids, places).unwrap();
                assert!(shape.room[0] * shape.room[1] <= places, "{shape:?}");
                assert!(shape.inner.iter().all(|s| s % 2 == 0 && *s > 0), "{shape:?}");
                for (d, side) in [width, height].into_iter().enumerate() {
                    assert!(shape.extents(side, d).all(|e| e <= shape.room[d]), "{shape:?}");
                }
            }
        }
        // A grid that fits is one tile.
        let like = TileShape { around: [5; 2], lacks: [1; 2], ..TileShape::default() };
        assert_eq!(count(&best(like, &[[2, 500]], 1024).unwrap(), &[[2, 500]]), 1);
    }

    #[test]
    fn tiles_are_as_large_as_pays() {
        let room = Room {
            memory: 49_152,
            threads: 256,
            buffers: 8,
            loops: u32::MAX,
            busy: 256,
            bytes: 1 << 27,
            whole: u32::MAX,
            cloths: 1,
            tuning: Tuning::NONE,
        };
        let passes = [Pass::Integrate(Air::None)].into_iter().chain(COLOURS.map(|(direction, parity)| Pass::Stretch {
            direction,
            parity,
            image: false,
            soft: Soft::None,
            again: false,
        }));
        let contact = Pass::Contact(Kinds { many: true, ..Kinds::default() });
        let passes: Vec<_> = passes.chain([contact]).collect();
        // Bytes of a particle in a step of a part, a whole step, and a step that begins the next, and places.
        let of = |n: u32, room: &Room| {
            let (tile, grids) = (Tile::of(&passes, true).unwrap(), [[n, n]]);
            let tile = tile.fit(&grids, room).unwrap();
            let spans = [TileSpan::Part, TileSpan::Step, TileSpan::Ahead];
            let bytes = spans.map(|span| Tile { span, ..tile.clone() }.traffic(&grids));
            (bytes, tile.shape.room[0] * tile.shape.room[1])
        };
        let (few, many) = (of(256, &room), of(1024, &room));
        eprintln!("{few:?} {many:?}");
        assert!(few.0[0] < 103.0 && few.0[1] < 90.0 && few.0[2] < 75.5 && few.1 <= USUAL, "{few:?}");
        assert!(many.0[0] < 87.0 && many.0[1] < 76.0 && many.0[2] < 67.0 && many.1 > USUAL, "{many:?}");
        // The memory also holds notes of the colliders that are near.
        let least = of(256, &Room { memory: 16_384, ..room });
        assert!(least.1 * BYTES + NOTES <= 16_384, "{least:?}");
        assert_eq!(Tile::of(&passes, true).unwrap().fit(&[[64, 64]], &Room { memory: 1024, ..room }), None);
        // The target for cloth that hangs by two tethers per particle is 90 bytes.
        let tethers = Pass::Tethers { slots: 2 };
        let springs = passes[1..passes.len() - 1].iter().copied();
        let hung: Vec<_> = [passes[0], tethers].into_iter().chain(springs).chain([tethers]).collect();
        let tile =
            Tile::of(&hung, true).unwrap().fit(&[[256, 256]], &Room { memory: 16_384, ..room }).unwrap().of_steps();
        assert!(tile.span == TileSpan::Ahead && tile.traffic(&[[256, 256]]) < 90.0, "{}", tile.traffic(&[[256, 256]]));
    }

    /// Two steps per dispatch would read and write less only where a tile is large, and relax much more than once what it owns.
    #[test]
    fn two_steps_in_a_tile_relax_more_than_they_save() {
        // Bytes per particle and step of cloth without tethers, and particles that are relaxed for each.
        let of = |n: u32, places: u32, steps: usize| {
            let (around, lacks) = around(&COLOURS.repeat(steps));
            let grids = [[n, n]];
            let shape = best(TileShape { around, lacks, ..TileShape::default() }, &grids, places).unwrap();
            let loads = loads(&shape, &grids) as f64 / f64::from(n * n);
            ((32.0 * loads + 32.0) / steps as f64, loads)
        };
        for (n, places) in [(256, 1024), (256, 2048), (256, LARGE), (1024, 1024), (1024, LARGE)] {
            let (one, two) = (of(n, places, 1), of(n, places, 2));
            eprintln!("{n} x {n} in tiles of {places}: {one:?}, two steps {two:?}");
            assert!(two.1 > 1.7 * one.1, "{n} {places}: {one:?} {two:?}");
            assert!(two.0 > 0.7 * one.0, "{n} {places}: {one:?} {two:?}");
        }
        // On every device.
        assert!(of(256, USUAL, 2).0 > of(256, USUAL, 1).0);
    }
}
