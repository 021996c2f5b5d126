//! Twin of shaders/stitch.wgsl: the pull of each stitch.

use std::sync::Arc;

use super::seam_steps::Member;
use crate::cloth::{Cloth, ENDS, NO_STITCH};
use crate::cpu::sheet::Sheet;
use crate::number::real::{Real, V3, dot, scale, sub};

/// A stitch between particles of sheets.
#[derive(Clone, Copy, Debug)]
pub struct Thread<T> {
    /// The corners of its quad, then its particle.
    pub ends: [Member; ENDS],
    /// The shares of the corners in the point.
    pub shares: [T; 4],
    /// How many stitches move each end.
    pub counts: [T; ENDS],
    /// Its length \[m\].
    pub distance: T,
    /// The first corner as a particle of the cloth, for cuts.
    pub cell: u32,
}

/// The stitches of a cloth.
pub struct Stitches<T> {
    pub threads: Arc<Vec<Thread<T>>>,
    /// Per moved point its duplicates.
    pub moved: Arc<Vec<Vec<Member>>>,
    /// Per moved point the ends that move it, as stitch and number of the end.
    pub entries: Arc<Vec<Vec<(u32, u32)>>>,
    /// The pull of each stitch; 0 where a cut has taken its quad away.
    pub pulls: Vec<V3<T>>,
    /// Whether a stitch is left.
    pub holds: Vec<bool>,
}

/// The stitches of a cloth whose particles lie where `member` says; `None` without any.
pub fn stitches<T: Real>(cloth: &Cloth, member: impl Fn(u32) -> Member) -> Option<Stitches<T>> {
    let sewing = cloth.sewing()?;
    let thread = |t: &crate::cloth::Thread| {
        let [s, u] = t.inner;
        // As the shader has them, in 32 bits.
        let shares = [(1.0 - s) * (1.0 - u), s * (1.0 - u), (1.0 - s) * u, s * u];
        Thread {
            ends: t.ends.map(&member),
            shares: shares.map(|x| T::of(x.into())),
            counts: t.counts.map(|n| T::of(n.into())),
            distance: T::of(t.distance.into()),
            cell: t.ends[0],
        }
    };
    let threads: Vec<_> = sewing.threads.iter().map(thread).collect();
    let mut moved = vec![Vec::new(); sewing.starts.len() - 1];
    for (k, point) in sewing.moved.iter().enumerate().filter(|(_, point)| **point != NO_STITCH) {
        moved[*point as usize].push(member(k as u32));
    }
    let of = |r: &[u32]| sewing.entries[r[0] as usize..r[1] as usize].iter().map(|e| (e.stitch, e.end)).collect();
    let count = threads.len();
    Some(Stitches {
        threads: Arc::new(threads),
        moved: Arc::new(moved),
        entries: Arc::new(sewing.starts.windows(2).map(of).collect()),
        pulls: vec![[T::of(0.0); 3]; count],
        holds: vec![true; count],
    })
}

/// The pull of each stitch: the way to its length, over the sum of the inverse masses that it moves, each counted as often as
/// stitches move it.
pub fn run<T: Real>(sheets: &[Sheet<T>], stitches: &mut Stitches<T>) {
    let zero = T::of(0.0);
    let at = |m: &Member| {
        let sheet = &sheets[m.sheet as usize];
        (sheet.at(m.at as usize), sheet.w[m.single as usize].max(zero))
    };
    for ((thread, pull), holds) in stitches.threads.iter().zip(&mut stitches.pulls).zip(&stitches.holds) {
        let (p, w) = at(&thread.ends[4]);
        let (mut point, mut weight) = ([zero; 3], thread.counts[4] * w);
        for (n, share) in thread.shares.iter().enumerate() {
            let (corner, w) = at(&thread.ends[n]);
            (0..3).for_each(|c| point[c] = point[c] + corner[c] * *share);
            weight = weight + thread.counts[n] * *share * *share * w;
        }
        let way = sub(p, point);
        let far = dot(way, way).sqrt();
        let by = (far - thread.distance) / (far.max(T::of(1e-30)) * weight.max(T::of(1e-30)));
        *pull = if *holds && weight > zero { scale(way, by) } else { [zero; 3] };
    }
}
