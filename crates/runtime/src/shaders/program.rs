//! The calls of a program: rounds as loops, and colours as loops.

use std::fmt::Write;

use super::rule::{Over, rule};
use crate::fold::{Run, fold};
use crate::passes::Pass;

/// Calls of a list of passes. `call` gives the lines of one, from what its loop is told beside the thread.
pub fn calls(passes: &[Pass], call: impl Fn(&Pass, &str) -> String) -> String {
    let (mut text, mut once) = (String::new(), Vec::new());
    for run in fold(passes) {
        match run {
            Run::Once(pass) => once.push(*pass),
            Run::Times(n, part) => {
                text += &lines(&std::mem::take(&mut once), &call);
                _ = write!(text, "  for (var turn = 0u; turn < {n}u; turn++) {{\n{}  }}\n", lines(part, &call));
            }
        }
    }
    text + &lines(&once, &call)
}

/// Most colours in a loop: four bits each.
const COLOURS: usize = 8;

/// Calls one after the other. Colours of a rule are one call in a loop: compilers inline every call, and a whole frame would hold its
/// springs twenty times.
fn lines(passes: &[Pass], call: impl Fn(&Pass, &str) -> String) -> String {
    let alike = |a: &Pass, b: &Pass| match (rule(*a), rule(*b)) {
        (a, b) if a.call == b.call => {
            colour(a.over).is_some() && std::mem::discriminant(&a.over) == std::mem::discriminant(&b.over)
        }
        _ => false,
    };
    let mut text = String::new();
    for run in passes.chunk_by(alike).flat_map(|run| run.chunks(COLOURS)) {
        let colours: Vec<_> = run.iter().filter_map(|pass| colour(rule(*pass).over)).collect();
        match colours[..] {
            [] => run.iter().for_each(|pass| text += &call(pass, "")),
            [[a, b]] => text += &call(&run[0], &format!(", {a}u, {b}u")),
            _ => {
                let packed = colours.iter().rev().fold(0, |all, [a, b]| all << 4 | a << 1 | b);
                let one = call(&run[0], ", colour >> 1u, colour & 1u");
                let n = colours.len();
                _ = write!(
                    text,
                    "  for (var at = 0u; at < {n}u; at++) {{\n  let colour = ({packed:#x}u >> (4u * at)) & 15u;\n{one}  }}\n"
                );
            }
        }
    }
    text
}

/// The colour of a loop, if it has any: two numbers, the second below 2.
fn colour(over: Over) -> Option<[u32; 2]> {
    match over {
        Over::Springs { direction: a, parity: b } | Over::Cells { column: a, row: b } => Some([a, b]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_a_loop_and_keep_their_order() {
        let polish = |direction, parity| Pass::Polish { direction, parity, image: false };
        let passes = [Pass::Seams, polish(1, 1), polish(0, 0), Pass::Seams, polish(3, 1)];
        let text = calls(&passes, |pass, colour| format!("  {}{colour};\n", rule(*pass).call));
        let loop_of_two = "  for (var at = 0u; at < 2u; at++) {\n  let colour = (0x3u >> (4u * at)) & 15u;\n  polish, colour >> 1u, colour & 1u;\n  }\n";
        let expected = format!("  close;\n{loop_of_two}  close;\n  polish, 3u, 1u;\n");
        assert_eq!(text, expected);
    }
}
