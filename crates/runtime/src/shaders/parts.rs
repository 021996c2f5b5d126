//! Files, bindings and constants of a shader, each once.

use super::Slot;

/// A slot and whether the shader writes to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Bound {
    pub slot: Slot,
    pub writes: bool,
}

pub const fn reads(slot: Slot) -> Bound {
    Bound { slot, writes: false }
}

pub const fn writes(slot: Slot) -> Bound {
    Bound { slot, writes: true }
}

/// Components of a rule or a shader.
#[derive(Clone, Debug, Default)]
pub struct Parts {
    pub files: Vec<&'static str>,
    pub bindings: Vec<Bound>,
    pub constants: Vec<(&'static str, f64)>,
}

impl Parts {
    pub fn new(files: &[&'static str], read: &[Slot], write: &[Slot]) -> Self {
        let bindings = read.iter().map(|s| reads(*s)).chain(write.iter().map(|s| writes(*s))).collect::<Vec<_>>();
        Parts::default().files(files).bind(&bindings)
    }

    pub fn files(mut self, files: &[&'static str]) -> Self {
        for file in files {
            if !self.files.contains(file) {
                self.files.push(file);
            }
        }
        self
    }

    /// Binds what is not bound yet; who writes to a slot reads it too.
    pub fn bind(mut self, bindings: &[Bound]) -> Self {
        for bound in bindings {
            match self.bindings.iter_mut().find(|b| b.slot == bound.slot) {
                Some(there) => there.writes |= bound.writes,
                None => self.bindings.push(*bound),
            }
        }
        self
    }

    pub fn constant(self, name: &'static str, value: u32) -> Self {
        self.number(name, f64::from(value))
    }

    pub fn number(mut self, name: &'static str, value: f64) -> Self {
        if self.constants.iter().all(|c| c.0 != name) {
            self.constants.push((name, value));
        }
        self
    }

    /// Both.
    pub fn and(self, other: Parts) -> Self {
        let both = self.files(&other.files).bind(&other.bindings);
        other.constants.into_iter().fold(both, |parts, (name, value)| parts.number(name, value))
    }

    /// How a slot is bound.
    pub fn bound(&self, slot: Slot) -> Option<Bound> {
        self.bindings.iter().find(|b| b.slot == slot).copied()
    }

    pub fn binds(&self, slot: Slot) -> bool {
        self.bound(slot).is_some()
    }
}
