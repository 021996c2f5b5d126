//! Passes that reach no farther than the next row, as one walk down the sheet.
//!
//! Each follows the one before it as closely as it can: it takes a row, or two, once that one is done with them. So a row
//! is read from memory once for all passes, and not once for each. The results are those of pass after pass, bit for bit:
//! every row sees the same passes in the same order, and so do the rows beside it.

use super::anchors::Anchors;
use super::integrate_rows;
use super::stretch::{Spring, Springs};
use super::tethers::{Rows, Tethers};
use crate::cpu::integrate::Air;
use crate::cpu::sheet::Sheet;
use crate::number::lanes::{Machine, Work, widest};
use crate::number::real::Real;
use crate::step::Step;

/// A pass of a sheet.
pub enum Stage<'a, T: Real> {
    /// A step, in air that moves or is still.
    Integrate(&'a Step<T>, Air<'a, T>),
    /// Tethers, and where their anchors are.
    Tethers(&'a Tethers<T>, Anchors<'a, T>),
    /// Hard springs of a direction and parity, of a round of polish or not.
    Springs(&'a Springs<T>, (u32, u32), bool),
}

/// Bytes of rows that are taken up in one go. With those that lie between the first pass and the last they should fit into
/// what is nearest to a core.
const NEAREST: usize = 28 << 10;

/// Runs all passes on the caller's thread.
pub fn run<T: Real>(sheet: &mut Sheet<T>, stages: &[Stage<T>]) {
    // Coordinates now and before, and a weight.
    let bytes = 7 * sheet.width * size_of::<T>();
    let together = (NEAREST / bytes).max(2).next_multiple_of(2);
    let bound = |stage: &Stage<T>| matches!(stage, Stage::Springs(springs, ..) if springs.bound > T::of(0.0));
    if stages.iter().any(bound) {
        widest(Walk::<_, true> { sheet, stages, together });
    } else {
        widest(Walk::<_, false> { sheet, stages, together });
    }
}

/// Hard springs with bounds or without: together, they would be slower than either.
struct Walk<'a, 'b, T: Real, const BOUND: bool> {
    sheet: &'b mut Sheet<T>,
    stages: &'a [Stage<'a, T>],
    together: usize,
}

impl<T: Real, const BOUND: bool> Work<T> for Walk<'_, '_, T, BOUND> {
    #[inline(always)]
    fn run<K: Machine<T>>(self, k: K) {
        let (size, row) = ((self.sheet.width, self.sheet.half), self.sheet.row());
        let Sheet { now, before, w, alike, height, half, .. } = self.sheet;
        let (height, half) = (*height, *half);
        // Of each pass the springs, and the first row that it has not taken.
        let states = self.stages.iter().map(|stage| stage.start(size, alike));
        let mut states: Vec<_> =
            states.map(|(spring, first)| (spring.map(|s| if BOUND { s.bounded() } else { s }), first)).collect();
        let mut taken = 0;
        while taken < height {
            taken = (taken + self.together).min(height);
            // Rows that the pass before is done with.
            let mut ready = taken;
            for (stage, (spring, next)) in self.stages.iter().zip(&mut states) {
                match (stage, spring) {
                    (Stage::Integrate(step, air), _) => {
                        let part = *next * row..ready * row;
                        let (now, before) = (&mut now[part.clone()], &mut before[part]);
                        match air {
                            Air::None => integrate_rows::still(k, step, now, before, size, (w, *next)),
                            air => integrate_rows::moving(step, now, before, size, (w, *next), *air),
                        }
                        *next = ready;
                    }
                    (Stage::Tethers(held, anchors), _) => {
                        // Not a part of this function: with the code of tethers in it, springs are slower.
                        let rows = &mut now[*next * row..ready * row];
                        widest(Rows { rows, size, w, first: *next * 2 * half, tethers: held, anchors });
                        *next = ready;
                    }
                    (Stage::Springs(_, (0, parity), _), Some(spring)) => {
                        for j in *next..ready {
                            spring.hard::<K, BOUND>(k, &mut now[j * row..(j + 1) * row], w, j, (0, *parity as usize));
                        }
                        *next = ready;
                    }
                    (Stage::Springs(_, (direction, parity), _), Some(spring)) => {
                        while *next + 2 <= ready {
                            let rows = &mut now[*next * row..(*next + 2) * row];
                            spring.hard::<K, BOUND>(k, rows, w, *next, (*direction, *parity as usize));
                            *next += 2;
                        }
                        // A row without another one below is done with too.
                        ready = if ready == height { height } else { ready.min(*next) };
                    }
                    (Stage::Springs(..), None) => {}
                }
            }
        }
    }
}

