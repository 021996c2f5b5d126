//! Rules of passes that have loops of their own: those on coarser grids, between images, of actions, and for hosts
//! that ask.

use super::Slot;
use super::parts::{Parts, reads, writes};
use super::rule::{Over, Rule, Whole, open, parted};
use crate::cloth::Skinning;
use Slot::{Action, Candidates, Grids, Holes, Now, Rest};

macro_rules! own {
    ($stem:literal, $over:expr, $parts:expr) => {
        Rule { stem: $stem, text: pass!($stem), call: "", over: $over, whole: Whole::No, parts: $parts }
    };
}

pub(super) fn pyramid(over: Over, directions: [bool; 4], (seams, cut): (bool, bool), finest: u32) -> Rule {
    let mut read = vec![Slot::Levels, Now, Slot::Limits, Grids];
    read.extend(seams.then_some(Slot::Ties));
    let files = [&[part!("ends"), part!("level")], ties(seams, cut)].concat();
    let parts = parted(cut, Parts::new(&files, &read, &[Slot::Nodes]));
    let parts = along(directions, parts).constant("finest", finest);
    let whole = if cut { Whole::No } else { Whole::Loop };
    Rule { call: "limit_levels", whole, ..own!("pyramid", over, parts) }
}

pub(super) fn coarse_level(over: Over, level: u32, directions: [bool; 4], cut: bool) -> Rule {
    let read = [Slot::Levels, Now, Slot::Limits, Grids];
    let parts = parted(cut, Parts::new(&[part!("level")], &read, &[Slot::Nodes]));
    let parts = along(directions, parts).constant("level", level);
    Rule { call: "limit_tile", whole: within_one(cut), ..own!("coarse_level", over, parts) }
}

pub(super) fn coarse_ties(over: Over, level: u32, cut: bool) -> Rule {
    let parts = Parts::new(ties(true, cut), &[Slot::Levels, Grids, Slot::Ties], &[Slot::Nodes]);
    Rule { call: "tie_level", whole: within_one(cut), ..own!("coarse_ties", over, parts.constant("level", level)) }
}

/// In a whole frame one workgroup has all levels. Cut cloth has lists of its own, which no whole frame reads.
fn within_one(cut: bool) -> Whole {
    if cut { Whole::No } else { Whole::Done }
}

/// Files that tie nodes at seams.
fn ties(seams: bool, cut: bool) -> &'static [&'static str] {
    match (seams, cut) {
        (false, _) => &[part!("ties_none")],
        (true, false) => &[part!("ties"), part!("ties_near")],
        (true, true) => &[part!("ties"), part!("ties_exact")],
    }
}

/// Which spring directions there are.
fn along(directions: [bool; 4], parts: Parts) -> Parts {
    let names = ["right", "down", "down_right", "up_right"].into_iter().zip(directions);
    names.fold(parts, |parts, (name, on)| parts.constant(name, u32::from(on)))
}

pub(super) fn cut(over: Over) -> Rule {
    let parts = Parts::new(&[part!("quad"), part!("action")], &[Grids, Now, Action], &[Holes]);
    own!("cut", over, parts)
}

pub(super) fn cut_springs(over: Over) -> Rule {
    own!("cut_springs", over, open(true, Parts::new(&[part!("quad"), part!("sides")], &[Grids, Now], &[Rest])))
}

pub(super) fn cut_tethers(over: Over, slots: u32, [seams, sewn]: [bool; 2], walks: bool) -> Rule {
    let mates = if seams { part!("mates") } else { part!("mates_none") };
    let over_stitches = if sewn { part!("bridges") } else { part!("bridges_none") };
    let mut read = vec![Grids, Rest, Action];
    read.extend(seams.then_some(Slot::Mates));
    let write = [Slot::Tethers, Slot::Supports, Slot::Holding, Slot::Changes];
    let [x, y] = if walks { [256, 1] } else { [16, 4] };
    let parts =
        Parts::new(&[part!("action"), mates, over_stitches, part!("route")], &read, &write).constant("slots", slots);
    let parts = parts.constant("walks", u32::from(walks)).constant("threads_x", x).constant("threads_y", y);
    own!("cut_tethers", over, parts)
}

pub(super) fn cut_levels(over: Over) -> Rule {
    let write = [Slot::Nodes, Slot::Limits, Slot::Links];
    own!("cut_levels", over, Parts::new(&[part!("level")], &[Grids, Rest, Slot::Levels], &write))
}

pub(super) fn transform(over: Over) -> Rule {
    own!("transform", over, chosen())
}

