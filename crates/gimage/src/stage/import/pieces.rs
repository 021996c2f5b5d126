//! Keeps the pieces asked for by name.

use std::collections::HashSet;

use crate::base::mesh::Part;
use crate::error::{Error, Result};

/// How many names an error lists.
const LISTED: usize = 30;

/// Which parts to keep, and which names have been seen.
pub(crate) struct Selector<'a> {
    wanted: &'a [String],
    met: Vec<bool>,
    seen: HashSet<String>,
    names: Vec<String>,
}

impl<'a> Selector<'a> {
    pub fn new(wanted: &'a [String]) -> Self {
        Self { wanted, met: vec![false; wanted.len()], seen: HashSet::new(), names: Vec::new() }
    }

    /// Whether to keep a part; every part of the file must be asked for.
    pub fn keeps(&mut self, part: &Part) -> bool {
        let mut kept = self.wanted.is_empty();
        for name in [&part.node, &part.mesh, &part.material] {
            for (met, _) in self.met.iter_mut().zip(self.wanted).filter(|(_, w)| *w == name) {
                (*met, kept) = (true, true);
            }
            if !name.is_empty() && self.names.len() <= LISTED && self.seen.insert(name.clone()) {
                self.names.push(name.clone());
            }
        }
        kept
    }

    /// Refuses names that were nowhere in the file.
    pub fn finish(self) -> Result<()> {
        let Some(name) = self.met.iter().zip(self.wanted).find_map(|(met, w)| (!met).then_some(w)) else {
            return Ok(());
        };
        let mut list = self.names.iter().take(LISTED).map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
        if self.names.len() > LISTED {
            list.push_str(", ...");
        }
        Err(Error::Option {
            option: "piece".into(),
            problem: format!("no node, mesh or material is named `{name}`"),
            hint: if list.is_empty() { "the file names none".into() } else { format!("choose from {list}") },
        })
    }
}
