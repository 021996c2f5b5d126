use std::collections::BTreeSet;
use std::mem::offset_of;
use std::path::PathBuf;

use naga::Module;

use super::facts_tests::facts;
use super::rule::rule;
use super::*;
use crate::cloth::Skinning;
use crate::form::{Chain, Fused, Hold, Tile, TileSpan};
use crate::layout::{FrameRow, GridRow, JobRow, LinkRow, SolidRow, StepRow};
use crate::passes::{Air, Kinds, Pass, Schedule, Soft};

/// Every form that a frame or an action can have, up to constants.
pub(super) fn variants() -> Vec<Form> {
    let apart = passes().into_iter().map(Form::Apart);
    let apart = apart.chain(passes().into_iter().filter(is_shared).map(Form::Together));
    let apart = apart.chain(chains().into_iter().map(Form::Chain));
    apart.chain(fused().into_iter().map(Form::Whole)).chain(tiles().into_iter().map(Form::Tile)).collect()
}

/// Every variant of every pass.
fn passes() -> Vec<Pass> {
    let mut all = vec![Pass::Seams, Pass::SeamSteps, Pass::SeamNormals, Pass::Speed, Pass::Fastest];
    all.extend([
        Pass::Cut,
        Pass::CutSprings,
        Pass::CutLevels,
        Pass::Transform,
        Pass::Inertia,
        Pass::Place,
        Pass::PickNearest,
    ]);
    all.extend([Pass::Restrict, Pass::Prolong, Pass::Gust]);
    for holes in [false, true] {
        all.extend([false, true].map(|gusts| Pass::Wind { gusts, holes }));
        all.extend([Pass::Normals { holes }, Pass::Pick { holes }, Pass::Indices { holes }]);
        all.push(Pass::Tangents { holes });
    }
    all.extend(AIRS.map(Pass::Integrate));
    all.extend(AIRS.map(Pass::IntegrateExact));
    let springs = (0..16).map(|k| Pass::Springs { direction: k / 4, parity: k / 2 % 2, image: k % 2 == 1 });
    all.extend(springs);
    for (friction, many) in [(false, false), (true, false), (false, true), (true, true)] {
        let kinds = Kinds { shapes: [true; 7], friction, many };
        all.extend([Pass::Colliders(kinds), Pass::Contact(kinds)]);
    }
    for (direction, soft) in (0..4).flat_map(|d| SOFTS.map(|s| (d, s))) {
        let stretch = |k: u32| (k % 2, k & 2 > 0, k & 4 > 0 && soft != Soft::None);
        let stretch = (0..8).map(stretch);
        all.extend(stretch.map(|(parity, image, again)| Pass::Stretch { direction, parity, image, soft, again }));
    }
    for k in 0..8 {
        all.push(Pass::Polish { direction: k & 1, parity: k >> 1 & 1, image: k & 4 > 0 });
    }
    for soft in SOFTS {
        all.extend([false, true].map(|image| Pass::Strain { image, soft }));
    }
    all.extend([Pass::Guard, Pass::Restore, Pass::SeamMoments, Pass::Bend, Pass::Bounds]);
    all.extend([Pass::Wrap { jumps: false }, Pass::Wrap { jumps: true }, Pass::Jump, Pass::WrapIndices]);
    for (sets, skinning) in [1, 2].into_iter().flat_map(|s| [(s, Skinning::Linear), (s, Skinning::DualQuaternion)]) {
        all.extend([Pass::Blend { sets, skinning }, Pass::Skin { sets, skinning }]);
        all.push(Pass::SurfacePose { sets, skinning });
    }
    all.extend([false, true].map(|holes| Pass::Moments { holes }));
    all.extend([Pass::Stitch { holes: false }, Pass::Stitch { holes: true }, Pass::Sew]);
    all.extend([false, true].map(|holes| Pass::Membrane { column: 1, row: 0, holes }));
    let directions = [true, true, false, true];
    for cut in [false, true] {
        all.extend([false, true].map(|seams| Pass::Pyramid { directions, seams, cut, finest: 2 }));
        all.extend([Pass::CoarseLevel { level: 1, directions, cut }, Pass::CoarseTies { level: 1, cut }]);
        all.extend([false, true].map(|seams| Pass::Refine { seams, cut }));
    }
    all.push(Pass::Follow);
    all.extend([Pass::SurfacePose { sets: 0, skinning: Skinning::Linear }, Pass::SurfaceBoxes, Pass::SurfaceSearch]);
    all.push(Pass::SurfaceContact);
    all.extend([false, true].map(|moves| Pass::Limit { moves }));
    all.extend([false, true].map(|moves| Pass::Backstop { moves }));
    all.extend([Pass::Forget, Pass::Tethers { slots: 1 }, Pass::Tethers { slots: 4 }]);
    all.extend([Pass::Leaves, Pass::Tree, Pass::Separate, Pass::Shadow, Pass::Extents, Pass::Others]);
    all.extend([0, 1, 2].map(|others| Pass::Touch { others }));
    for on in [false, true] {
        all.extend([Pass::Faces { holes: on }, Pass::Gather { begins: on, put: on, sleeps: !on }]);
        all.push(Pass::HoldBack { exact: on });
    }
    all.extend([Pass::Paths, Pass::Truncate]);
    all.extend([false, true].map(|seams| Pass::Partners { seams }));
    for walks in [false, true] {
        let kinds = [(false, false), (true, false), (true, true)];
        all.extend(kinds.map(|(seams, sewn)| Pass::CutTethers { slots: 2, seams, sewn, walks }));
    }
    all
}

