//! The options with all that they leave open decided.

use std::ops::Deref;

use super::{Choice, Support, choose, give, need, spanned};
use crate::cloth::Cloth;
use crate::options::Options;
use crate::scene::Scene;

/// Slack of tethers to a row of pins: more than springs yield there, so that tethers hold only what tears.
const ROW_SLACK: f32 = 1.03;
/// Such tethers per particle, and those to groups of pins on a line: further ones take a tenth of a frame, and hold nothing.
const ROW_TETHERS: u32 = 1;
const LINE_TETHERS: u32 = 2;

/// Extension of cloth with a compliance, or of a spanned fabric, beyond which tethers alone hold it: such springs do not come to rest.
const MAX_GIVE: f64 = 1.0;

/// How the tethers of a cloth are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Most tethers per particle.
    pub most: u32,
    /// Length of a tether over the distance along the surface: above 1 where springs do without tethers, which shorten the
    /// lengths that they swing on, and slow down a swing.
    pub slack: f32,
}

/// The options, with all that they leave open decided.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    given: Options,
    /// Steps per [`Options::step`].
    pub substeps: u32,
    /// Rounds of polish.
    pub polish: u32,
    /// How the tethers of each cloth are made.
    pub hold: Vec<Hold>,
}

impl Deref for Settings {
    type Target = Options;

    fn deref(&self) -> &Options {
        &self.given
    }
}

impl Settings {
    /// Relaxations of a step, rounds of polish included.
    pub fn relaxations(&self) -> u32 {
        self.iterations.saturating_mul(self.polish + 1)
    }

    /// Decides what `given` leaves open.
    pub fn new(given: Options, scene: &Scene) -> (Self, Choice) {
        let choice = choose(&given, scene);
        let row = |c: &Cloth| choice.given == [false; 2] && need(c, &given, scene).support == Support::TetheredRow;
        // A tether is as long as the path along the surface when that gives. Cloth that is too soft to hold itself is held by tethers.
        let hold = |c: &Cloth| {
            let span = spanned::span(c);
            let sags = span.map_or(0.0, |span| spanned::give(c, scene.gravity, span));
            let gives = [give::at_pins(c, scene.gravity), sags].into_iter().filter(|g| *g <= MAX_GIVE);
            let slack = (1.0 + gives.sum::<f64>()) as f32;
            match span {
                _ if row(c) => Hold { most: given.tethers.min(ROW_TETHERS), slack: ROW_SLACK * slack },
                None => Hold { most: given.tethers.min(LINE_TETHERS), slack },
                Some(_) => Hold { most: given.tethers, slack },
            }
        };
        let hold = scene.cloths.iter().map(hold).collect();
        (Settings { substeps: choice.substeps, polish: choice.polish, hold, given }, choice)
    }

    /// The options as the host gave them.
    pub fn given(&self) -> &Options {
        &self.given
    }
}
