//! Seams that a dispatch begins with, and the shader of those that passes of particles follow.

use super::lists;
use super::parts::{Parts, reads};
use super::rule::{Over, over, rule};
use super::together::{clears, declared, several};
use super::{Slot, Source, Threads};
use crate::form::Chain;
use crate::passes::Pass;

/// How many of the passes that begin with seams belong to the relaxation of these: up to contact, which is its last, and before the next step
/// or the passes that end a frame. 0 if seams do not come first.
pub fn tail(passes: &[Pass]) -> usize {
    let ends = |p: &Pass| {
        let springs = matches!(over(*p), Over::Springs { .. });
        springs || matches!(p, Pass::Integrate(_) | Pass::IntegrateExact(_) | Pass::Guard)
    };
    if passes.first() != Some(&Pass::Seams) {
        return 0;
    }
    let before = &passes[..passes.iter().position(ends).unwrap_or(passes.len())];
    before.iter().position(|p| matches!(p, Pass::Contact(_))).map_or(before.len(), |n| n + 1)
}

/// Parts for seams at the start of a dispatch: the file that closes them, and one of two, whether or not the colliders
/// that are near are listed.
pub(super) fn sewn(parts: Parts, tail: &[Pass], [own, near, far]: [&'static str; 3]) -> Parts {
    let lists = tail.iter().any(|p| over(*p) == Over::Near);
    let files = [part!("meeting"), part!("sewn"), part!("anchor_sewn"), own, if lists { near } else { far }];
    parts.files(&files).bind(&[reads(Slot::Starts), reads(Slot::Members), reads(Slot::Rings)])
}

/// The calls of what follows seams: before contact, and contact.
pub(super) fn tails(tail: &[Pass]) -> String {
    if tail.is_empty() {
        return String::new();
    }
    let contact = |p: &&Pass| matches!(p, Pass::Contact(_));
    let before: Vec<_> = tail[1..].iter().filter(|p| !contact(p)).collect();
    let touch: Vec<_> = tail[1..].iter().filter(contact).collect();
    format!("\nfn sew_program(k: u32) {{\n{}}}\n\nfn touch_program(k: u32) {{\n{}}}\n", each(&before), each(&touch))
}

/// Calls for a particle.
fn each(passes: &[&Pass]) -> String {
    passes.iter().map(|pass| format!("  {}(k);\n", rule(**pass).call)).collect()
}

/// The rules of all passes, for one particle after the other.
pub fn chain(chain: &Chain) -> Source {
    let (tail, rest) = chain.passes.split_at(tail(&chain.passes));
    let mut parts = Parts::new(&[part!("index")], &[], &[]);
    for pass in &chain.passes {
        let rule = rule(*pass);
        parts = parts.and(rule.parts).files(&[rule.text]);
        parts = if rule.over == Over::Near { parts.files(&[part!("notes")]) } else { parts };
    }
    let parts = sewn(parts, tail, [part!("loose"), part!("chain_near"), part!("chain_far")]);
    let parts = several(parts, false);
    // Anchors lie with the seams.
    let own = parts.bindings.iter().filter(|b| b.slot != Slot::Tethers);
    let files: Vec<_> = own.flat_map(declared).copied().collect();
    let tethers: &[_] = if parts.binds(Slot::Tethers) { &[part!("tether_stored")] } else { &[] };
    let parts = parts.files(tethers);
    let early = !chain.passes.contains(&Pass::Guard);
    let (parts, lists, _) = lists::shared(clears(parts.files(&files), early), false);
    let rest: Vec<_> = rest.iter().collect();
    let program = format!("\n{lists}{}\nfn rest_program(k: u32) {{\n{}}}\n", tails(tail), each(&rest));
    let (files, bindings, constants) = (parts.files, parts.bindings, parts.constants);
    let loops = vec![(turn!("shared_chain"), rule(Pass::Seams).call)];
    Source { stem: "seams", files, loops, program, bindings, constants, threads: Threads::Particles, scratch: 0 }
}
