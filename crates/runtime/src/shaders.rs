//! Which files make which shader, and what it binds. The table is explicit: a shader is its parts, in order.

use crate::cloth::Cloth;
use crate::cpu::tile::tiles;
use crate::passes::{Air, Kinds, Pass, Soft};
use crate::tile::TileShape;

mod constants;
mod slot;

pub use slot::{Bound, Slot};
use slot::{reads, writes};

/// How elements are given to threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Threads {
    Particles,
    Rings,
    /// Every texel of every grid.
    Texels,
    /// Half the texels: `true` every other column, `false` every other row.
    Half(bool),
    /// A quarter of the texels: every other column of every other row.
    Quarter,
    /// One workgroup.
    One,
    /// A workgroup a grid.
    Grids,
    /// A workgroup a cloth.
    Cloth,
    /// A workgroup a tile of a grid.
    Tiles(TileShape),
}

/// A shader as the table has it.
pub struct Source {
    pub stem: &'static str,
    pub files: Vec<&'static str>,
    pub bindings: Vec<Bound>,
    pub constants: Vec<(&'static str, f64)>,
    pub threads: Threads,
}

macro_rules! part {
    ($name:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders/part/", $name, ".wgsl"))
    };
}
macro_rules! pass {
    ($name:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders/", $name, ".wgsl"))
    };
}

// Below the macros, which it uses.
mod fused;
mod tile;

const STEP: &str = part!("step");
const BOUND: &str = part!("step_bound");
const NOW: &str = part!("now");
const STORED: &str = part!("stored");
const PLACED: &str = part!("anchor_placed");
const BY_ROWS: &str = part!("by_rows");
const INDEX: &str = part!("index");
const GRID: &str = part!("grid");
const ENDS: &str = part!("ends");
const GUST: &str = part!("gust");
const RINGS: &str = part!("rings");
const UNIT: &str = part!("unit");
const NEIGHBOURS: &str = part!("neighbours");
const QUAD: &str = part!("quad");
const ACTION: &str = part!("action");
const NEAREST: &str = part!("nearest");
const LARGER: &str = part!("larger");
const MOST: &str = part!("most");
const SOLIDS: &str = part!("solids_all");
const LAPLACIAN: &str = part!("laplacian");

/// The shader of a pass.
pub fn source(pass: Pass) -> Source {
    use Slot::{Action, Before, Candidates, Chosen, Fastest, Field, Found, Grids, Holes};
    use Slot::{Members, Normals, Now, Partial, Rest, Solids, Starts, Step};
    let plain = |stem, files: &[&'static str], bindings: &[Bound], threads| {
        let (files, bindings) = (files.to_vec(), bindings.to_vec());
        Source { stem, files, bindings, constants: Vec::new(), threads }
    };
    match pass {
        Pass::Wind { holes } => open(
            holes,
            plain(
                "wind",
                &[STEP, BOUND, GRID, GUST, NEIGHBOURS, pass!("wind")],
                &[reads(Step), reads(Grids), reads(Now), reads(Before), writes(Field)],
                Threads::Texels,
            ),
        ),
        Pass::Integrate(air) => {
            let mut bindings = vec![reads(Step), writes(Now), writes(Before)];
            bindings.extend((air == Air::Field).then_some(reads(Field)));
            let files =
                [&[STEP, BOUND, INDEX, NOW][..], self::air(air), &[part!("verlet"), pass!("integrate")]].concat();
            plain("integrate", &files, &bindings, Threads::Particles)
        }
        Pass::Advance(air) => {
            let mut bindings = vec![reads(Step), writes(Now), writes(Before), writes(Slot::Lost)];
            bindings.extend((air == Air::Field).then_some(reads(Field)));
            let files = [
                &[STEP, BOUND, INDEX, NOW][..],
                self::air(air),
                &[part!("lost"), part!("verlet_exact"), pass!("integrate")],
            ]
            .concat();
            plain("integrate", &files, &bindings, Threads::Particles)
        }
        Pass::Membrane { column, row, holes } => {
            let bindings = [reads(Step), reads(Grids), writes(Now), reads(Slot::Cells), reads(Slot::Yielding)];
            let constants = vec![("column", f64::from(column)), ("row", f64::from(row))];
            let plain = plain(
                "membrane",
                &[STEP, BOUND, GRID, NOW, STORED, part!("cell"), pass!("membrane")],
                &bindings,
                Threads::Quarter,
            );
            open(holes, Source { constants, ..plain })
        }
        Pass::Moments { holes } => {
            let mut files = vec![STEP, BOUND, GRID, part!("now_read"), LAPLACIAN, part!("moment")];
            files.push(if holes { part!("unbroken_rest") } else { part!("unbroken_all") });
            files.push(pass!("moments"));
            let mut bindings = vec![reads(Step), reads(Grids), reads(Now)];
            bindings.extend([reads(Slot::Weights), reads(Slot::Bends), writes(Slot::Moments)]);
            bindings.extend(holes.then_some(reads(Rest)));
            plain("moments", &files, &bindings, Threads::Texels)
        }
        Pass::SeamMoments => {
            let bindings = [reads(Starts), reads(Members), writes(Slot::Moments)];
            plain(
                "seam_moments",
                &[INDEX, RINGS, part!("seam_moment"), pass!("seam_moments")],
                &bindings,
                Threads::Rings,
            )
        }
        Pass::Bend => {
            let bindings = [reads(Grids), writes(Now), reads(Slot::Weights), reads(Slot::Moments)];
            plain("bend", &[GRID, NOW, LAPLACIAN, part!("bent"), pass!("bend")], &bindings, Threads::Texels)
        }
        Pass::Springs { direction, parity, image } => {
            let (rest, read): (_, &[Bound]) =
                if image { (part!("rest_image"), &[reads(Rest)]) } else { (part!("rest_constant"), &[]) };
            let bindings = [&[reads(Grids), writes(Now)], read].concat();
            let threads = Threads::Half(direction == 0);
            let constants = vec![("direction", f64::from(direction)), ("parity", f64::from(parity))];
            Source { constants, ..plain("springs", &[GRID, ENDS, rest, pass!("springs")], &bindings, threads) }
        }
        Pass::Stretch { direction, parity, image, soft, again } => {
            let (files, more) = spring_parts(image, soft, rule(again));
            let mut bindings = vec![reads(Grids), writes(Now)];
            bindings.extend(more);
            let step: &[_] = if soft == Soft::None { &[] } else { &[STEP, BOUND] };
            bindings.extend((soft != Soft::None).then_some(reads(Step)));
            let files = [step, &[GRID, NOW, STORED], &files, &[pass!("stretch")]].concat();
            let constants = vec![("direction", f64::from(direction)), ("parity", f64::from(parity))];
            Source { constants, ..plain("stretch", &files, &bindings, Threads::Half(direction == 0)) }
        }
        Pass::Fused(fused) => fused::source(fused),
        Pass::Tile(tile) => tile::source(tile),
        Pass::Pyramid { directions, seams, cut } => {
            let mut bindings = vec![reads(Slot::Levels), reads(Now), writes(Slot::Nodes)];
            bindings.extend([reads(Slot::Limits), reads(Grids)]);
            bindings.extend(seams.then_some(reads(Slot::Ties)));
            let constants = (0..4).map(|d| (["right", "down", "down_right", "up_right"][d], directions[d]));
            let constants = constants.map(|(name, on)| (name, f64::from(u8::from(on)))).collect();
            let ties: &[_] = match (seams, cut) {
                (false, _) => &[part!("ties_none")],
                (true, false) => &[part!("ties"), part!("ties_near")],
                (true, true) => &[part!("ties"), part!("ties_exact")],
            };
            let files = [&[GRID, ENDS, part!("level"), pass!("pyramid")], ties].concat();
            let threads = if seams { Threads::Cloth } else { Threads::Grids };
            parted(cut, Source { constants, ..plain("pyramid", &files, &bindings, threads) })
        }
        Pass::Refine { seams, cut } => {
            let bindings = [reads(Slot::Levels), writes(Now), writes(Before), reads(Slot::Nodes), reads(Grids)];
            let constants = vec![("carried", crate::levels::carried(seams))];
            let files = [GRID, part!("level"), pass!("refine")];
            parted(cut, Source { constants, ..plain("refine", &files, &bindings, Threads::Texels) })
        }
        Pass::Forget => plain("forget", &[INDEX, pass!("forget")], &[writes(Slot::Sums)], Threads::Particles),
        Pass::Tethers { slots } => {
            let bindings = [writes(Now), reads(Slot::Tethers)];
            let constants = vec![("slots", f64::from(slots))];
            Source {
                constants,
                ..plain(
                    "tethers",
                    &[INDEX, NOW, STORED, PLACED, part!("tether"), pass!("tethers")],
                    &bindings,
                    Threads::Particles,
                )
            }
        }
        Pass::Contact(kinds) => {
            let here = [STEP, BOUND, INDEX, NOW, part!("before")];
            let near: &[_] = if kinds.many { &[part!("notes"), part!("near")] } else { &[part!("near_all")] };
            let files = [&here[..], &[SOLIDS], &CONTACT, near, &[pass!("contact")]].concat();
            let bindings = [writes(Now), reads(Solids), reads(Step), reads(Before)];
            Source { constants: shapes(kinds), ..plain("contact", &files, &bindings, Threads::Particles) }
        }
        Pass::Guard => plain(
            "guard",
            &[INDEX, part!("sane"), pass!("guard")],
            &[reads(Now), writes(Slot::Faults)],
            Threads::Particles,
        ),
        Pass::Restore => {
            let bindings = [writes(Now), writes(Before), writes(Slot::Faults), writes(Slot::Good)];
            plain("restore", &[INDEX, pass!("restore")], &bindings, Threads::Particles)
        }
        Pass::Seams => {
            let bindings = [writes(Now), reads(Starts), reads(Members)];
            plain("seams", &[INDEX, NOW, STORED, RINGS, part!("seam"), pass!("seams")], &bindings, Threads::Rings)
        }
        Pass::SeamSteps => {
            let bindings = [writes(Now), writes(Before), reads(Starts), reads(Members)];
            plain("seam_steps", &[INDEX, RINGS, pass!("seam_steps")], &bindings, Threads::Rings)
        }
        Pass::Colliders(kinds) => colliders(
            kinds,
            plain("colliders", &[INDEX, SOLIDS, part!("solid")], &[writes(Now), reads(Solids)], Threads::Particles),
        ),
        Pass::Normals { holes } => open(
            holes,
            plain(
                "normals",
                &[GRID, NEIGHBOURS, UNIT, part!("normal"), pass!("normals")],
                &[reads(Grids), reads(Now), writes(Normals)],
                Threads::Texels,
            ),
        ),
        Pass::SeamNormals => {
            let bindings = [reads(Starts), reads(Members), writes(Normals)];
            plain(
                "seam_normals",
                &[INDEX, RINGS, UNIT, part!("seam_normal"), pass!("seam_normals")],
                &bindings,
                Threads::Rings,
            )
        }
        Pass::Speed => plain(
            "speed",
            &[INDEX, LARGER, MOST, pass!("speed")],
            &[reads(Now), reads(Before), writes(Partial)],
            Threads::Particles,
        ),
        Pass::Fastest => {
            plain("fastest", &[LARGER, MOST, pass!("fastest")], &[reads(Partial), writes(Fastest)], Threads::One)
        }
        Pass::Strain { image, soft } => {
            let mut files = vec![GRID, LARGER, MOST, part!("residual"), share(soft), pass!("strain")];
            files.push(if image { part!("rest_image") } else { part!("rest_constant") });
            let mut bindings = vec![reads(Grids), reads(Now), writes(Slot::Strain)];
            bindings.extend(image.then_some(reads(Rest)));
            if soft != Soft::None {
                files.extend([STEP, BOUND]);
                files.push(if soft == Soft::Image { part!("soft_image") } else { part!("soft_constant") });
                bindings.push(reads(Step));
                bindings.extend((soft == Soft::Image).then_some(reads(Slot::Soft)));
            }
            plain("strain", &files, &bindings, Threads::Texels)
        }
        Pass::Cut => plain(
            "cut",
            &[GRID, QUAD, ACTION, pass!("cut")],
            &[reads(Grids), reads(Now), reads(Action), writes(Holes)],
            Threads::Texels,
        ),
        Pass::CutSprings => open(
            true,
            plain(
                "cut_springs",
                &[GRID, QUAD, pass!("cut_springs")],
                &[reads(Grids), reads(Now), writes(Rest)],
                Threads::Texels,
            ),
        ),
        Pass::CutTethers { slots, seams } => {
            let mates = if seams { part!("mates") } else { part!("mates_none") };
            let mut bindings = vec![reads(Grids), reads(Rest), reads(Action), reads(Slot::Tethers)];
            bindings.extend([Slot::Supports, Slot::Holding, Slot::Changes].map(writes));
            bindings.extend(seams.then_some(reads(Slot::Mates)));
            let files = [GRID, ACTION, mates, part!("route"), pass!("cut_tethers")];
            let constants = vec![("slots", f64::from(slots))];
            Source { constants, ..plain("cut_tethers", &files, &bindings, Threads::Texels) }
        }
        Pass::CutLevels => plain(
            "cut_levels",
            &[GRID, part!("level"), pass!("cut_levels")],
            &[
                reads(Grids),
                reads(Rest),
                reads(Slot::Levels),
                writes(Slot::Nodes),
                writes(Slot::Limits),
                writes(Slot::Links),
            ],
            Threads::Grids,
        ),
        Pass::Transform => plain(
            "transform",
            &[INDEX, ACTION, pass!("transform")],
            &[writes(Now), writes(Before), reads(Action), reads(Chosen)],
            Threads::Particles,
        ),
        Pass::Pick { holes } => open(
            holes,
            plain(
                "pick",
                &[GRID, QUAD, ACTION, NEAREST, pass!("pick")],
                &[reads(Grids), reads(Now), reads(Action), writes(Candidates)],
                Threads::Texels,
            ),
        ),
        Pass::PickNearest => plain(
            "pick_nearest",
            &[GRID, QUAD, NEAREST, pass!("pick_nearest")],
            &[reads(Grids), reads(Now), reads(Candidates), writes(Found)],
            Threads::One,
        ),
    }
}

/// A shader that asks which triangles are cut away; only cloth that was cut binds the answer.
fn open(holes: bool, mut source: Source) -> Source {
    source.files.insert(0, if holes { part!("holes") } else { part!("holes_none") });
    source.bindings.extend(holes.then_some(reads(Slot::Holes)));
    source
}

/// A shader that carries displacements from nodes; only cloth that was cut binds which of them it still follows.
fn parted(cut: bool, mut source: Source) -> Source {
    source.files.insert(0, if cut { part!("links") } else { part!("links_all") });
    source.bindings.extend(cut.then_some(reads(Slot::Links)));
    source
}

fn colliders(kinds: Kinds, mut source: Source) -> Source {
    source.constants = shapes(kinds);
    if kinds.friction {
        source.files.splice(..0, [STEP, BOUND]);
        source.files.extend([part!("before"), part!("friction")]);
        source.bindings.extend([reads(Slot::Step), reads(Slot::Before)]);
    } else {
        source.files.push(part!("friction_none"));
    }
    source.files.push(pass!("colliders"));
    source
}

/// What air adds to gravity.
fn air(air: Air) -> &'static [&'static str] {
    match air {
        Air::None => &[part!("air_none")],
        Air::Push => &[GUST, part!("air_push")],
        Air::Field => &[part!("air_field")],
    }
}

