//! Numbers that shaders and Rust share, as one WGSL part that is made from Rust.

use std::fmt::Write as _;
use std::mem::offset_of;
use std::sync::LazyLock;

use crate::cloth::{MODELLED_INSIDE_M, SKIPPED_CELLS};
use crate::coarser::{FITS, ROUNDS};
use crate::cpu::fabric::meeting::{extents, others};
use crate::cpu::fabric::{leaves, partners, polish, stretch, touch};
use crate::cpu::surface::{contact, give, nearest, passing, search, struck};
use crate::cpu::{aside, guard, pick, place, route};
use crate::layout::{FAULT_NOTES, FAULT_STRIDE, FaultRow};
use crate::levels::{NODE_TILE, joint, safe};

/// f32 constants. The shortest decimal that reads as the same f32 goes into the shader.
const FLOATS: [(&str, f64); 55] = [
    ("FARTHEST", guard::FARTHEST),
    ("SHORT", aside::SHORT),
    ("ASIDE", aside::ASIDE),
    ("TORN", stretch::TORN),
    ("OVER", polish::OVER),
    ("EDGE", pick::EDGE),
    ("MIN_REACH", leaves::MIN_REACH),
    ("MAX_REACH", leaves::MAX_REACH),
    ("STEPS_AHEAD", leaves::STEPS_AHEAD),
    ("REST_SHARE", partners::REST_SHARE),
    ("TOUCH_SHARE", touch::TOUCH_SHARE),
    ("MAX_PUSH", touch::MAX_PUSH),
    ("SHADOW_WIDTH", extents::WIDTH),
    ("MAX_WAY", safe::MAX_WAY),
    ("FLOOR_SHARE", safe::FLOOR_SHARE),
    ("ASIDE_SHARE", safe::ASIDE),
    ("HELD_ROUNDING", safe::ROUNDING),
    ("EVEN_AREA2", safe::EVEN_AREA2),
    ("EVEN_CHANGE", safe::EVEN_CHANGE),
    ("EVEN_APART", safe::EVEN_APART),
    ("EVEN_ROOM", safe::EVEN_ROOM),
    ("GAP_SHARE", safe::GAP_SHARE),
    ("PLANE_ERROR", safe::PLANE_ERROR),
    ("TOUCH", safe::TOUCH),
    ("MERGES_SHARE", safe::MERGES),
    ("NO_PLANE", contact::NOTHING),
    ("MODELLED_INSIDE_M", MODELLED_INSIDE_M as f64),
    ("MARGIN_M", search::MARGIN_M),
    ("FAST_M", search::FAST_M),
    ("FAST_WAY_M", passing::FAST_WAY_M),
    ("NEARER_M", passing::NEARER_M),
    ("LOOK_M", struck::LOOK_M),
    ("LOOKS", struck::LOOKS),
    ("HELD_M", struck::HELD_M),
    ("WAYS", search::WAYS),
    ("UNKNOWN_WAY_M", search::UNKNOWN_WAY_M),
    ("MAX_WAIT", search::MAX_WAIT),
    ("FASTER_M", search::FASTER_M),
    ("LOST_M", search::LOST_M),
    ("BESIDE_M", search::BESIDE_M),
    ("BESIDE_PER_HEIGHT", search::BESIDE_PER_HEIGHT),
    ("SAME_COSINE", search::SAME_COSINE),
    ("SECOND_M", search::SECOND_M),
    ("SECOND_COSINE", search::SECOND_COSINE),
    ("LEVEL_SINE", search::LEVEL_SINE),
    ("SLANT", search::SLANT),
    ("SLANT_M", search::SLANT_M),
    ("CAUGHT", give::CAUGHT),
    ("CAUGHT_BESIDE", give::CAUGHT_BESIDE),
    ("CAUGHT_GIVE", give::CAUGHT_GIVE),
    ("BACK_SINE", search::BACK_SINE),
    ("BACK_WAYS", search::BACK_WAYS),
    ("FACING_COSINE", search::FACING_COSINE),
    ("OPEN_COSINE", search::OPEN_COSINE),
    ("ON_SURFACE_M", search::ON_SURFACE_M),
];

/// u32 constants. `FAULT_...` are indices into the counters of a cloth.
const NUMBERS: [(&str, usize); 29] = [
    ("UNSUPPORTED", route::UNSUPPORTED as usize),
    ("PLACE_MOVES", place::PLACE_MOVES as usize),
    ("PLACE_WEIGHS", place::PLACE_WEIGHS as usize),
    ("FAULT_PARTICLES", offset_of!(FaultRow, particles) / 4),
    ("FAULT_FRAMES", offset_of!(FaultRow, frames) / 4),
    ("FAULT_LAST", offset_of!(FaultRow, last) / 4),
    ("FAULT_SPEED", offset_of!(FaultRow, speed) / 4),
    ("FAULT_STRAIN", offset_of!(FaultRow, strain) / 4),
    ("FAULT_NOTES", FAULT_NOTES as usize),
    ("FAULT_STRIDE", FAULT_STRIDE as usize),
    ("FITS", FITS),
    ("ROUNDS", ROUNDS),
    ("NODE_TILE", NODE_TILE),
    ("MAX_PARTNERS", partners::MAX_PARTNERS),
    ("MAX_OTHERS", others::MAX_OTHERS),
    ("PLANE_GROUPS", safe::MAX_PLANES / 4),
    ("PROJECTIONS", safe::PROJECTIONS),
    ("HALVINGS", safe::HALVINGS),
    ("MAX_TURNS", safe::MAX_TURNS),
    ("HELD_ROUNDS", safe::ROUNDS as usize),
    ("COUNT_MORE", joint::COUNT_MORE),
    ("COUNT_FORCED", joint::COUNT_FORCED),
    ("COUNT_SLOWED", joint::COUNT_SLOWED),
    ("COUNT_FORCED_MOST", joint::COUNT_FORCED_MOST),
    ("COUNT_SLOWED_MOST", joint::COUNT_SLOWED_MOST),
    ("SKIPPED_CELLS", SKIPPED_CELLS),
    ("SEARCH_FRAMES", search::SEARCH_FRAMES as usize),
    ("WALK_STEPS", nearest::STEPS),
    ("WALK_AROUND", nearest::AROUND),
];

// The notes begin behind the counters.
const _: () = assert!(size_of::<FaultRow>() <= 4 * FAULT_NOTES as usize);

/// The part, which every shader begins with. Constants that a shader does not use cost it nothing.
pub fn text() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| {
        let mut text = String::new();
        for (name, value) in FLOATS {
            _ = writeln!(text, "const {name}: f32 = {:?};", value as f32);
        }
        for (name, value) in NUMBERS {
            _ = writeln!(text, "const {name}: u32 = {value}u;");
        }
        text
    });
    &TEXT
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every constant, as a shader reads it.
    #[test]
    fn shaders_read_the_bits_of_rust() {
        let module = naga::front::wgsl::parse_str(text()).unwrap();
        let value = |name: &str| {
            let (_, found) = module.constants.iter().find(|c| c.1.name.as_deref() == Some(name)).unwrap();
            match module.global_expressions[found.init] {
                naga::Expression::Literal(literal) => literal,
                ref other => panic!("{name}: {other:?}"),
            }
        };
        for (name, expected) in FLOATS {
            assert_eq!(value(name), naga::Literal::F32(expected as f32), "{name}");
        }
        for (name, expected) in NUMBERS {
            assert_eq!(value(name), naga::Literal::U32(expected as u32), "{name}");
        }
    }
}
