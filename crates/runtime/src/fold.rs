//! Lists of passes with what repeats written once.

use crate::passes::Pass;

/// A part of a list of passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Run<'a> {
    /// A pass.
    Once(&'a Pass),
    /// The same passes several times in a row.
    Times(u32, &'a [Pass]),
}

/// Longest part that is looked for as a repetition.
const LONGEST: usize = 16;

/// A list with what repeats in a row written once, so that a shader has it as a loop: rounds of polish, above all.
pub fn fold(passes: &[Pass]) -> Vec<Run<'_>> {
    let (mut runs, mut at) = (Vec::new(), 0);
    while at < passes.len() {
        let left = &passes[at..];
        let times = |n: usize| left.chunks_exact(n).take_while(|chunk| *chunk == &left[..n]).count();
        let saves = |n: &usize| (times(*n) - 1) * n;
        // Of the parts that save most the shortest.
        match (1..=LONGEST.min(left.len())).rev().max_by_key(saves).filter(|n| times(*n) > 1) {
            Some(n) => {
                runs.push(Run::Times(times(n) as u32, &left[..n]));
                at += n * times(n);
            }
            None => {
                runs.push(Run::Once(&left[0]));
                at += 1;
            }
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_are_written_once() {
        let (a, b, c) = (Pass::Seams, Pass::Bend, Pass::Guard);
        let whole = [a, b, b, c, a, c, a, c, a, b];
        let runs = fold(&whole);
        let expected = [Run::Once(&a), Run::Times(2, &[b]), Run::Times(3, &[c, a]), Run::Once(&b)];
        assert_eq!(runs, expected);
        let flat = |run: &Run| match *run {
            Run::Once(pass) => vec![*pass],
            Run::Times(n, part) => part.repeat(n as usize),
        };
        assert_eq!(runs.iter().flat_map(flat).collect::<Vec<_>>(), whole);
        assert_eq!(fold(&[]), []);
    }
}
