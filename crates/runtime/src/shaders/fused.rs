//! The parts of the shader that runs whole frames.

use super::{
    BY_ROWS, CONTACT, GRID, LAPLACIAN, NEIGHBOURS, NOW, PLACED, RINGS, STEP, Slot, Source, Threads, UNIT, air, reads,
    rule, shapes, share, spring_parts, writes,
};
use crate::fused::{Fused, Hold};

/// Only what the cloths of the batch need is compiled in and bound.
pub(super) fn source(fused: Fused) -> Source {
    let (springs, mut bindings) = spring_parts(fused.image, fused.soft, rule(fused.again));
    bindings.extend([reads(Slot::Frame), reads(Slot::Jobs), reads(Slot::Grids), writes(Slot::Now)]);
    bindings.extend([writes(Slot::Before), writes(Slot::Faults), writes(Slot::Good)]);
    let mut files = vec![STEP, GRID, NOW, BY_ROWS, part!("holes_none"), part!("larger"), part!("sane")];
    let mut constants = vec![("threads", f64::from(fused.threads))];
    constants.extend(DIRECTIONS.iter().zip(fused.directions).map(|(name, on)| (*name, f64::from(u8::from(on)))));
    constants.push(("polish", f64::from(fused.polish)));
    match fused.hold {
        Hold::Both | Hold::Wide => files.push(part!("held")),
        Hold::Narrow => {
            files.push(part!("held_narrow"));
            constants.push(("numbers", f64::from(3 * fused.places)));
        }
        Hold::Stored => files.push(part!("held_stored")),
    }
    if fused.hold == Hold::Both {
        files.push(part!("was_held"));
        constants.push(("befores", f64::from(3 * fused.places)));
    } else {
        files.push(part!("was_stored"));
    }
    constants.extend((fused.hold != Hold::Stored).then(|| ("places", f64::from(fused.places))));
    files.extend(air(fused.air));
    let verlet: &[_] = if fused.exact { &[part!("lost"), part!("verlet_exact")] } else { &[part!("verlet")] };
    files.extend(verlet);
    bindings.extend(fused.exact.then_some(writes(Slot::Lost)));
    if fused.membrane {
        files.extend([part!("cell"), part!("fused_membrane")]);
        bindings.extend([reads(Slot::Cells), reads(Slot::Yielding)]);
    } else {
        files.push(part!("fused_membrane_none"));
    }
    if fused.bends {
        files.extend([LAPLACIAN, part!("unbroken_all"), part!("moment"), part!("bent"), part!("fused_bend")]);
        let seams: &[_] =
            if fused.seams { &[part!("seam_moment"), part!("fused_moments")] } else { &[part!("fused_moments_none")] };
        files.extend(seams);
        bindings.extend([reads(Slot::Weights), reads(Slot::Bends), writes(Slot::Moments)]);
    } else {
        files.push(part!("fused_bend_none"));
    }
    files.extend(springs);
    files.push(if fused.again { part!("fused_forget") } else { part!("fused_forget_none") });
    if fused.slots > 0 {
        files.extend([PLACED, part!("tether"), part!("fused_tethers")]);
        bindings.push(reads(Slot::Tethers));
        constants.push(("slots", f64::from(fused.slots)));
    } else {
        files.push(part!("fused_tethers_none"));
    }
    if fused.seams {
        files.extend([RINGS, part!("seam"), part!("fused_seams")]);
        bindings.extend([reads(Slot::Starts), reads(Slot::Members)]);
    } else {
        files.push(part!("fused_seams_none"));
    }
    if let Some(kinds) = fused.contact {
        files.push(part!("solids_own"));
        files.extend(CONTACT);
        if kinds.many {
            files.push(if fused.full { part!("notes_stored") } else { part!("notes") });
            files.extend([part!("near"), part!("fused_near")]);
        } else {
            files.extend([part!("near_all"), part!("fused_near_all")]);
        }
        files.push(part!("fused_contact"));
        bindings.push(reads(Slot::Solids));
        constants.extend(shapes(kinds));
    } else {
        files.push(part!("fused_contact_none"));
    }
    if fused.normals {
        files.extend([NEIGHBOURS, UNIT, part!("normal"), part!("fused_normals")]);
        bindings.push(writes(Slot::Normals));
        if fused.seams {
            files.extend([part!("seam_normal"), part!("fused_join")]);
        } else {
            files.push(part!("fused_join_none"));
        }
    } else {
        files.push(part!("fused_normals_none"));
    }
    files.push(if fused.watch { part!("fused_speed") } else { part!("fused_speed_none") });
    if fused.strain {
        files.extend([part!("residual"), share(fused.soft), part!("fused_strain")]);
    } else {
        files.push(part!("fused_strain_none"));
    }
    files.push(pass!("fused"));
    Source { stem: "fused", files, bindings, constants, threads: Threads::Cloth }
}

const DIRECTIONS: [&str; 4] = ["right", "down", "down_right", "up_right"];