pub(super) fn inertia(over: Over) -> Rule {
    own!("inertia", over, Parts::new(&[part!("action")], &[Action, Now], &[Slot::Before]))
}

pub(super) fn place(over: Over) -> Rule {
    own!("place", over, chosen())
}

pub(super) fn skin(over: Over, sets: u32, skinning: Skinning) -> Rule {
    let parts = Parts::new(&[part!("action"), pose(skinning)], &[Action, Slot::Influences], &[Slot::Skinned]);
    own!("skin", over, parts.constant("sets", sets))
}

pub(super) fn surface_pose(over: Over, sets: u32, skinning: Skinning) -> Rule {
    let parts = Parts::new(&[part!("action"), pose(skinning)], &[Action, Slot::SurfaceShape], &[Slot::SurfaceVertices]);
    own!("surface_pose", over, parts.constant("sets", sets))
}

pub(super) fn surface_boxes(over: Over) -> Rule {
    let read = [Action, Slot::SurfaceVertices, Slot::SurfaceTriangles];
    own!("surface_boxes", over, Parts::new(&[part!("action"), part!("surface")], &read, &[Slot::SurfaceBoxes]))
}

pub(super) fn surface_search(over: Over) -> Rule {
    let read = [Action, Now, Slot::SurfaceVertices, Slot::SurfaceTriangles, Slot::SurfaceBoxes, Slot::Wearers];
    let files = [part!("action"), part!("surface"), part!("surface_walk"), part!("surface_struck")];
    own!("surface_search", over, Parts::new(&files, &read, &[Slot::SurfaceHints, Slot::FoundPlanes]))
}

pub(super) fn restrict(over: Over) -> Rule {
    own!("restrict", over, between().bind(&[writes(Slot::Spare), writes(Slot::Beside)]))
}

pub(super) fn prolong(over: Over) -> Rule {
    own!("prolong", over, between().bind(&[reads(Slot::Beside)]))
}

/// The parts of what carries motion from one image of a cloth to another.
fn between() -> Parts {
    let read = [Slot::Table, Slot::Origin, Slot::OriginBefore];
    Parts::new(&[part!("table")], &read, &[Now, Slot::Before])
}

/// The parts of an action on a list of particles.
fn chosen() -> Parts {
    Parts::new(&[part!("action"), part!("chosen")], &[Action, Slot::Chosen], &[Now, Slot::Before])
}

pub(super) fn pick(over: Over, holes: bool) -> Rule {
    let files = [part!("quad"), part!("action"), part!("nearest")];
    own!("pick", over, open(holes, Parts::new(&files, &[Grids, Now, Action], &[Candidates])))
}

pub(super) fn pick_nearest(over: Over) -> Rule {
    let parts = Parts::new(&[part!("quad"), part!("nearest")], &[Grids, Now, Candidates], &[Slot::Found]);
    own!("pick_nearest", over, parts)
}

pub(super) fn bounds(over: Over) -> Rule {
    own!("bounds", over, Parts::new(&[part!("sane")], &[Now, Slot::Before], &[Slot::Bounds]))
}

pub(super) fn indices(over: Over, holes: bool) -> Rule {
    let parts = open(holes, Parts::new(&[part!("quad")], &[Grids, Now], &[Slot::Indices]));
    Rule { call: "index", ..own!("indices", over, parts) }
}

pub(super) fn tangents(over: Over, holes: bool) -> Rule {
    let files = [part!("quad"), part!("sides"), part!("unit")];
    let parts = Parts::new(&files, &[Grids, Now, Slot::Normals, Slot::Charts], &[Slot::Tangents]);
    Rule { call: "tangent", ..own!("tangents", over, open(holes, parts)) }
}

pub(super) fn wrap(over: Over, jumps: bool) -> Rule {
    let (file, read): (_, &[_]) = if jumps { (part!("jumps"), &[Slot::Jumps]) } else { (part!("jumps_none"), &[]) };
    let parts = vertex_frame().and(Parts::new(&[file], read, &[Slot::Wrapped]));
    own!("wrap", over, parts)
}

pub(super) fn jump(over: Over) -> Rule {
    own!("jump", over, vertex_frame().and(Parts::new(&[], &[Slot::Wrapped], &[Slot::Jumps])))
}

/// The parts of passes that read the drawn surface at the vertices of a bound mesh.
fn vertex_frame() -> Parts {
    let read = [Action, Now, Slot::Before, Slot::Normals, Slot::BoundVertices];
    Parts::new(&[part!("action"), part!("frame")], &read, &[])
}

pub(super) fn wrap_indices(over: Over) -> Rule {
    let parts = Parts::new(&[], &[Slot::Covers, Slot::MeshIndices], &[Slot::LeftIndices]);
    own!("wrap_indices", over, open(true, parts))
}

