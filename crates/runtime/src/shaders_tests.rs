use std::collections::BTreeSet;
use std::mem::offset_of;
use std::path::PathBuf;

use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, Module, StorageAccess, TypeInner};

use super::*;
use crate::fused::{Fused, Hold};
use crate::layout::{FrameRow, GridRow, JobRow, LinkRow, SolidRow, StepRow};
use crate::tile::{Tile, TileShape};

/// Every variant that a schedule can hold, up to constants.
pub(super) fn variants() -> Vec<Pass> {
    let mut all = vec![Pass::Seams, Pass::SeamSteps, Pass::SeamNormals, Pass::Speed, Pass::Fastest];
    all.extend([Pass::Cut, Pass::CutSprings, Pass::CutLevels, Pass::Transform, Pass::PickNearest]);
    for holes in [false, true] {
        all.extend([Pass::Wind { holes }, Pass::Normals { holes }, Pass::Pick { holes }]);
    }
    all.extend([Air::None, Air::Push, Air::Field].map(Pass::Integrate));
    all.extend([Air::None, Air::Push, Air::Field].map(Pass::Advance));
    let springs = (0..16).map(|k| Pass::Springs { direction: k / 4, parity: k / 2 % 2, image: k % 2 == 1 });
    all.extend(springs);
    for (friction, many) in [(false, false), (true, false), (false, true), (true, true)] {
        let kinds = Kinds { shapes: [true; 6], friction, many };
        all.extend([Pass::Colliders(kinds), Pass::Contact(kinds)]);
    }
    for (direction, soft) in (0..4).flat_map(|d| SOFTS.map(|s| (d, s))) {
        let stretch = |k: u32| (k % 2, k & 2 > 0, k & 4 > 0 && soft != Soft::None);
        all.extend((0..8).map(stretch).map(|(parity, image, again)| Pass::Stretch {
            direction,
            parity,
            image,
            soft,
            again,
        }));
    }
    for soft in SOFTS {
        all.extend([false, true].map(|image| Pass::Strain { image, soft }));
    }
    all.extend([Pass::Guard, Pass::Restore, Pass::SeamMoments, Pass::Bend]);
    all.extend([false, true].map(|holes| Pass::Moments { holes }));
    all.extend([false, true].map(|holes| Pass::Membrane { column: 1, row: 0, holes }));
    let directions = [true, true, false, true];
    for cut in [false, true] {
        all.extend([false, true].map(|seams| Pass::Pyramid { directions, seams, cut }));
        all.extend([false, true].map(|seams| Pass::Refine { seams, cut }));
    }
    all.extend([Pass::Forget, Pass::Tethers { slots: 1 }, Pass::Tethers { slots: 4 }]);
    all.extend([false, true].map(|seams| Pass::CutTethers { slots: 2, seams }));
    all.extend(fused().map(Pass::Fused));
    all.extend(tiles().map(Pass::Tile));
    all
}

/// Every part of tiles, alone and with all others.
fn tiles() -> impl Iterator<Item = Tile> {
    let airs = [None, Some(Air::None), Some(Air::Push), Some(Air::Field)];
    (0..64u32).flat_map(move |k| {
        let on = move |bit: u32| k >> bit & 1 == 1;
        (0..12).map(move |n| Tile {
            air: airs[n % 4],
            exact: on(3) && n % 4 > 0,
            forget: on(2) && on(3) && n > 3,
            again: on(2) && (on(3) || on(4)) && n > 3,
            tethers: [on(0), on(1)],
            slots: 2 * u32::from(on(0) || on(1)),
            colours: if on(2) { 0xff } else { 0 },
            polish: u32::from(on(2) && on(0)),
            image: on(3),
            soft: if on(2) { SOFTS[n / 4] } else { Soft::None },
            contact: on(4).then_some(Kinds { shapes: [true; 6], friction: on(2), many: on(5) }),
            shape: TileShape { inner: [22; 2], around: [5; 2], lacks: [1; 2], room: [32; 2] },
            threads: 256,
        })
    })
}

const SOFTS: [Soft; 3] = [Soft::None, Soft::Constant, Soft::Image];

/// Every part of whole frames, alone and with all others.
fn fused() -> impl Iterator<Item = Fused> {
    let holds = [Hold::Both, Hold::Wide, Hold::Narrow, Hold::Stored];
    (0..128u32).flat_map(move |k| {
        let on = move |bit: u32| k >> bit & 1 == 1;
        (0..SOFTS.len()).map(move |n| Fused {
            air: if on(0) { Air::Push } else { Air::None },
            directions: [true, on(1), true, on(2)],
            image: on(3),
            soft: SOFTS[n],
            again: on(4) && SOFTS[n] != Soft::None,
            slots: 2 * u32::from(on(5)),
            polish: u32::from(on(4)),
            seams: on(6),
            exact: on(1),
            membrane: on(2),
            bends: on(3),
            contact: on(4).then_some(Kinds { shapes: [true; 6], friction: on(2), many: on(3) }),
            full: on(5),
            normals: on(1),
            strain: on(5),
            watch: on(0),
            hold: holds[(n + k as usize) % 4],
            places: 1024,
            threads: 256,
        })
    })
}

