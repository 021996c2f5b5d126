//! Counts the triangles of cloth that cross at the end of a run.
//!
//! Without contact nothing keeps layers apart, and no pass looks for them.

use std::collections::BTreeMap;

use gimage_runtime::crossings::{self, Crossings, Drawn};
use gimage_runtime::{ContactTier, Scene};
use serde_json::{Value, json};

use crate::commands::engine::Engine;
use crate::exit::Failure;

/// Deepest pairs that pieces are named by.
const LISTED: usize = 1024;

/// The crossings of all cloths of a scene.
#[derive(Debug, Default)]
pub struct Crossed {
    /// At the end, with the deepest pairs.
    end: Crossings,
    /// Pairs that cross where the cloths start; not known where none cross at the end.
    start: Option<u64>,
    /// The reason if they were not counted.
    problem: Option<String>,
}

impl Crossed {
    /// Those of an engine as it is now. Cloth that is too large for the lists is not counted, which ends no run.
    pub fn at_end(engine: &Engine) -> Result<Self, Failure> {
        let cloths = &engine.stepper.scene().cloths;
        let each = (0..cloths.len()).map(|cloth| Ok((engine.positions(cloth)?, engine.holes(cloth)?)));
        let each = each.collect::<Result<Vec<_>, Failure>>()?;
        let drawn = cloths.iter().zip(&each).map(|(cloth, (now, holes))| Drawn {
            holes: Some(&holes[..]).filter(|holes| !holes.is_empty()),
            ..Drawn::at(cloth, now)
        });
        let count = || -> gimage_runtime::Result<Self> {
            let end = crossings::find(&drawn.collect::<Vec<_>>(), LISTED)?;
            let start = match end.total() {
                0 => None,
                _ => Some(crossings::find(&cloths.iter().map(Drawn::new).collect::<Vec<_>>(), 0)?.total()),
            };
            Ok(Crossed { end, start, problem: None })
        };
        Ok(count().unwrap_or_else(|error| Crossed { problem: Some(error.to_string()), ..Crossed::default() }))
    }

    /// A sentence for it; none if no more triangles cross than where the cloth starts.
    pub fn words(&self, scene: &Scene) -> Option<String> {
        if let Some(problem) = &self.problem {
            return Some(format!("triangles that cross at the end were not counted: {problem}"));
        }
        let (pairs, start) = (self.end.total(), self.start?);
        if pairs <= start {
            return None;
        }
        let [a, b] = self.pieces()?;
        let name = |(cloth, grid): (usize, usize)| Some(scene.cloths.get(cloth)?.grids().get(grid)?.name.as_str());
        let places =
            if a == b { format!("of '{}'", name(a)?) } else { format!("of '{}' and '{}'", name(a)?, name(b)?) };
        let before = if start > 0 { format!(" ({start} where the cloth starts)") } else { String::new() };
        let tier = |(cloth, _): (usize, usize)| scene.cloths.get(cloth)?.contact.as_ref().map(|contact| contact.tier);
        let hint = match [tier(a), tier(b)] {
            [Some(ContactTier::Safe), Some(ContactTier::Safe)] => "",
            [Some(_), Some(_)] => ": contact of the tier particles makes no promise; --contact safe does",
            _ => {
                ": cloth has no contact with cloth; --contact particles pushes layers apart, --contact safe also lets none pass through another"
            }
        };
        let pairs =
            if pairs == 1 { "1 pair of triangles crosses".into() } else { format!("{pairs} pairs of triangles cross") };
        let depth = 1e3 * self.end.deepest;
        Some(format!("{pairs} at the end{before}, by at most {depth:.2} mm, the deepest mostly {places}{hint}"))
    }

    /// The pieces, as cloth and grid, that most of the deepest pairs are of; the first of those with as many.
    fn pieces(&self) -> Option<[(usize, usize); 2]> {
        let mut counts = BTreeMap::new();
        for pair in &self.end.worst {
            let pieces = [&pair.first, &pair.second].map(|place| (place.cloth, place.grid));
            *counts.entry(pieces).or_insert(0_u32) += 1;
        }
        counts.into_iter().rev().max_by_key(|(_, count)| *count).map(|(pieces, _)| pieces)
    }

    /// The same for `--json`.
    pub fn json(&self) -> Value {
        let Crossings { within, between, deepest, .. } = &self.end;
        json!({"within": within, "between": between, "deepest_m": deepest, "start": self.start, "problem": self.problem})
    }
}
