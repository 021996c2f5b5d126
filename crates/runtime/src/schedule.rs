//! The step of a cloth as data: which passes run, in what order, and why. All forms of a frame are made from it.

use crate::cloth::{Cloth, Compliance, Grid, Rest};
use crate::options::{Options, Solver};
use crate::passes::{Air, Kinds, Pass, Soft};
use crate::wind::{Wind, WindForce};

/// The passes of a cloth, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Schedule {
    /// Once a step.
    pub step: Vec<Pass>,
    /// After these, once in [`Options::pyramid`] steps.
    pub coarse: Vec<Pass>,
    /// After these, `iterations` times a step.
    pub relax: Vec<Pass>,
    /// Once a frame in which a step was made.
    pub frame: Vec<Pass>,
}

/// The frame of a cloth among colliders in wind: only passes that have something to do.
///
/// `slots` are the tethers of a particle.
pub fn schedule(
    (cloth, slots): (&Cloth, u32),
    colliders: Option<Kinds>,
    wind: Option<&Wind>,
    options: &Options,
) -> Schedule {
    let air = match wind.map(|w| w.force) {
        None => Air::None,
        Some(WindForce::Push { .. }) => Air::Push,
        Some(WindForce::Triangles { .. }) => Air::Field,
    };
    let mut s = Schedule::default();
    // Reads neighbours, so it cannot be part of the step that moves them.
    s.step.extend((air == Air::Field).then_some(Pass::Wind { holes: cloth.is_cut() }));
    let exact = cloth.is_exact() && options.solver == Solver::Xpbd;
    s.step.push(if exact { Pass::Advance(air) } else { Pass::Integrate(air) });
    let seams = cloth.ring_count() > 0;
    // Colliders are last, so that a frame ends outside of them. Duplicates are equal there and stay so.
    match options.solver {
        Solver::Classic => {
            s.relax.extend(springs(cloth));
            s.relax.extend(seams.then_some(Pass::Seams));
            s.relax.extend(colliders.map(|kinds| Pass::Colliders(Kinds { many: false, ..kinds })));
        }
        Solver::Xpbd => {
            // Once a step, however often springs are relaxed: it is far softer than they are.
            if cloth.bending().is_some() {
                s.step.push(Pass::Moments { holes: cloth.is_cut() });
                s.step.extend(seams.then_some(Pass::SeamMoments));
                s.step.push(Pass::Bend);
                s.step.extend(seams.then_some(Pass::Seams));
            }
            if cloth.membrane().is_some() {
                s.step.extend(membrane(cloth));
            }
            // Before the springs tethers take the large errors, after them what springs have left at the pins.
            let tethers = (slots > 0).then_some(Pass::Tethers { slots });
            s.relax.extend(tethers);
            s.coarse = coarse(cloth, options);
            if cloth.membrane().is_none() {
                let again = options.iterations * (options.polish + 1) > 1 && soft_of(cloth) != Soft::None;
                s.step.extend(again.then_some(Pass::Forget));
                s.relax.extend(stretch(cloth, again));
                for _ in 0..options.polish {
                    s.relax.extend(seams.then_some(Pass::Seams));
                    s.relax.extend(tethers);
                    s.relax.extend(stretch(cloth, again).filter(Pass::is_structural));
                }
            }
            s.relax.extend(seams.then_some(Pass::Seams));
            // A further round has had them already, and ends with springs.
            let last = options.polish == 0 || cloth.membrane().is_some();
            s.relax.extend(tethers.filter(|_| last));
            s.relax.extend(colliders.map(Pass::Contact));
            s.frame.extend([Pass::Guard, Pass::Restore]);
        }
    }
    let springs = cloth.directions()[..2].contains(&true);
    let soft = match (options.solver, cloth.membrane()) {
        (Solver::Classic, _) => Soft::None,
        (Solver::Xpbd, Some(_)) => Soft::Constant,
        (Solver::Xpbd, None) => soft_of(cloth),
    };
    let strain = Pass::Strain { image: matches!(cloth.rest(), Rest::Image(_)), soft };
    s.frame.extend((springs && options.quality.target().is_some()).then_some(strain));
    if options.normals {
        s.frame.push(Pass::Normals { holes: cloth.is_cut() });
        s.frame.extend(seams.then_some(Pass::SeamNormals));
    }
    s
}

/// The passes on coarser grids, of cloth that has any.
fn coarse(cloth: &Cloth, options: &Options) -> Vec<Pass> {
    if !has_levels(cloth, options) {
        return Vec::new();
    }
    let (seams, cut) = (cloth.ring_count() > 0, cloth.is_cut());
    let pyramid = Pass::Pyramid { directions: cloth.directions(), seams, cut };
    [pyramid, Pass::Refine { seams, cut }].into_iter().chain(seams.then_some(Pass::SeamSteps)).collect()
}