/// Whether a pass runs in frames of cloths that share dispatches.
fn is_shared(pass: &Pass) -> bool {
    match pass {
        Pass::Speed | Pass::Strain { .. } => true,
        Pass::Wind { holes, .. } | Pass::Moments { holes } | Pass::Membrane { holes, .. } | Pass::Normals { holes } => {
            !holes
        }
        Pass::Stitch { holes } => !holes,
        Pass::Pyramid { cut, .. } | Pass::CoarseLevel { cut, .. } | Pass::CoarseTies { cut, .. } => !cut,
        Pass::Refine { cut, .. } => !cut,
        Pass::Indices { .. } | Pass::Tangents { .. } => false,
        Pass::Springs { .. } | Pass::Colliders(_) => false,
        _ => !matches!(over(*pass), Over::Own(_)),
    }
}

const SOFTS: [Soft; 3] = [Soft::None, Soft::Constant, Soft::Image];
const AIRS: [Air; 3] = [Air::None, Air::Push, Air::Field];

/// All colours of springs, and rounds of those to the right and down, with tethers before the first of these, or before each.
fn springs(image: bool, soft: Soft, again: bool, rounds: u32, tethers: Option<Pass>, each: bool) -> Vec<Pass> {
    let spring = |(direction, parity)| Pass::Stretch { direction, parity, image, soft, again };
    let colours = [(2, 0), (2, 1), (3, 0), (3, 1), (0, 0), (0, 1), (1, 0), (1, 1)].map(spring);
    let over = |pass| match pass {
        Pass::Stretch { direction, parity, image, soft: Soft::None, .. } => Pass::Polish { direction, parity, image },
        _ => pass,
    };
    // All rounds but the last go too far.
    let round = |n: u32| {
        let before = tethers.into_iter().filter(move |_| each || n == 1);
        before.chain(colours[4..].iter().map(move |p| if n == rounds { *p } else { over(*p) }))
    };
    colours.into_iter().chain((1..=rounds).flat_map(round)).collect()
}

/// Seams, and passes that follow them by the bits of a number.
fn tail(k: u32, slots: u32) -> Vec<Pass> {
    let on = |bit: u32| k >> bit & 1 == 1;
    let mut passes = vec![Pass::Seams];
    passes.extend(on(0).then_some(Pass::Tethers { slots }));
    passes.extend(on(1).then_some(Pass::Limit { moves: on(4) }));
    passes.extend(on(2).then_some(Pass::SurfaceContact));
    passes.extend(on(3).then_some(Pass::Contact(Kinds { shapes: [true; 7], friction: on(2), many: on(5) })));
    passes
}

