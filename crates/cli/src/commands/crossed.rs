//! Counts the triangles of cloth that cross at the end of a run: without contact nothing keeps layers apart, and no pass looks for them.

use std::collections::BTreeMap;

use gimage_runtime::crossings::{self, Crossings, Drawn, Place};
use gimage_runtime::{Cloth, ContactTier, Scene};
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
    /// Pairs that cross where the cloths start; not counted where none cross at the end.
    start: u64,
}

impl Crossed {
    /// Those of an engine as it is now.
    pub fn at_end(engine: &Engine) -> Result<Self, Failure> {
        let cloths = &engine.stepper.scene().cloths;
        let each = (0..cloths.len()).map(|cloth| Ok((engine.positions(cloth)?, engine.holes(cloth)?)));
        let each = each.collect::<Result<Vec<_>, Failure>>()?;
        let drawn = cloths.iter().zip(&each).map(|(cloth, (now, holes))| Drawn {
            holes: Some(&holes[..]).filter(|holes| !holes.is_empty()),
            ..Drawn::at(cloth, now)
        });
        let end = crossings::find(&drawn.collect::<Vec<_>>(), LISTED)?;
        let start = match end.total() {
            0 => 0,
            _ => crossings::find(&cloths.iter().map(Drawn::new).collect::<Vec<_>>(), 0)?.total(),
        };
        Ok(Crossed { end, start })
    }

    /// Words for it; none if no triangles cross.
    pub fn words(&self, scene: &Scene) -> Option<String> {
        let (pairs, start) = (self.end.total(), self.start);
        let places = match self.pieces(scene)? {
            (a, b) if a == b => format!("of '{a}'"),
            (a, b) => format!("of '{a}' and '{b}'"),
        };
        let before = if start > 0 { format!(" ({start} where the cloth starts)") } else { String::new() };
        let has = |tier| move |cloth: &Cloth| cloth.contact.as_ref().is_some_and(|contact| contact.tier == tier);
        let hint = if scene.cloths.iter().any(has(ContactTier::Particles)) {
            ": contact of the tier particles makes no promise; --contact safe does"
        } else if scene.cloths.iter().any(has(ContactTier::Safe)) {
            ""
        } else {
            ": cloth has no contact with cloth; --contact particles pushes layers apart, --contact safe lets none cross"
        };
        let depth = 1e3 * self.end.deepest;
        Some(format!(
            "{pairs} pairs of triangles cross at the end{before}, by at most {depth:.2} mm, most of them {places}{hint}"
        ))
    }

    /// The pieces that most of the deepest pairs are of, the first by name of those with as many.
    fn pieces<'a>(&self, scene: &'a Scene) -> Option<(&'a str, &'a str)> {
        let name = |place: &Place| Some(scene.cloths.get(place.cloth)?.grids().get(place.grid)?.name.as_str());
        let mut counts = BTreeMap::new();
        for pair in &self.end.worst {
            *counts.entry((name(&pair.first)?, name(&pair.second)?)).or_insert(0_u32) += 1;
        }
        counts.into_iter().rev().max_by_key(|(_, count)| *count).map(|(names, _)| names)
    }

    /// The same for `--json`.
    pub fn json(&self) -> Value {
        let Crossings { within, between, deepest, .. } = &self.end;
        json!({"within": within, "between": between, "deepest_m": deepest, "start": self.start})
    }
}