pub(super) fn blend(over: Over, sets: u32, skinning: Skinning) -> Rule {
    let parts = Parts::new(&[part!("action"), pose(skinning)], &[Action, Slot::Blending], &[Slot::Wrapped]);
    own!("blend", over, parts.constant("sets", sets))
}

/// How several joints move a point.
fn pose(skinning: Skinning) -> &'static str {
    match skinning {
        Skinning::Linear => part!("pose_linear"),
        Skinning::DualQuaternion => part!("pose_dual"),
    }
}

pub(super) fn leaves(over: Over) -> Rule {
    let read = [Grids, Now, Slot::Before, Slot::Kin];
    own!("leaves", over, Parts::new(&[], &read, &[Slot::Boxes]))
}

pub(super) fn tree(over: Over) -> Rule {
    own!("tree", over, Parts::new(&[], &[Grids, Slot::Kin], &[Slot::Boxes]))
}

pub(super) fn partners(over: Over, seams: bool) -> Rule {
    let kin = if seams { part!("kin") } else { part!("kin_none") };
    let parts = Parts::new(&[kin], &[Grids, Now, Slot::Kin, Slot::Homes, Slot::Boxes], &[Slot::Partners]);
    own!("partners", over, parts)
}

/// `others`: steps since it was last seen where other cloths are, 0 for cloth that meets none.
pub(super) fn touch(over: Over, others: u32) -> Rule {
    let read = [Now, Slot::Before, Slot::Kin, Slot::Partners];
    let parts = match others {
        0 => Parts::new(&[part!("apart_from_others")], &read, &[Slot::Pushes]),
        since => {
            let more = [&read[..], &[Slot::Step, Slot::Shadows, Slot::Others]].concat();
            Parts::new(&[part!("among_others")], &more, &[Slot::Pushes]).constant("since", since)
        }
    };
    own!("touch", over, parts)
}

pub(super) fn separate(over: Over) -> Rule {
    own!("separate", over, Parts::new(&[], &[Slot::Pushes], &[Now, Slot::Before]))
}

pub(super) fn shadow(over: Over) -> Rule {
    own!("shadow", over, Parts::new(&[], &[Now, Slot::Before, Slot::Part], &[Slot::Shadow]))
}

pub(super) fn extents(over: Over) -> Rule {
    let read = [Grids, Slot::Kin, Slot::Shadows, Slot::Part];
    own!("extents", over, Parts::new(&[], &read, &[Slot::Boxes]))
}

pub(super) fn others(over: Over) -> Rule {
    let read = [Grids, Slot::Kin, Slot::Homes, Slot::Shadows, Slot::Boxes, Slot::Part];
    own!("others", over, Parts::new(&[], &read, &[Slot::Others, Slot::Struck]))
}

pub(super) fn faces(over: Over, holes: bool) -> Rule {
    own!("faces", over, open(holes, Parts::new(&[], &[Grids, Now, Slot::Kin], &[Slot::Faces])))
}

pub(super) fn gather(over: Over, [begins, put, sleeps]: [bool; 3]) -> Rule {
    let parts = Parts::new(&[part!("sane")], &[Now], &[Slot::Goals, Slot::Places]);
    let parts = parts.constant("begins", begins.into()).constant("put", put.into());
    own!("gather", over, parts.constant("sleeps", sleeps.into()))
}

pub(super) fn paths(over: Over) -> Rule {
    let read = [Slot::Part, Slot::Kin, Slot::Goals, Slot::Places, Slot::Faces];
    let write = [Slot::Boxes, Slot::Bases, Slot::Ways, Slot::Counts];
    own!("paths", over, Parts::new(&[part!("sheets"), part!("even")], &read, &write))
}

pub(super) fn truncate(over: Over) -> Rule {
    let read = [Slot::Part, Slot::Kin, Slot::Boxes, Slot::Goals, Slot::Bases, Slot::Ways];
    let files = [part!("sheets"), part!("planes"), part!("room")];
    own!("truncate", over, Parts::new(&files, &read, &[Slot::Places, Slot::Counts]))
}

/// `exact`: cloth that keeps what is too small for a position to take up.
pub(super) fn hold_back(over: Over, exact: bool) -> Rule {
    let parts = Parts::new(&[part!("sane")], &[Slot::Places], &[Now, Slot::Before]);
    let parts = match exact {
        true => parts.files(&[part!("lost_cleared")]).bind(&[writes(Slot::Lost)]),
        false => parts.files(&[part!("lost_none")]),
    };
    own!("hold_back", over, parts)
}
