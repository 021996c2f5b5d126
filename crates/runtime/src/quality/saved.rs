//! The state of a choice as a list of numbers, for save games.

use super::Mix;

/// How many numbers a chooser has.
pub const NUMBERS: usize = 40;

/// Numbers that are written down or taken over, one after the other.
pub enum Numbers<'a> {
    /// Writes them at the end of a list.
    To(&'a mut Vec<f64>),
    /// Takes them from a list; NaN where it has ended.
    From(std::slice::Iter<'a, f64>),
}

impl Numbers<'_> {
    pub(super) fn number(&mut self, x: &mut f64) {
        match self {
            Numbers::To(list) => list.push(*x),
            Numbers::From(list) => *x = list.next().copied().unwrap_or(f64::NAN),
        }
    }

    pub(super) fn flag(&mut self, on: &mut bool) {
        let mut x = f64::from(u8::from(*on));
        self.number(&mut x);
        *on = x > 0.0;
    }

    /// A value made of numbers, which are NaN where there is none.
    pub(super) fn option<T, const N: usize>(
        &mut self,
        value: &mut Option<T>,
        to: impl Fn(&T) -> [f64; N],
        from: impl Fn([f64; N]) -> T,
    ) {
        let mut all = value.as_ref().map_or([f64::NAN; N], to);
        all.iter_mut().for_each(|x| self.number(x));
        *value = all.iter().all(|x| x.is_finite()).then(|| from(all));
    }

    pub(super) fn known(&mut self, x: &mut Option<f64>) {
        self.option(x, |x| [*x], |[x]| x);
    }
}

/// Largest number of substeps or rounds that is taken over.
const MOST: f64 = 4096.0;

impl Mix {
    pub(super) fn numbers(self) -> [f64; 2] {
        [f64::from(self.substeps), f64::from(self.rounds)]
    }

    pub(super) fn of([substeps, rounds]: [f64; 2]) -> Self {
        Mix { substeps: substeps.clamp(1.0, MOST) as u32, rounds: rounds.clamp(0.0, MOST) as u32 }
    }
}