/// Seams with all that can follow them in place.
fn chains() -> Vec<Chain> {
    let ends = [None, Some(Pass::Guard), Some(Pass::Integrate(Air::Push)), Some(Pass::IntegrateExact(Air::Field))];
    let all = (0..64).flat_map(|k| ends.map(|end| [tail(k, 2), end.into_iter().collect()].concat()));
    all.map(|passes| Chain { passes }).collect()
}

/// Every part of tiles, alone and with all others.
fn tiles() -> Vec<Tile> {
    let airs: Vec<_> = [None].into_iter().chain(AIRS.map(Some)).collect();
    let mut all = Vec::new();
    for (k, n) in (0..64u32).flat_map(|k| (0..12).map(move |n| (k, n))) {
        let on = |bit: u32| k >> bit & 1 == 1;
        let (soft, exact) = (SOFTS[n / 4], on(3));
        let again = on(2) && (on(3) || on(4)) && soft != Soft::None;
        let tethers = Some(Pass::Tethers { slots: 2 });
        let mut passes: Vec<Pass> = airs[n % airs.len()]
            .map(|air| if exact { Pass::IntegrateExact(air) } else { Pass::Integrate(air) })
            .into_iter()
            .collect();
        passes.extend((again && on(3)).then_some(Pass::Forget));
        passes.extend(tethers.filter(|_| on(0)));
        if on(2) {
            passes.extend(springs(on(3), soft, again, 2 * u32::from(on(0)), tethers, on(1) || on(4)));
        }
        passes.extend(tethers.filter(|_| on(1) || on(0) && !on(4)));
        passes.extend((on(1) && on(4)).then_some(Pass::Limit { moves: on(2) }));
        passes.extend(on(1).then_some(Pass::SurfaceContact));
        passes.extend(on(4).then_some(Pass::Contact(Kinds { shapes: [true; 7], friction: on(2), many: on(5) })));
        let shape = TileShape { inner: [22; 2], around: [5; 2], lacks: [1; 2], room: [32; 2] };
        let spans: &[_] = match passes.first() {
            Some(Pass::Integrate(_)) => &[TileSpan::Part, TileSpan::Step, TileSpan::Ahead],
            Some(Pass::IntegrateExact(_)) => &[TileSpan::Part, TileSpan::Step],
            _ => &[TileSpan::Part],
        };
        // After seams, and what follows them in the last step.
        if !matches!(passes.last(), Some(Pass::Contact(_))) {
            let passes = [tail(k, 2 + (n as u32) % 2), passes.clone()].concat();
            let sewn = spans.iter().filter(|span| **span != TileSpan::Ahead);
            all.extend(sewn.map(|s| Tile { passes: passes.clone(), shape, threads: 256, shared: true, span: *s }));
        }
        let forms = spans.iter().map(|s| (true, *s)).chain([(false, TileSpan::Part)]);
        all.extend(forms.map(|(shared, span)| Tile { passes: passes.clone(), shape, threads: 256, shared, span }));
    }
    all
}