/// The rule of swept contact.
const CONTACT: [&str; 4] = [part!("solid"), part!("friction"), part!("entry"), part!("touch")];

/// The rule of springs, and what it reads of a cloth beside positions.
///
/// The rule of multipliers, and what that reads, are the last argument; they are used where springs have compliance.
fn spring_parts(image: bool, soft: Soft, (rule, read): Rule) -> (Vec<&'static str>, Vec<Bound>) {
    let mut files = vec![ENDS, if image { part!("rest_image") } else { part!("rest_constant") }];
    let mut bindings: Vec<_> = image.then_some(reads(Slot::Rest)).into_iter().collect();
    match soft {
        Soft::None => files.push(part!("soft_none")),
        Soft::Constant => files.push(part!("soft_constant")),
        Soft::Image => {
            files.push(part!("soft_image"));
            bindings.push(reads(Slot::Soft));
        }
    }
    if soft != Soft::None {
        files.extend(rule);
        bindings.extend(read);
    }
    files.extend([part!("aside"), part!("spring")]);
    (files, bindings)
}

/// Files and bindings.
type Rule = (Vec<&'static str>, Vec<Bound>);

/// How springs with compliance find their multipliers.
fn rule(again: bool) -> Rule {
    if again {
        (vec![part!("sums"), part!("again")], vec![writes(Slot::Sums)])
    } else {
        (vec![part!("once")], Vec::new())
    }
}

/// How much of a stretch is error.
fn share(soft: Soft) -> &'static str {
    if soft == Soft::None { part!("share_all") } else { part!("share_soft") }
}