/// Whether lengths are limited on coarser grids.
pub(crate) fn has_levels(cloth: &Cloth, options: &Options) -> bool {
    let large = cloth.grids().iter().any(|g| g.width.max(g.height) > 2);
    options.solver == Solver::Xpbd && options.pyramid > 0 && large && cloth.directions()[..2].contains(&true)
}

/// Four passes, or fewer on a grid of two rows or columns.
fn membrane(cloth: &Cloth) -> impl Iterator<Item = Pass> {
    let most = |side: fn(&Grid) -> u32| cloth.grids().iter().map(side).max().unwrap_or(0);
    let (width, height, holes) = (most(|g| g.width), most(|g| g.height), cloth.is_cut());
    let colours = [(0, 0), (1, 0), (0, 1), (1, 1)];
    let there = colours.into_iter().filter(move |(column, row)| column + 1 < width && row + 1 < height);
    there.map(move |(column, row)| Pass::Membrane { column, row, holes })
}

/// Where the compliance of a cloth's springs comes from; none that is 0 everywhere.
pub(crate) fn soft_of(cloth: &Cloth) -> Soft {
    match cloth.compliance {
        Compliance::None => Soft::None,
        Compliance::Constant(soft) if soft <= 0.0 => Soft::None,
        Compliance::Constant(_) => Soft::Constant,
        Compliance::Image(_) => Soft::Image,
    }
}

/// As [`springs`], structural ones last: what the others disturb, they put right.
fn stretch(cloth: &Cloth, again: bool) -> impl Iterator<Item = Pass> {
    let soft = soft_of(cloth);
    let all: Vec<_> = springs(cloth).collect();
    let of = move |first: u32| {
        all.clone().into_iter().filter_map(move |pass| match pass {
            Pass::Springs { direction, parity, image } if direction / 2 == first => {
                Some(Pass::Stretch { direction, parity, image, soft, again })
            }
            _ => None,
        })
    };
    of(1).chain(of(0))
}

/// Up to eight passes: directions without springs and parities without room are left out.
fn springs(cloth: &Cloth) -> impl Iterator<Item = Pass> {
    let image = matches!(cloth.rest(), Rest::Image(_));
    let directions = cloth.directions();
    let side = |d: u32| cloth.grids().iter().map(|g| if d == 0 { g.width } else { g.height }).max().unwrap_or(0);
    let room = [0, 1, 2, 3].map(side);
    (0..8).map(|k| (k / 2, k % 2)).filter_map(move |(direction, parity)| {
        let d = direction as usize;
        (directions[d] && room[d] > parity + 1).then_some(Pass::Springs { direction, parity, image })
    })
}

/// A part of a list of passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Run<'a> {
    /// A pass.
    Once(&'a Pass),
    /// The same passes several times in a row.
    Times(u32, &'a [Pass]),
}

/// Longest part that is looked for as a repetition.
const LONGEST: usize = 16;

/// A list with what repeats in a row written once, so that a shader has it as a loop: rounds of polish, above all.
pub fn fold(passes: &[Pass]) -> Vec<Run<'_>> {
    let (mut runs, mut at) = (Vec::new(), 0);
    while at < passes.len() {
        let left = &passes[at..];
        let times = |n: usize| left.chunks_exact(n).take_while(|chunk| *chunk == &left[..n]).count();
        let saves = |n: &usize| (times(*n) - 1) * n;
        // Of the parts that save most the shortest.
        match (1..=LONGEST.min(left.len())).rev().max_by_key(saves).filter(|n| times(*n) > 1) {
            Some(n) => {
                runs.push(Run::Times(times(n) as u32, &left[..n]));
                at += n * times(n);
            }
            None => {
                runs.push(Run::Once(&left[0]));
                at += 1;
            }
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_are_written_once() {
        let (a, b, c) = (Pass::Seams, Pass::Bend, Pass::Guard);
        let whole = [a, b, b, c, a, c, a, c, a, b];
        let runs = fold(&whole);
        let expected = [Run::Once(&a), Run::Times(2, &[b]), Run::Times(3, &[c, a]), Run::Once(&b)];
        assert_eq!(runs, expected);
        let flat = |run: &Run| match *run {
            Run::Once(pass) => vec![*pass],
            Run::Times(n, part) => part.repeat(n as usize),
        };
        assert_eq!(runs.iter().flat_map(flat).collect::<Vec<_>>(), whole);
        assert_eq!(fold(&[]), []);
    }
}