pub(super) fn module(pass: Pass) -> Module {
    let source = source(pass);
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
    for pass in variants() {
        let module = module(pass);
        let info = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
        info.unwrap_or_else(|e| panic!("{pass:?}: {}", e.emit_to_string(&source(pass).text())));
    }
}

#[test]
fn the_table_names_just_what_shaders_bind() {
    for pass in variants() {
        let module = module(pass);
        let (mut bound, mut storage) = (BTreeSet::new(), 0);
        for (_, variable) in module.global_variables.iter() {
            let Some(binding) = &variable.binding else { continue };
            let writes =
                matches!(variable.space, AddressSpace::Storage { access } if access.contains(StorageAccess::STORE));
            storage += u32::from(variable.space != AddressSpace::Uniform);
            assert_eq!(binding.group, 0, "{pass:?}");
            bound.insert((binding.binding, variable.name.clone().unwrap(), writes));
        }
        let table = source(pass).bindings;
        let table = table.iter().map(|b| (b.slot as u32, b.slot.name().to_string(), b.writes));
        assert_eq!(bound, table.collect(), "{pass:?}");
        // Where a device has no more than WebGPU promises, frames that need more run in passes of their own.
        let most = if matches!(pass, Pass::Fused(_) | Pass::Tile(_)) { 24 } else { 8 };
        assert!(storage <= most, "{pass:?} binds {storage} storage buffers");
    }
}

#[test]
fn constants_of_the_table_are_overrides() {
    for pass in variants() {
        let module = module(pass);
        let overrides: BTreeSet<_> = module.overrides.iter().filter_map(|(_, o)| o.name.clone()).collect();
        let table = source(pass).constants.iter().map(|(name, _)| name.to_string()).collect();
        assert_eq!(overrides, table, "{pass:?}");
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
    let frame = rust!(FrameRow: steps, rounds, together, solids, rows);
    let job = rust!(JobRow: first, count, grid, grids, ring, rings, row, solid, keep, longest);
    let link = rust!(LinkRow: follows, mass);
    let mut seen = BTreeSet::new();
    for pass in variants() {
        let module = module(pass);
        for (_, ty) in module.types.iter() {
            let TypeInner::Struct { members, span } = &ty.inner else { continue };
            let rust = match ty.name.as_deref() {
                Some("Step") => &step,
                Some("Grid") => &grid,
                Some("Solid") => &solid,
                Some("Frame") => &frame,
                Some("Job") => &job,
                Some("Link") => &link,
                // Lives in registers only.
                Some("Ends" | "Exit" | "Entry" | "Quad" | "Edge" | "Below") => continue,
                // A row of four numbers.
                Some("Level") => continue,
                other => panic!("{other:?} has no counterpart"),
            };
            let named = |m: &&naga::StructMember| !m.name.as_deref().unwrap().starts_with("unused");
            let wgsl: Vec<_> = members.iter().filter(named).map(|m| (m.name.as_deref().unwrap(), m.offset)).collect();
            assert_eq!((&wgsl, span), (&rust.0, &rust.1), "{:?}", ty.name);
            seen.insert(ty.name.clone());
        }
    }
    assert_eq!(seen.len(), 6);
    assert_eq!(Slot::Step.bytes(&crate::Flat::square("x", 2).cloth().unwrap(), 0, 0), u64::from(step.1));
}

#[test]
fn every_shader_has_a_twin_and_every_file_is_used() {
    let drawn = crate::draw::all_files();
    let used = variants().iter().flat_map(|p| source(*p).files).chain(drawn).map(String::from).collect();
    let there: BTreeSet<_> = files("shaders").union(&files("shaders/part")).cloned().collect();
    assert_eq!(there.difference(&used).count(), 0);
    let stems: BTreeSet<_> = variants().iter().map(|p| source(*p).stem).chain(["draw"]).collect();
    assert_eq!(stems.len(), files("shaders").len());
    for stem in stems {
        assert!(root().join(format!("shaders/{stem}.wgsl")).is_file(), "{stem}");
        let twin = std::fs::read_to_string(root().join(format!("crates/runtime/src/cpu/{stem}.rs"))).unwrap();
        assert!(twin.contains(&format!("shaders/{stem}.wgsl")), "the twin of {stem} does not name it");
    }
}