/// Every part of whole frames, alone and with all others.
fn fused() -> Vec<Fused> {
    let holds = [Hold::Both, Hold::Wide, Hold::Narrow];
    let mut all = Vec::new();
    for (k, n) in (0..128u32).flat_map(|k| (0..SOFTS.len()).map(move |n| (k, n))) {
        let on = |bit: u32| k >> bit & 1 == 1;
        let (image, soft, again) = (on(3), SOFTS[n], on(4) && SOFTS[n] != Soft::None);
        // Of cloth that is cut.
        let holes = image && on(6);
        let air = AIRS[(k as usize + n) % AIRS.len()];
        let (seams, tethers) = (on(6).then_some(Pass::Seams), on(5).then_some(Pass::Tethers { slots: 2 }));
        let mut s = Schedule::default();
        let gusts = on(0);
        s.gusts.extend((air == Air::Field && gusts).then_some(Pass::Gust));
        s.air.extend((air == Air::Field).then_some(Pass::Wind { gusts, holes }));
        s.step.push(if on(1) { Pass::IntegrateExact(air) } else { Pass::Integrate(air) });
        if on(3) {
            s.step.extend([Pass::Moments { holes }, Pass::Bend]);
            s.step.extend(seams.map(|_| Pass::SeamMoments));
        }
        s.step.extend(on(2).then_some(Pass::Membrane { column: 1, row: 0, holes }));
        s.step.extend(again.then_some(Pass::Forget));
        s.relax.extend(tethers);
        let alone = !on(3) && !on(4);
        s.relax.extend(springs(image, soft, again, 2 * u32::from(on(4) || on(5)), tethers, !alone));
        s.relax.extend(seams);
        s.relax.extend(tethers.filter(|_| alone));
        s.relax.extend(on(0).then_some(Pass::Limit { moves: on(1) }));
        s.relax.extend(on(3).then_some(Pass::SurfaceContact));
        let kinds = Kinds { shapes: [true; 7], friction: on(2), many: on(3) };
        s.relax.extend(on(4).then_some(Pass::Contact(kinds)));
        if !holes && !on(4) && on(0) != on(2) {
            let (cut, seams, directions) = (false, seams.is_some(), [true, true, false, true]);
            s.coarse = vec![Pass::Pyramid { directions, seams, cut, finest: 2 }];
            s.coarse.push(Pass::CoarseLevel { level: 1, directions, cut });
            s.coarse.extend(seams.then_some(Pass::CoarseTies { level: 1, cut }));
            s.coarse.push(Pass::Refine { seams, cut });
            s.coarse.extend(seams.then_some(Pass::SeamSteps));
        }
        s.frame.extend([Pass::Guard, Pass::Restore]);
        s.frame.extend(on(1).then_some(Pass::Normals { holes }));
        s.frame.extend(seams.filter(|_| on(1)).map(|_| Pass::SeamNormals));
        s.frame.extend(on(5).then_some(Pass::Strain { image, soft }));
        s.frame.extend(on(0).then_some([Pass::Speed, Pass::Fastest]).into_iter().flatten());
        let hold = holds[(n + k as usize) % 3];
        // Of which a thread has four particles, or eight.
        let threads = if n == 0 { 128 } else { 256 };
        all.push(Fused { schedule: s.into(), full: on(5), hold, places: 1024, threads });
    }
    all
}