impl<'a, T: Real> Stage<'a, T> {
    fn start(&self, size: (usize, usize), alike: &'a [T]) -> (Option<Spring<'a, T>>, usize) {
        match self {
            Stage::Springs(springs, (direction, parity), over) => {
                (Some(Spring::of(size, alike, springs).over(*over)), if *direction == 0 { 0 } else { *parity as usize })
            }
            _ => (None, 0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloth::Grid;
    use crate::cpu::fabric::stretch::{self, Rests};
    use crate::cpu::fabric::tethers::{self, Slot};
    use crate::cpu::rows::Threads;
    use crate::number::aligned::Aligned;
    use std::sync::Arc;

    use crate::cpu::sheet::Values;

    fn sheet(width: u32, height: u32) -> Sheet<f32> {
        let mut sheet = Sheet::new(&Grid { name: String::new(), first: 0, width, height });
        let noise = |k: usize| ((k * 7919) % 1009) as f32 / 1009.0 - 0.5;
        for k in 0..sheet.width * sheet.height {
            let (i, j) = (k % sheet.width, k / sheet.width);
            let at = [i as f32 + 0.3 * noise(k), 0.3 * noise(k + 1), j as f32 + 0.3 * noise(k + 2)];
            sheet.put(sheet.triple(k), at);
        }
        let now = sheet.now.clone();
        sheet.before.iter_mut().zip(&*now).for_each(|(b, x)| *b = 0.99 * x);
        // A pin, a heavy one, and a row of other weight than those beside it.
        sheet.weigh(|k| match (k, k / width as usize) {
            (0, _) => 0.0,
            (20, _) => 1.0,
            (_, 5) => 7.0,
            _ => 5.0,
        });
        sheet
    }

    #[test]
    fn one_walk_gives_the_bits_of_pass_after_pass() {
        let threads = Threads::one();
        let step =
            Step { gravity: [0.0, -9.81, 0.0], keep: 0.9, scale: 1e-4, longest: 1e6, dt: 0.01, ..Step::default() };
        let sizes = [(2, 2), (3, 9), (9, 3), (31, 33), (32, 64), (33, 31), (70, 200), (300, 41)];
        // Diagonals of one direction without a bound, those of the other with one: they go together too.
        let bounds = [[0.0; 4], [0.01; 4], [0.0, 0.0, 0.01, 0.0]];
        let step = Step { wind: [3.0, 0.0, 1.0], rate: 100.0, response: 0.8, ..step };
        let cases = sizes.into_iter().flat_map(|s| bounds.map(|b| (s, b))).enumerate();
        for (n, ((width, height), bounds)) in cases {
            let (mut together, mut apart) = (sheet(width, height), sheet(width, height));
            let moving: Vec<f32> = together.now.iter().map(|x| 5.0 * x.sin()).collect();
            let air = [Air::None, Air::Field(&moving), Air::Push][n % 3];
            let list = Rests::List(Arc::new(together.list(0.0, |k| 0.8 + 0.001 * (k % 100) as f32)));
            let [right, diagonal] = [0.9f32, 1.3].map(|rest| move |sheet| Rests::constant(sheet, rest));
            let rest = [right(&together), list, diagonal(&together), diagonal(&together)];
            let mut bounds = bounds.into_iter();
            let mut springs = rest.map(|rest| stretch::Springs {
                rest,
                soft: Values::Constant(0.0),
                sums: Vec::new(),
                bound: bounds.next().unwrap(),
            });
            let far = |k: usize| Some((0, (k % width as usize) as f32 + (k / width as usize) as f32));
            let held = Tethers { slots: vec![Slot::new(&together, far)] };
            let at = [together.at(0)];
            let anchors = Anchors { at: &at, planes: &[Aligned::default()] };
            let colours = [(2, 0), (2, 1), (3, 0), (3, 1), (0, 0), (0, 1), (1, 0), (1, 1)];
            integrate_rows::run(&threads, &step, &mut apart, air, false);
            tethers::run(&threads, &mut apart, &held, &anchors);
            for colour in colours {
                stretch::run(&threads, &mut apart, &mut springs[colour.0 as usize], colour, false, step.dt);
            }
            tethers::run(&threads, &mut apart, &held, &anchors);
            let all = colours.map(|colour| Stage::Springs(&springs[colour.0 as usize], colour, false));
            let mut stages = vec![Stage::Integrate(&step, air), Stage::Tethers(&held, anchors)];
            stages.extend(all);
            stages.push(Stage::Tethers(&held, anchors));
            run(&mut together, &stages);
            assert!(together.now[..] == apart.now[..] && together.before[..] == apart.before[..], "{width} x {height}");
            assert!(together.now[..] != sheet(width, height).now[..]);
        }
    }
}