fn shapes(kinds: Kinds) -> Vec<(&'static str, f64)> {
    const NAMES: [&str; 6] = ["half_spaces", "spheres", "capsules", "boxes", "radial_ellipsoids", "ellipsoids"];
    NAMES.iter().zip(kinds.shapes).map(|(name, on)| (*name, f64::from(u8::from(on)))).collect()
}

/// Workgroups in a row of a list; x is limited to 65,535.
const ROW: u32 = 32_768;

/// Workgroups for a list of elements.
pub fn list(count: usize) -> [u32; 3] {
    let groups = (count as u32).div_ceil(64);
    [groups.min(ROW), groups.div_ceil(ROW), 1]
}

impl Source {
    /// The whole text.
    pub fn text(&self) -> String {
        [&[constants::text()], &self.files[..]].concat().concat()
    }

    /// Workgroups to dispatch for a cloth.
    pub fn workgroups(&self, cloth: &Cloth) -> [u32; 3] {
        let sides = |half_x: bool, half_y: bool| {
            let most = |side: fn(&crate::cloth::Grid) -> u32| cloth.grids().iter().map(side).max().unwrap_or(0);
            let (w, h) = (most(|g| g.width), most(|g| g.height));
            let (w, h) = (if half_x { w.div_ceil(2) } else { w }, if half_y { h.div_ceil(2) } else { h });
            [w.div_ceil(16), h.div_ceil(4), cloth.grids().len() as u32]
        };
        match self.threads {
            Threads::Particles => list(cloth.len()),
            Threads::Rings => list(cloth.ring_count()),
            Threads::Texels => sides(false, false),
            Threads::Quarter => sides(true, true),
            Threads::One | Threads::Cloth => [1; 3],
            Threads::Grids => [1, 1, cloth.grids().len() as u32],
            Threads::Half(columns) => sides(columns, !columns),
            Threads::Tiles(TileShape { inner, lacks, .. }) => {
                let [x, y] = [0, 1].map(|d| cloth.grids().iter().map(|g| tiles(g, inner, lacks)[d]).max().unwrap_or(0));
                [x, y, cloth.grids().len() as u32]
            }
        }
    }
}

#[cfg(test)]
mod loops_tests;
#[cfg(test)]
#[path = "shaders_tests.rs"]
mod tests;