pub(super) fn module(form: &Form) -> Module {
    let source = source(form);
    let module = naga::front::wgsl::parse_str(&source.text());
    module.unwrap_or_else(|e| panic!("{}: {}", source.stem, e.emit_to_string(&source.text())))
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn files(folder: &str) -> BTreeSet<String> {
    let entries = std::fs::read_dir(root().join(folder)).unwrap().map(|e| e.unwrap().path());
    let wgsl = entries.filter(|p| p.extension().is_some_and(|e| e == "wgsl"));
    wgsl.map(|p| std::fs::read_to_string(p).unwrap()).collect()
}

#[test]
fn every_shader_is_valid_without_any_capability() {
    for (form, facts) in facts() {
        assert!(facts.fault.is_none(), "{form:?}: {}", facts.fault.as_ref().unwrap());
    }
}

#[test]
fn previous_positions_in_registers_are_asked_for_by_their_own_threads() {
    let (mut own, mut others) = (0, 0);
    for fused in fused() {
        let Schedule { gusts, air, step, coarse, relax, .. } = &*fused.schedule;
        let steps = gusts.iter().chain(air).chain(step).chain(coarse).chain(relax);
        let alone = |pass: &Pass| matches!(over(*pass), Over::Particles | Over::Near | Over::Placed);
        let asks = steps.filter(|pass| !alone(pass)).any(|pass| rule(*pass).parts.binds(Slot::Before));
        let few = fused.places <= 4 * fused.threads;
        let text = source(&Form::Whole(fused.clone())).text();
        let there = |part: &str| text.contains(part);
        let registers = few && !asks;
        assert_eq!(there("own_before[mine]"), registers, "{:?}", fused.schedule);
        assert_eq!(there("own_tethers[mine"), registers && there("fn tether("), "{:?}", fused.schedule);
        (own, others) = (own + u32::from(registers), others + u32::from(!registers));
    }
    assert!(own > 100 && others > 100, "{own} {others}");
}

#[test]
fn what_ends_a_whole_frame_reads_positions_where_they_were_held() {
    let mut checked = 0;
    for fused in fused().into_iter().filter(|f| f.hold != Hold::Narrow) {
        let module = module(&Form::Whole(fused));
        let now = module.global_variables.iter().find(|(_, v)| v.name.as_deref() == Some("now")).unwrap().0;
        let named = |f: &naga::Function| {
            f.name.as_deref().is_some_and(|n| ["guard", "restore", "normal_at", "neighbour"].contains(&n))
        };
        for (_, function) in module.functions.iter().filter(|(_, f)| named(f)) {
            let whole = |e: &naga::Expression| matches!(e, naga::Expression::GlobalVariable(v) if *v == now);
            let at = |pointer: &naga::Handle<naga::Expression>| match function.expressions[*pointer] {
                naga::Expression::Access { base, .. } | naga::Expression::AccessIndex { base, .. } => base,
                _ => *pointer,
            };
            let loads = |e: &naga::Expression| match e {
                naga::Expression::Load { pointer } => {
                    whole(&function.expressions[at(pointer)]) || whole(&function.expressions[at(&at(pointer))])
                }
                _ => false,
            };
            assert!(!function.expressions.iter().any(|(_, e)| loads(e)), "{:?}", function.name);
            checked += 1;
        }
    }
    assert!(checked > 500, "{checked}");
}

#[test]
fn threads_hand_lists_of_a_frame_over_behind_storage_barriers() {
    let mut checked = 0;
    for fused in fused().iter().filter(|f| f.schedule.step.contains(&Pass::Forget)) {
        // A barrier of workgroup memory, which `sync` is for most, does not order accesses of buffers.
        let text = whole(fused).program;
        let alone = "  storageBarrier();\n  forget_all(job, local);\n  sync();\n  storageBarrier();\n";
        assert!(text.contains(alone), "{text}");
        checked += 1;
    }
    assert!(checked > 20);
}

#[test]
fn a_workgroup_of_a_whole_frame_has_one_atomic_per_maximum() {
    let mut checked = 0;
    for fused in fused() {
        let module = module(&Form::Whole(fused));
        let named = |f: &naga::Function| f.name.as_deref().is_some_and(|n| ["speed_all", "strain_all"].contains(&n));
        for (_, function) in module.functions.iter().filter(|(_, f)| named(f)) {
            let atomic = |s: &naga::Statement| matches!(s, naga::Statement::Atomic { .. });
            let first =
                |s: &naga::Statement| matches!(s, naga::Statement::If { accept, .. } if accept.iter().any(atomic));
            assert!(!function.body.iter().any(atomic) && function.body.iter().any(first), "{:?}", function.name);
            checked += 1;
        }
    }
    assert!(checked > 50, "{checked}");
}

#[test]
fn the_table_names_just_what_shaders_bind() {
    for (form, facts) in facts() {
        assert!(facts.groups.iter().all(|group| *group == 0), "{form:?}");
        let table = source(form).bindings;
        let table = table.iter().map(|b| (b.slot as u32, b.slot.name().to_string(), b.writes));
        assert_eq!(facts.bound, table.collect(), "{form:?}");
        // No more than WebGPU promises. Where a tile would bind more, its passes run in two.
        let most = if matches!(form, Form::Tile(_)) { 24 } else { 8 };
        assert!(facts.storage <= most, "{form:?} binds {} storage buffers", facts.storage);
    }
}

#[test]
fn constants_of_the_table_are_overrides() {
    for (form, facts) in facts() {
        let table = source(form).constants.iter().map(|(name, _)| name.to_string()).collect();
        assert_eq!(facts.overrides, table, "{form:?}");
    }
}

#[test]
fn structs_lie_as_in_rust() {
    macro_rules! rust {
        ($t:ty: $($field:ident),*) => {
            (vec![$((stringify!($field), offset_of!($t, $field) as u32)),*], size_of::<$t>() as u32)
        };
    }
    let step = rust!(StepRow: gravity, keep, wind, scale, drift, response, turn, fineness, longest, dt, rate, drag, lift, left);
    let grid = rust!(GridRow: first, width, height, soft, rest);
    let solid = rust!(SolidRow: center, kind, size, friction, rotation, velocity, spin);
    let frame = rust!(FrameRow: steps, rounds, together, solids, most, pyramid, rows);
    let job = rust!(JobRow: first, count, grid, grids, ring, rings, row, solid, keep, longest, hold, image, solids, levels, gravity, wind);
    let link = rust!(LinkRow: follows, mass);
    let mut seen = BTreeSet::new();
    for (_, facts) in facts() {
        for ty in &facts.structs {
            let rust = match ty.name.as_deref() {
                Some("Step") => &step,
                Some("Grid") => &grid,
                Some("Solid") => &solid,
                Some("Frame") => &frame,
                Some("Job") => &job,
                Some("Link") => &link,
                // Lives in registers only.
                Some(
                    "Ends" | "Pull" | "Exit" | "Entry" | "Taper" | "Quad" | "Edge" | "Below" | "Window" | "Seeker"
                    | "Pose" | "VertexFrame" | "Sheet" | "Bound" | "Spot" | "Corners" | "View" | "Known" | "Struck",
                ) => {
                    continue;
                }
                // A row of four numbers.
                Some("Level") => continue,
                other => panic!("{other:?} has no counterpart"),
            };
            let named = ty.members.iter().filter(|m| !m.0.starts_with("unused"));
            let wgsl: Vec<_> = named.map(|m| (m.0.as_str(), m.1)).collect();
            assert_eq!((&wgsl, ty.span), (&rust.0, rust.1), "{:?}", ty.name);
            seen.insert(ty.name.clone());
        }
    }
    assert_eq!(seen.len(), 6);
    assert_eq!(Slot::Step.bytes(&crate::Flat::square("x", 2).cloth().unwrap(), 0, 0), u64::from(step.1));
}

#[test]
fn every_shader_has_a_twin_and_every_file_is_used() {
    let drawn = crate::draw::all_files();
    let sources: Vec<_> = variants().iter().map(source).collect();
    let texts = |s: &Source| s.files.iter().copied().chain(s.loops.iter().map(|l| l.0)).collect::<Vec<_>>();
    let used: BTreeSet<String> = sources.iter().flat_map(texts).chain(drawn).map(String::from).collect();
    for folder in ["shaders", "shaders/part", "shaders/loop"] {
        assert_eq!(files(folder).difference(&used).collect::<Vec<_>>(), Vec::<&String>::new());
    }
    let stems: BTreeSet<_> = sources.iter().map(|s| s.stem).chain(["draw", "draw_surface"]).collect();
    assert_eq!(stems.len(), files("shaders").len());
    for stem in stems {
        assert!(root().join(format!("shaders/{stem}.wgsl")).is_file(), "{stem}");
        let twin = match stem {
            "draw" => "draw/raster",
            "draw_surface" => "draw/flat",
            "tile" => "tile/reach",
            pass if pass.starts_with("surface_") => &format!("cpu/{}", pass.replacen('_', "/", 1)),
            pass => &format!("cpu/{pass}"),
        };
        let source = |twin: &str| std::fs::read_to_string(root().join(format!("crates/runtime/src/{twin}.rs")));
        // Those of the XPBD solver lie with its data.
        let beside =
            ["cpu/fabric", "cpu/fabric/meeting", "cpu/joint"].map(|folder| source(&format!("{folder}/{stem}")));
        let twin = beside.into_iter().fold(source(twin), Result::or).unwrap();
        assert!(twin.contains(&format!("shaders/{stem}.wgsl")), "the twin of {stem} does not name it");
    }
}
