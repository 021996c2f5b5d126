//! Which passes of a cloth run, in what order, and why.

use super::{Air, Kinds, Pass, Soft};
use crate::choose::Settings;
use crate::cloth::{Cloth, Compliance, Grid, Rest};
use crate::options::{Options, Solver};
use crate::wind::{Wind, WindForce};

/// Steps for which partners in contact are searched, at most.
pub const SEARCH_STEPS: u32 = 8;
/// Steps after which cloths search for particles of others that they may meet.
pub const MEETING_STEPS: u32 = 4;
/// Steps after which cloths take in where particles of others are that they have found.
pub const FOLLOW_STEPS: u32 = 2;

/// The passes of a cloth, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Schedule {
    /// Before all others, once in a frame in which a step is made.
    pub worn: Vec<Pass>,
    /// Before all others, once in [`SEARCH_STEPS`] steps.
    pub near: Vec<Pass>,
    /// After these, in the first step of a frame.
    pub gusts: Vec<Pass>,
    /// After these, once in as many steps as forces of air stand for.
    pub air: Vec<Pass>,
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
    options: &Settings,
) -> Schedule {
    let air = match wind.map(|w| w.force) {
        None => Air::None,
        Some(WindForce::Push { .. }) => Air::Push,
        Some(WindForce::Triangles { .. }) => Air::Field,
    };
    let mut s = Schedule::default();
    if air == Air::Field {
        let gusts = wind.is_some_and(|w| w.gust > 0.0);
        s.gusts.extend(gusts.then_some(Pass::Gust));
        // Reads neighbours, so it cannot be part of the step that moves them.
        s.air.push(Pass::Wind { gusts, holes: cloth.is_cut() });
    }
    let exact = cloth.is_exact() && options.solver == Solver::Xpbd;
    // Before all others, so that tethers and springs find their ends where these are in this step.
    s.step.extend((cloth.follows_joints() && options.solver == Solver::Xpbd).then_some(Pass::Follow));
    s.step.push(if exact { Pass::IntegrateExact(air) } else { Pass::Integrate(air) });
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
            let alone = colliders.is_none() && cloth.body().is_none() && cloth.contact.is_none();
            // It ignores contact: it would pull cloth through what it lies on.
            s.coarse = if alone { coarse(cloth, options) } else { Vec::new() };
            if cloth.membrane().is_none() {
                let again = options.iterations * (options.polish + 1) > 1 && soft_of(cloth) != Soft::None;
                s.step.extend(again.then_some(Pass::Forget));
                s.relax.extend(stretch(cloth, again));
                for round in 1..=options.polish {
                    s.relax.extend(seams.then_some(Pass::Seams));
                    // Between further rounds they cost as much as a round, and change less. Where cloth is in contact, the
                    // last word before it stays with the springs.
                    s.relax.extend(tethers.filter(|_| round == 1 || !alone));
                    s.relax.extend(polish(cloth, again, round == options.polish));
                }
            }
            s.relax.extend(seams.then_some(Pass::Seams));
            let last = alone || options.polish == 0 || cloth.membrane().is_some();
            s.relax.extend(tethers.filter(|_| last));
            // Duplicates of a seam point are equal here, and stitches move them alike.
            if cloth.sewing().is_some() {
                s.relax.extend([Pass::Stitch { holes: cloth.is_cut() }, Pass::Sew]);
            }
            // Contact has the last word: a limit may lead into a collider.
            s.relax.extend(cloth.limits.is_some().then_some(Pass::Limit { moves: cloth.follows_joints() }));
            let backed = cloth.backstops.is_some();
            s.relax.extend(backed.then_some(Pass::Backstop { moves: cloth.follows_joints() }));
            if cloth.contact.is_some() {
                s.near = vec![Pass::Leaves, Pass::Tree, Pass::Partners { seams }];
                s.relax.extend([Pass::Touch { others: 0 }, Pass::Separate]);
                s.relax.extend(seams.then_some(Pass::Seams));
            }
            if cloth.body().is_some() {
                let pose = Pass::SurfacePose { sets: cloth.body_sets() as u32, skinning: cloth.skinning };
                s.worn = vec![pose, Pass::SurfaceBoxes, Pass::SurfaceSearch];
                s.relax.push(Pass::SurfaceContact);
            }
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
    if options.normals {
        s.frame.push(Pass::Normals { holes: cloth.is_cut() });
        s.frame.extend(seams.then_some(Pass::SeamNormals));
    }
    // Behind normals: in whole frames maxima are found in the memory that positions have lain in.
    s.frame.extend((springs && options.quality.target().is_some()).then_some(strain));
    s
}

/// The passes on coarser grids, of cloth that has any.
fn coarse(cloth: &Cloth, options: &Options) -> Vec<Pass> {
    if !has_levels(cloth, options) {
        return Vec::new();
    }
    let (seams, cut, directions) = (cloth.ring_count() > 0, cloth.is_cut(), cloth.directions());
    let finest = crate::levels::finest_of_one(cloth);
    let mut passes = vec![Pass::Pyramid { directions, seams, cut, finest }];
    for level in (1..finest).rev() {
        passes.push(Pass::CoarseLevel { level, directions, cut });
        passes.extend(seams.then_some(Pass::CoarseTies { level, cut }));
    }
    passes.push(Pass::Refine { seams, cut });
    passes.extend(seams.then_some(Pass::SeamSteps));
    passes
}

/// Whether lengths are limited on coarser grids.
pub(crate) fn has_levels(cloth: &Cloth, options: &Options) -> bool {
    let large = cloth.grids().iter().any(|g| g.width.max(g.height) > 2);
    let sees = cloth.levels_with_pins > 0;
    options.solver == Solver::Xpbd && options.pyramid > 0 && large && sees && cloth.directions()[..2].contains(&true)
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

/// As [`springs`], structural ones last: they correct the errors that the others leave.
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

/// A round of polish: the springs to the right and down, over-relaxed until the last round. Of springs with compliance all, as they
/// are: their multipliers come nearer to those of elastic cloth, which diagonals have a share in.
fn polish(cloth: &Cloth, again: bool, last: bool) -> impl Iterator<Item = Pass> {
    stretch(cloth, again).filter_map(move |pass| match pass {
        Pass::Stretch { direction, parity, image, soft: Soft::None, .. } if direction < 2 && !last => {
            Some(Pass::Polish { direction, parity, image })
        }
        Pass::Stretch { soft: Soft::None, direction: 2.., .. } => None,
        _ => Some(pass),
    })
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
