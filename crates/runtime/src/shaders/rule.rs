//! The work of each pass, for all forms in which it can run: its rule, the elements it is run for, and its bindings.

use super::parts::{Parts, reads, writes};
use super::{Slot, Threads, rare};
use crate::passes::{Air, Kinds, Pass, Soft};

/// Elements that a rule is run for, one call each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// Particles, each by itself: `fn(k)`.
    Particles,
    /// The same, once the colliders near them are known.
    Near,
    /// Seam rings: `fn(ring)`.
    Rings,
    /// Texels: `fn(grid, cell, k)`. They read their neighbours.
    Texels,
    /// Springs of a colour: `fn(grid, ends, direction)`.
    Springs { direction: u32, parity: u32 },
    /// Cells in every other column and row: `fn(grid, i, j)`.
    Cells { column: u32, row: u32 },
    /// Particles, each by itself, with their places: `fn(grid, cell, k)`.
    Placed,
    /// Workgroups, each for a part of a cloth: `fn(grids, tile, levels, thread)`.
    Groups(Threads),
    /// The file of the pass has a loop of its own.
    Own(Threads),
}

/// How a pass is part of a whole frame.
#[derive(Clone, Debug)]
pub enum Whole {
    /// By the loop over what its rule is run for.
    Loop,
    /// Not at all: its cloths run in separate passes.
    No,
    /// Another pass has done it.
    Done,
    /// By a function of its own, `NAME_all`.
    Call(&'static str, Parts),
}

/// A pass as all its forms share it.
#[derive(Clone, Debug)]
pub struct Rule {
    /// Stem of its file in `shaders`, and of its twin.
    pub stem: &'static str,
    /// The file.
    pub text: &'static str,
    /// The function in it that is called.
    pub call: &'static str,
    /// The elements it is run for.
    pub over: Over,
    /// How it is part of a whole frame.
    pub whole: Whole,
    /// Other files of the rule, without those that declare what it binds, and what it binds.
    pub parts: Parts,
}

macro_rules! rule {
    ($stem:literal, $call:literal, $over:expr, $parts:expr) => {
        Rule { stem: $stem, text: pass!($stem), call: $call, over: $over, whole: Whole::Loop, parts: $parts }
    };
}

/// Elements that the rule of a pass is run for.
pub fn over(pass: Pass) -> Over {
    match pass {
        Pass::Gust | Pass::Integrate(_) | Pass::IntegrateExact(_) => Over::Particles,
        Pass::Forget | Pass::Tethers { .. } => Over::Particles,
        Pass::Limit { .. } | Pass::Backstop { .. } | Pass::SurfaceContact => Over::Particles,
        Pass::Guard | Pass::Restore | Pass::Colliders(_) => Over::Particles,
        Pass::Contact(kinds) => {
            if kinds.many {
                Over::Near
            } else {
                Over::Particles
            }
        }
        Pass::Seams | Pass::SeamSteps | Pass::SeamMoments | Pass::SeamNormals => Over::Rings,
        Pass::Wind { .. } | Pass::Moments { .. } | Pass::Bend | Pass::Normals { .. } => Over::Texels,
        Pass::Refine { .. } => Over::Placed,
        // Particles of other tiles read their anchors where these are now, so a tile ends before it.
        Pass::Follow | Pass::Stitch { .. } | Pass::Sew => Over::Texels,
        Pass::Membrane { column, row, .. } => Over::Cells { column, row },
        Pass::Springs { direction, parity, .. }
        | Pass::Stretch { direction, parity, .. }
        | Pass::Polish { direction, parity, .. } => Over::Springs { direction, parity },
        Pass::Speed
        | Pass::Transform
        | Pass::Place
        | Pass::Inertia
        | Pass::Skin { .. }
        | Pass::Prolong
        | Pass::Bounds
        | Pass::Wrap { .. }
        | Pass::Jump
        | Pass::WrapIndices
        | Pass::Blend { .. } => Over::Own(Threads::Particles),
        Pass::Fastest | Pass::PickNearest | Pass::Restrict => Over::Own(Threads::One),
        Pass::Pyramid { seams, .. } => Over::Groups(if seams { Threads::Layers } else { Threads::Grids }),
        Pass::CoarseLevel { level, .. } => Over::Groups(Threads::Nodes(level)),
        Pass::CoarseTies { .. } => Over::Groups(Threads::Layers),
        Pass::CutLevels => Over::Own(Threads::Grids),
        Pass::CutTethers { walks: true, .. } => Over::Own(Threads::One),
        Pass::Strain { .. } | Pass::Cut | Pass::CutSprings | Pass::CutTethers { .. } => Over::Own(Threads::Texels),
        Pass::Pick { .. } => Over::Own(Threads::Texels),
        Pass::Indices { .. } | Pass::Tangents { .. } => Over::Texels,
        Pass::Leaves => Over::Own(Threads::Texels),
        Pass::Tree => Over::Own(Threads::Cloth),
        Pass::Partners { .. } | Pass::Touch { .. } | Pass::Separate => Over::Own(Threads::Particles),
        Pass::Shadow | Pass::Extents | Pass::Others => Over::Own(Threads::Particles),
        Pass::Gather { .. } | Pass::HoldBack { .. } => Over::Own(Threads::Particles),
        Pass::Paths | Pass::Truncate => Over::Own(Threads::Particles),
        Pass::Faces { .. } => Over::Own(Threads::Texels),
        Pass::SurfacePose { .. } => Over::Own(Threads::Vertices),
        Pass::SurfaceBoxes => Over::Own(Threads::Patches),
        Pass::SurfaceSearch => Over::Own(Threads::Particles),
    }
}

/// The rule of a pass.
pub fn rule(pass: Pass) -> Rule {
    use Slot::{Before, Field, Grids, Members, Now, Starts, Step, Sums};
    let over = over(pass);
    let parts = |files: &[&'static str], reads: &[Slot], writes: &[Slot]| Parts::new(files, reads, writes);
    match pass {
        Pass::Integrate(air) => rule!("integrate", "integrate", over, integrate(air, false)),
        Pass::IntegrateExact(air) => rule!("integrate", "integrate", over, integrate(air, true)),
        Pass::Forget => rule!("forget", "forget", over, parts(&[], &[], &[Now, Sums])),
        Pass::Tethers { slots } => {
            let parts = parts(&[], &[Slot::Tethers], &[Now]).constant("slots", slots);
            rule!("tethers", "tether", over, parts)
        }
        Pass::Limit { moves } => rule!("limit", "limit", over, aim(moves).bind(&[writes(Now)])),
        Pass::Backstop { moves } => rule!("backstop", "backstop", over, back(moves).bind(&[writes(Now)])),
        Pass::SurfaceContact => {
            let parts = parts(&[], &[Step, Before, Slot::SurfacePlanes], &[Now]);
            rule!("surface_contact", "leave_surface", over, parts)
        }
        Pass::Stitch { holes } => {
            let parts = parts(&[part!("stitched")], &[Grids, Now, Slot::Stitches], &[Slot::Pulls]);
            rule!("stitch", "stitch", over, open(holes, parts))
        }
        Pass::Sew => {
            let parts = parts(&[part!("stitched")], &[Grids, Slot::Stitches], &[Now, Slot::Pulls]);
            rule!("sew", "sew", over, parts)
        }
        Pass::Follow => rule!("follow", "follow", over, aim(true).bind(&[reads(Grids), writes(Now), writes(Before)])),
        Pass::Contact(kinds) => contact(over, kinds),
        Pass::Colliders(kinds) => colliders(over, kinds),
        Pass::Seams => {
            let files = [part!("meeting"), part!("loose")];
            rule!("seams", "close", over, parts(&files, &[Starts, Members], &[Now]))
        }
        Pass::SeamSteps => {
            rule!("seam_steps", "close_steps", over, parts(&[], &[Starts, Members], &[Now, Before]))
        }
        Pass::SeamMoments => {
            rule!("seam_moments", "join_moments", over, parts(&[], &[Starts, Members], &[Slot::Moments]))
        }
        Pass::SeamNormals => {
            let parts = parts(&[part!("unit")], &[Starts, Members], &[Slot::Normals]);
            rule!("seam_normals", "join_normals", over, parts)
        }
        Pass::Gust => rule!("gust", "gust", over, parts(&[part!("gust")], &[Step, Now], &[Slot::Airs])),
        Pass::Wind { gusts, holes } => {
            let parts = parts(&[part!("neighbours")], &[Step, Grids, Now, Before], &[Field]);
            rule!("wind", "blow", over, open(holes, parts.and(air_at(gusts))))
        }
        Pass::Moments { holes } => moments(over, holes),
        Pass::Bend => {
            let parts = parts(&[part!("laplacian")], &[Grids, Slot::Weights], &[Now, Slot::Moments]);
            rule!("bend", "bend", over, parts)
        }
        Pass::Normals { holes } => {
            let parts = parts(&[part!("neighbours"), part!("unit")], &[Grids, Now], &[Slot::Normals]);
            rule!("normals", "normal", over, open(holes, parts))
        }
        Pass::Refine { seams, cut } => {
            let parts = parts(&[part!("level")], &[Slot::Levels, Slot::Nodes, Grids], &[Now, Before]);
            let parts = parted(cut, parts).number("carried", crate::levels::carried(seams));
            Rule { whole: if cut { Whole::No } else { Whole::Loop }, ..rule!("refine", "refine", over, parts) }
        }
        Pass::Membrane { holes, .. } => {
            let parts = parts(&[], &[Step, Grids, Slot::Cells, Slot::Yielding], &[Now]);
            rule!("membrane", "relax_cell", over, open(holes, parts))
        }
        Pass::Springs { image, .. } => {
            let parts = parts(&[part!("ends")], &[Grids], &[Now]).and(rest(image));
            rule!("springs", "relax_hard", over, parts)
        }
        Pass::Stretch { image, soft, again, .. } => stretch(over, image, soft, again),
        Pass::Polish { image, .. } => rule!("polish", "polish", over, pull(image)),
        Pass::Guard => rule!("guard", "guard", over, parts(&[part!("sane")], &[Now], &[Slot::Faults])),
        Pass::Restore => {
            let parts = parts(&[], &[], &[Now, Before, Slot::Faults, Slot::Good]);
            rule!("restore", "restore", over, parts)
        }
        Pass::Speed => {
            let parts = parts(&[part!("larger"), part!("most")], &[Now, Before], &[Slot::Partial]);
            let whole = Whole::Call("speed", Parts::new(&[part!("larger"), part!("whole_speed")], &[], &[]));
            Rule { whole, ..rule!("speed", "", over, parts) }
        }
        Pass::Fastest => {
            let parts = parts(&[part!("larger"), part!("most")], &[Slot::Partial], &[Slot::Fastest]);
            Rule { whole: Whole::Done, ..rule!("fastest", "", over, parts) }
        }
        Pass::Strain { image, soft } => strain(over, image, soft),
        Pass::Pyramid { directions, seams, cut, finest } => rare::pyramid(over, directions, (seams, cut), finest),
        Pass::CoarseLevel { level, directions, cut } => rare::coarse_level(over, level, directions, cut),
        Pass::CoarseTies { level, cut } => rare::coarse_ties(over, level, cut),
        Pass::Cut => rare::cut(over),
        Pass::CutSprings => rare::cut_springs(over),
        Pass::CutTethers { slots, seams, sewn, walks } => rare::cut_tethers(over, slots, [seams, sewn], walks),
        Pass::CutLevels => rare::cut_levels(over),
        Pass::Transform => rare::transform(over),
        Pass::Place => rare::place(over),
        Pass::Inertia => rare::inertia(over),
        Pass::Skin { sets, skinning } => rare::skin(over, sets, skinning),
        Pass::Restrict => rare::restrict(over),
        Pass::Prolong => rare::prolong(over),
        Pass::Pick { holes } => rare::pick(over, holes),
        Pass::PickNearest => rare::pick_nearest(over),
        Pass::Bounds => rare::bounds(over),
        Pass::Wrap { jumps } => rare::wrap(over, jumps),
        Pass::Jump => rare::jump(over),
        Pass::WrapIndices => rare::wrap_indices(over),
        Pass::Blend { sets, skinning } => rare::blend(over, sets, skinning),
        Pass::Indices { holes } => rare::indices(over, holes),
        Pass::Tangents { holes } => rare::tangents(over, holes),
        Pass::Leaves => rare::leaves(over),
        Pass::Tree => rare::tree(over),
        Pass::Partners { seams } => rare::partners(over, seams),
        Pass::Touch { others } => rare::touch(over, others),
        Pass::Separate => rare::separate(over),
        Pass::Shadow => rare::shadow(over),
        Pass::Extents => rare::extents(over),
        Pass::Others => rare::others(over),
        Pass::Faces { holes } => rare::faces(over, holes),
        Pass::Gather { begins, put, sleeps } => rare::gather(over, [begins, put, sleeps]),
        Pass::Paths => rare::paths(over),
        Pass::Truncate => rare::truncate(over),
        Pass::HoldBack { exact } => rare::hold_back(over, exact),
        Pass::SurfacePose { sets, skinning } => rare::surface_pose(over, sets, skinning),
        Pass::SurfaceBoxes => rare::surface_boxes(over),
        Pass::SurfaceSearch => rare::surface_search(over),
    }
}

/// The targets of limits and of pinned particles, which move with the joints of a cloth or not at all.
fn aim(moves: bool) -> Parts {
    let (file, read): (_, &[_]) = match moves {
        false => (part!("aim_still"), &[Slot::Targets]),
        true => (part!("aim_moving"), &[Slot::Step, Slot::Targets, Slot::Drifts]),
    };
    Parts::new(&[file], read, &[])
}

/// The spheres of backstops, which move with the joints of a cloth or not at all.
fn back(moves: bool) -> Parts {
    let (file, read): (_, &[_]) = match moves {
        false => (part!("back_still"), &[Slot::Backs]),
        true => (part!("back_moving"), &[Slot::Step, Slot::Backs, Slot::BackDrifts]),
    };
    Parts::new(&[file], read, &[])
}

/// Swept contact.
fn contact(over: Over, kinds: Kinds) -> Rule {
    let near: &[_] = if kinds.many { &[part!("near")] } else { &[part!("near_all")] };
    let own = [part!("solid"), part!("friction"), part!("entry"), part!("touch"), part!("sane")];
    let files = [&own, near].concat();
    let parts = Parts::new(&files, &[Slot::Step, Slot::Before, Slot::Solids], &[Slot::Now]);
    rule!("contact", "clear", over, shapes(kinds, parts))
}

/// The way out of colliders, from inside them alone.
fn colliders(over: Over, kinds: Kinds) -> Rule {
    let files = [part!("solid"), if kinds.friction { part!("friction") } else { part!("friction_none") }];
    let read: &[_] = if kinds.friction { &[Slot::Solids, Slot::Step, Slot::Before] } else { &[Slot::Solids] };
    rule!("colliders", "leave_solids", over, shapes(kinds, Parts::new(&files, read, &[Slot::Now])))
}

/// Multipliers of bending, of springs that a cut has left.
fn moments(over: Over, holes: bool) -> Rule {
    let unbroken = if holes { part!("unbroken_rest") } else { part!("unbroken_all") };
    let read = [Slot::Step, Slot::Grids, Slot::Now, Slot::Weights, Slot::Bends];
    let parts = Parts::new(&[part!("laplacian"), unbroken], &read, &[Slot::Moments]);
    let rest: &[_] = if holes { &[reads(Slot::Rest)] } else { &[] };
    rule!("moments", "moment", over, parts.bind(rest))
}

/// Springs with compliance; over several relaxations their multipliers are summed.
fn stretch(over: Over, image: bool, soft: Soft, again: bool) -> Rule {
    let parts = pull(image).and(compliance(soft));
    let parts = match (soft, again) {
        (Soft::None, _) => parts.and(Parts::new(&[part!("soft_none")], &[], &[])),
        (_, false) => parts.and(Parts::new(&[part!("once")], &[], &[])),
        (_, true) => parts.and(Parts::new(&[part!("again")], &[], &[Slot::Sums])),
    };
    rule!("stretch", "stretch", over, parts)
}

/// Parts that springs of sheets share.
fn pull(image: bool) -> Parts {
    let files = [part!("ends"), part!("aside"), part!("pull")];
    Parts::new(&files, &[Slot::Grids], &[Slot::Now]).and(rest(image))
}

/// A step of air, exact or not.
fn integrate(air: Air, exact: bool) -> Parts {
    let verlet = if exact { part!("verlet_exact") } else { part!("verlet") };
    let parts = Parts::new(&[verlet], &[Slot::Step], &[Slot::Now, Slot::Before]);
    let parts = if exact { parts.bind(&[writes(Slot::Lost)]) } else { parts };
    parts.and(match air {
        Air::None => Parts::new(&[part!("air_none")], &[], &[]),
        Air::Push => Parts::new(&[part!("gust"), part!("air_push")], &[], &[]),
        Air::Field => Parts::new(&[part!("air_field")], &[Slot::Field], &[]),
    })
}

/// The velocity of the air at a particle, by [`Pass::Gust`] or alike everywhere.
fn air_at(gusts: bool) -> Parts {
    let (file, read): (_, &[_]) = if gusts { (part!("air_gusty"), &[Slot::Airs]) } else { (part!("air_even"), &[]) };
    Parts::new(&[file], read, &[])
}

/// The largest stretch, a number for a workgroup.
fn strain(over: Over, image: bool, soft: Soft) -> Rule {
    let common = residuals(image, soft);
    let whole = Whole::Call("strain", common.clone().files(&[part!("whole_strain")]));
    let parts = common.files(&[part!("most")]).bind(&[writes(Slot::Strain)]);
    Rule { whole, ..rule!("strain", "", over, parts) }
}

/// Parts for the stretch of springs that is left to be relaxed.
pub(super) fn residuals(image: bool, soft: Soft) -> Parts {
    let share = if soft == Soft::None { part!("share_all") } else { part!("share_soft") };
    let parts = Parts::new(&[part!("larger"), part!("residual"), share], &[Slot::Grids, Slot::Now], &[]);
    parts.and(rest(image)).and(compliance(soft))
}

/// Where rest lengths come from.
fn rest(image: bool) -> Parts {
    let (file, read): (_, &[_]) =
        if image { (part!("rest_image"), &[Slot::Rest]) } else { (part!("rest_constant"), &[]) };
    Parts::new(&[file], read, &[])
}

/// Where compliance comes from, if there is any.
fn compliance(soft: Soft) -> Parts {
    match soft {
        Soft::None => Parts::default(),
        Soft::Constant => Parts::new(&[part!("soft_constant")], &[Slot::Step], &[]),
        Soft::Image => Parts::new(&[part!("soft_image")], &[Slot::Step, Slot::Soft], &[]),
    }
}

/// Asks which triangles are cut away; only cloth that was cut binds the answer.
pub(super) fn open(holes: bool, parts: Parts) -> Parts {
    let (file, read): (_, &[_]) = if holes { (part!("holes"), &[Slot::Holes]) } else { (part!("holes_none"), &[]) };
    parts.and(Parts::new(&[file], read, &[]))
}

/// Carries displacements from nodes; only cloth that was cut binds which of them it still follows.
pub(super) fn parted(cut: bool, parts: Parts) -> Parts {
    let (file, read): (_, &[_]) = if cut { (part!("links"), &[Slot::Links]) } else { (part!("links_all"), &[]) };
    parts.and(Parts::new(&[file], read, &[]))
}

fn shapes(kinds: Kinds, parts: Parts) -> Parts {
    const NAMES: [&str; 7] =
        ["half_spaces", "spheres", "capsules", "boxes", "radial_ellipsoids", "ellipsoids", "tapered_capsules"];
    let each = NAMES.iter().zip(kinds.shapes);
    each.fold(parts, |parts, (name, on)| parts.constant(name, u32::from(on)))
}
