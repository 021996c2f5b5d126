//! Grows the cut into the places the map stretches most (Gu, Gortler, Hoppe 2002), on a coarse stand-in of the surface.

use crate::border::Border;
use crate::cut::Cutter;
use crate::decimate::decimate;
use crate::disk::{self, NONE};
use crate::layout::{Proxy, SearchOptions, Size, most_stretched};
use crate::surface::Surface;

/// How far to grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrowOptions {
    /// Triangles of the stand-in; more is more exact and slower.
    pub triangles: usize,
    /// Largest number of points the cut is grown to.
    pub points: usize,
    /// A point is kept if it lowers the energy by at least this share.
    pub gain: f64,
}

impl Default for GrowOptions {
    fn default() -> Self {
        Self { triangles: 2000, points: 24, gain: 0.01 }
    }
}

/// One try: the energy of a cut through `terminals`, and the vertices it stretches most.
struct Try {
    score: f64,
    next: Vec<u32>,
}

fn attempt(cutter: &Cutter<'_>, terminals: &[u32], search: SearchOptions) -> Option<Try> {
    let surface = cutter.surface;
    let cut = cutter.cut(&cutter.graph.length, terminals);
    let mut disk = disk::open(cutter, &cut).ok()?;
    let mut on_rim = vec![false; surface.positions.len()];
    cutter.loops().iter().flatten().for_each(|&v| on_rim[v as usize] = true);
    let border = Border::new(&mut disk, |v| on_rim[v as usize]);
    let mut proxy = Proxy::new(&disk, &border, search);
    let layout = proxy.search(Size::Budget(16_384))?;
    if !layout.score.is_finite() {
        return None;
    }
    let mut on_cut = vec![false; surface.positions.len()];
    disk.boundary.iter().for_each(|&v| on_cut[disk.origin[v as usize] as usize] = true);
    let mut next = Vec::new();
    // The plain mean-value map shrinks limbs without mercy and so finds their tips; the solved map finds the rest.
    for (passes, steps) in [(1, 0), (search.passes, search.steps)] {
        let Some((uv, _)) = proxy.map(layout.w, layout.h, layout.shift, passes, steps) else { continue };
        let (positions, triangles) = proxy.coarse();
        let origin = |v: u32| proxy_origin(&disk, &proxy, v);
        let pick = most_stretched(positions, triangles, &uv, |v| {
            let o = origin(v);
            o != NONE && !on_cut[o as usize]
        });
        if let Some(v) = pick.map(origin)
            && !next.contains(&v)
        {
            next.push(v);
        }
    }
    Some(Try { score: layout.score, next })
}

/// The surface vertex behind a vertex of the stand-in.
fn proxy_origin(disk: &disk::Disk, proxy: &Proxy<'_>, v: u32) -> u32 {
    proxy.original(v).map_or(NONE, |d| disk.origin[d as usize])
}

/// Points of `surface` that the cut should reach, in the order they were found, and the energy of the stand-in with and
/// without them.
pub(crate) fn grow(surface: &Surface, options: &GrowOptions) -> (Vec<u32>, f64, f64) {
    let search = SearchOptions { triangles: options.triangles, shifts: 4, passes: 4, steps: 5, refine: false };
    let none = (Vec::new(), f64::INFINITY, f64::INFINITY);
    let mut rim = vec![false; surface.positions.len()];
    let Some(fine) = Cutter::new(surface) else { return none };
    fine.loops().iter().flatten().for_each(|&v| rim[v as usize] = true);
    drop(fine);
    let locked = vec![false; rim.len()];
    let coarse = decimate(&surface.positions, &surface.triangles, &rim, &locked, options.triangles);
    let small = Surface {
        positions: coarse.vertex.iter().map(|&v| surface.positions[v as usize]).collect(),
        source_triangle: vec![0; coarse.triangles.len()],
        triangles: coarse.triangles,
    };
    let Some(cutter) = Cutter::new(&small) else { return none };
    let mut terminals: Vec<u32> = Vec::new();
    let mut now = attempt(&cutter, &terminals, search);
    let before = now.as_ref().map_or(f64::INFINITY, |t| t.score);
    while terminals.len() < options.points {
        let score = now.as_ref().map_or(f64::INFINITY, |t| t.score);
        let candidates = now.as_ref().map_or_else(Vec::new, |t| t.next.clone());
        let mut best: Option<(Try, u32)> = None;
        for v in candidates {
            let mut longer = terminals.clone();
            longer.push(v);
            if let Some(t) = attempt(&cutter, &longer, search)
                && t.score < score * (1.0 - options.gain)
                && best.as_ref().is_none_or(|b| t.score < b.0.score)
            {
                best = Some((t, v));
            }
        }
        let Some((t, v)) = best else { break };
        terminals.push(v);
        now = Some(t);
    }
    let after = now.map_or(f64::INFINITY, |t| t.score);
    (terminals.iter().map(|&v| coarse.vertex[v as usize]).collect(), before, after)
}
