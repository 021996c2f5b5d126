//! Which passes of a step run together on cloths that are too large for one workgroup: by tiles, each of which a workgroup
//! has in its memory with enough around it that nothing is left to wait for.
//!
//! Every colour of springs reaches a particle farther, or none, so what a tile owns is right after all eight if it has five
//! columns and rows more on every side, which it relaxes too and then drops. Results are those of separate passes, bit for
//! bit, whatever the size of the tiles. Tiles without anything around them, whose origin alternates so that springs across
//! their borders are left to the next origin, would load less, but relax in another order, and one that depends on their size.
//!
//! Bytes that a particle moves in a step of constant rest lengths, without tethers: in separate passes 64 for the
//! integration, 32 for each of eight colours and 48 for contact, 368. A tile reads positions now and before, 32 bytes for all that it
//! has, and writes 32 for what it owns: 102 on 256 x 256 particles in 16 KiB, 86 on 1,024 x 1,024 in 36 KiB. Bytes beyond 64 are
//! read by neighbours as well, and come out of a cache. Tethers read 8 bytes for each of a particle.
//!
//! Where a tile makes whole steps, it moves less. No other pass reads previous positions between the steps of a frame then, so these take 12
//! bytes: 89 and 75. If no seams end a step in the next tile, the tile of a step also begins the next one, for what it owns: it reads
//! previous positions, and tethers before the springs, for what it owns alone: 75 and 67.

mod order;
mod reach;
mod shape;
mod traffic;

pub use order::{Among, Order, Sequence, order, sequence};

use crate::form::{Chain, Tile, TileShape, TileSpan};
use crate::passes::Pass;
use crate::shaders::{Over, Stages, over, stages, tail};

impl Tile {
    /// The tile that makes just these passes, but for sizes; `None` if no tile can.
    fn of(passes: &[Pass], shared: bool) -> Option<Self> {
        let tile =
            Tile { passes: passes.to_vec(), shape: TileShape::default(), threads: 0, shared, span: TileSpan::Part };
        let Stages { tail, arrive, middle, leave } = stages(passes);
        let moves = |p: &Pass| matches!(p, Pass::Integrate(_) | Pass::IntegrateExact(_));
        let within = |p: &Pass| matches!(over(*p), Over::Particles | Over::Springs { .. }) && !moves(p);
        let alone = |p: &Pass| matches!(over(*p), Over::Particles);
        // They read what other particles have come to.
        let ends = |p: &Pass| matches!(p, Pass::Guard | Pass::Restore);
        // Sums are a matter of springs.
        let forgets = tile.forgets();
        let sums = passes.iter().any(|p| matches!(p, Pass::Stretch { again: true, .. }));
        let good = !passes.iter().any(ends)
            && arrive.iter().skip(1).all(|p| alone(p) && !moves(p))
            && arrive.first().is_none_or(alone)
            && middle.iter().all(|p| within(p) && *p != Pass::Forget)
            && leave.iter().all(|p| matches!(over(*p), Over::Particles | Over::Near) && !moves(p))
            && leave.iter().rev().skip(1).all(|p| !matches!(p, Pass::Contact(_)))
            && (sums || !forgets)
            && (tail.is_empty()
                || shared && Chain::follows(tail) && !leave.iter().any(|p| matches!(p, Pass::Contact(_))));
        good.then_some(tile)
    }

    /// The same tile where its passes are whole steps, one dispatch each.
    fn of_steps(self) -> Self {
        let Stages { tail, arrive, .. } = stages(&self.passes);
        // Seams end a step in the next tile, and an exact step keeps two numbers of each particle, which would change twice in a dispatch.
        let ahead = tail.is_empty() && matches!(arrive.first(), Some(Pass::Integrate(_)));
        Tile { span: if ahead { TileSpan::Ahead } else { TileSpan::Step }, ..self }
    }

    /// Directions and parities of its springs, in order.
    fn colours(&self) -> impl Iterator<Item = (u32, u32)> {
        self.passes.iter().filter_map(|p| match over(*p) {
            Over::Springs { direction, parity } => Some((direction, parity)),
            _ => None,
        })
    }
}

impl Chain {
    /// The chain that makes just these passes; `None` if no chain can.
    fn of(passes: &[Pass]) -> Option<Self> {
        let rest = &passes[tail(passes)..];
        let alone = |p: &Pass| over(*p) == Over::Particles && !matches!(p, Pass::Restore | Pass::Contact(_));
        let good = Chain::follows(&passes[..tail(passes)]) && rest.iter().all(alone);
        good.then(|| Chain { passes: passes.to_vec() })
    }

    /// Whether passes are seams and what can follow them in the same dispatch: rules of particles, contact as the last of them.
    fn follows(tail: &[Pass]) -> bool {
        let contact = |p: &Pass| matches!(p, Pass::Contact(_));
        let alone = |p: &Pass| matches!(over(*p), Over::Particles | Over::Near) && *p != Pass::Restore;
        let last = tail.iter().position(contact).is_none_or(|n| n + 1 == tail.len());
        tail.first() == Some(&Pass::Seams) && tail[1..].iter().all(alone) && last
    }
}
