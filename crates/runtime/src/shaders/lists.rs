//! Lists that rules read as `NAME_at(n)`: each a buffer of its own, or, in whole frames, parts of buffers that they share.
//!
//! A whole frame of any scene binds at most eight storage buffers, as many as WebGPU promises: positions now and before, normals,
//! faults, colliders, and three that lists share. These are arrays of vectors of four, since one instruction loads a whole vector.

use std::fmt::Write;

use super::parts::{Bound, Parts, reads, writes};
use super::slot::{LISTED, Slot};

/// The first numbers of [`Slot::Lists`]: where the lists begin, and, as the last one, how many particles there is room for.
pub const HEAD: usize = 24;

const _: () = assert!(LISTED.len() < HEAD && matches!(LISTED[0].0, Slot::Jobs));

/// Vectors of four, one a particle, that a frame leaves to the next. In whole frames they lie in [`Slot::Lasting`].
pub const LASTING: [Slot; 2] = [Slot::Good, Slot::Lost];

/// Lists of a frame, with a vector of four per particle: the acceleration by air, the velocity of the air, the sum of multipliers, the
/// multiplier of bending, whose w is 1 if the particle has one, and what the stitch of the particle pulls with. In whole frames they lie
/// in [`Slot::Scratch`].
pub const SCRATCH: [Slot; 5] = [Slot::Field, Slot::Airs, Slot::Sums, Slot::Moments, Slot::Pulls];

/// Declarations of the lists that a shader binds, a buffer each.
pub fn own(bindings: &[Bound]) -> String {
    let mut text = String::new();
    for Bound { slot, writes } in bindings {
        let (name, number) = (slot.name(), *slot as u32);
        let vectors = LASTING.contains(slot) || SCRATCH.contains(slot);
        let element = LISTED.iter().find(|(s, _)| s == slot).and_then(|(_, element)| *element);
        let Some(element) = element.filter(|_| !writes).or(vectors.then_some("vec4<f32>")) else { continue };
        let access = if *writes { "read_write" } else { "read" };
        _ = write!(
            text,
            "@group(0) @binding({number}) var<storage, {access}> {name}: array<{element}>;\n\n\
             fn {name}_at(n: u32) -> {element} {{\n  return {name}[n];\n}}\n\n"
        );
        if *writes {
            text += &setters(name, &format!("{name}[n]"));
        }
    }
    text
}

fn setters(name: &str, place: &str) -> String {
    format!(
        "fn set_{name}(n: u32, x: vec4<f32>) {{\n  {place} = x;\n}}\n\n\
         fn put_{name}(n: u32, part: u32, x: f32) {{\n  {place}[part] = x;\n}}\n\n"
    )
}

/// Replaces the lists in the bindings of several cloths by the buffers that they share. Returns the parts, the declarations of the
/// lists, and the number of lists in [`Slot::Scratch`]. `whole`: of whole frames, in which also lists that frames write share buffers.
pub fn shared(parts: Parts, whole: bool) -> (Parts, String, usize) {
    let (mut text, mut find, mut scratch) = (String::new(), String::new(), 0);
    let mut bindings: Vec<Bound> = Vec::new();
    for bound in &parts.bindings {
        let name = bound.slot.name();
        if bound.slot == Slot::Jobs {
            // Jobs come first, so their place is a constant. Browsers refuse a barrier that depends on a private variable, as threads
            // may differ in it.
            _ = write!(text, "const jobs_from: u32 = {}u;\n\n", HEAD / 4);
            continue;
        }
        let (buffer, from) = if let Some(n) = LISTED.iter().position(|(s, _)| *s == bound.slot) {
            text += &read(name, LISTED[n].1);
            // Indices are those of particles; the images of a cloth lie where those of its first instance do.
            let shift = |each| format!(" + {each} * (job.image / 64u) - {each} * (job.first / 64u)");
            (reads(Slot::Lists), head(n) + &bound.slot.shared_by_64().map(shift).unwrap_or_default())
        } else if let Some(n) = LASTING.iter().position(|s| *s == bound.slot && whole) {
            text += &written(name, "lasting");
            (writes(Slot::Lasting), format!("{n}u * {}", head(HEAD - 1)))
        } else if whole && SCRATCH.contains(&bound.slot) {
            text += &written(name, "scratch");
            scratch += 1;
            (writes(Slot::Scratch), format!("{}u * {}", scratch - 1, head(HEAD - 1)))
        } else {
            bindings.push(*bound);
            continue;
        };
        _ = write!(text, "var<private> {name}_from: u32;\n\n");
        _ = writeln!(find, "  {name}_from = {from};");
        if !bindings.contains(&buffer) {
            bindings.push(buffer);
        }
    }
    for slot in [Slot::Lasting, Slot::Scratch] {
        if bindings.contains(&writes(slot)) {
            let (name, number) = (slot.name(), slot as u32);
            _ = write!(text, "@group(0) @binding({number}) var<storage, read_write> {name}: array<vec4<f32>>;\n\n");
        }
    }
    _ = write!(text, "fn find_lists(job: Job) {{\n{find}}}\n");
    if !whole {
        text += &own(&bindings);
    }
    (Parts { bindings, ..parts }, text, scratch)
}

/// The expression of a number in the head of [`Slot::Lists`].
fn head(n: usize) -> String {
    format!("lists[{}].{}", n / 4, ["x", "y", "z", "w"][n % 4])
}

/// An element of a list that is only read. shaders/part/jobs.wgsl has those that are structs.
fn read(name: &str, element: Option<&str>) -> String {
    let Some(element) = element else { return String::new() };
    let (each, value) = match element {
        "vec4<u32>" => (1, "four"),
        "u32" => (4, "four[n % 4u]"),
        "vec2<u32>" => (2, "select(four.zw, four.xy, n % 2u == 0u)"),
        "vec2<f32>" => (2, "bitcast<vec2<f32>>(select(four.zw, four.xy, n % 2u == 0u))"),
        _ => (1, "bitcast<vec4<f32>>(four)"),
    };
    let place = if each == 1 { "n".to_string() } else { format!("n / {each}u") };
    format!(
        "fn {name}_at(n: u32) -> {element} {{\n  let four = lists[{name}_from + {place}];\n  return {value};\n}}\n\n"
    )
}

/// Access to a list that frames write.
fn written(name: &str, buffer: &str) -> String {
    let place = format!("{buffer}[{name}_from + n]");
    format!("fn {name}_at(n: u32) -> vec4<f32> {{\n  return {place};\n}}\n\n") + &setters(name, &place)
}
