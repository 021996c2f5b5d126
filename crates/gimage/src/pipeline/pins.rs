//! The pins of a build: those of the flags, of the file, and where garments rest on the body.

use std::path::Path;

use crate::base::mesh::{Channel, Mesh, Semantic};
use crate::error::{Error, Result};
use crate::options::BuildOptions;
use crate::record::{Finding, Severity};
use crate::stage::assemble::limits;
use crate::stage::assemble::pins::{ATTRIBUTE, PINS_ABOVE, Pin, PinRule};
use crate::stage::assemble::{Family, Piece};
use crate::stage::colliders::body;
use crate::stage::hold::{Held, Wearer, hold};
use crate::stage::select::keeping;

/// Share of the height of each garment that [`crate::pipeline::dress`] pins without a body and other pins: a collar, a waistband.
pub const PINNED_TOP: f64 = 0.06;

/// The pins of a build, before there are pieces.
pub(super) struct Plan {
    /// The options, with the pins of the file and the rule that applies.
    pub options: BuildOptions,
    /// The findings about them.
    pub findings: Vec<Finding>,
    wearer: Option<Wearer>,
}

/// The body in an imported mesh, where the options may need it. `dressed`: for [`crate::pipeline::dress`].
///
/// Errors: as [`crate::colliders::fit_colliders`] for patterns of `--body`.
pub(super) fn worn_on(mesh: &Mesh, options: &BuildOptions, dressed: bool) -> Result<Option<Mesh>> {
    let rule = options.assemble.rule;
    if rule != Some(PinRule::Auto) && !(dressed && rule.is_none()) {
        return Ok(None);
    }
    let parts = body(mesh, options, true)?;
    Ok(parts.contains(&true).then(|| keeping(mesh.clone(), &parts)))
}

impl Plan {
    /// From the mesh that becomes cloth, and the body.
    ///
    /// Errors: [`Error::Option`] where `--pins auto` finds no body.
    pub fn new(path: &Path, mesh: &Mesh, body: Option<&Mesh>, options: &BuildOptions, dressed: bool) -> Result<Self> {
        let mut plan = Plan { options: options.clone(), findings: Vec::new(), wearer: None };
        let assemble = &mut plan.options.assemble;
        let wearer = body.and_then(Wearer::new);
        let is_painted = mesh.channel(&Semantic::Custom(ATTRIBUTE.into())).is_some_and(pins);
        let is_free = dressed && assemble.rule.is_none() && assemble.pins.is_empty() && !is_painted;
        let asked = assemble.rule == Some(PinRule::Auto);
        match (asked || is_free, wearer) {
            (true, Some(wearer)) => {
                assemble.rule = Some(PinRule::Auto);
                plan.wearer = Some(wearer);
            }
            (true, None) if asked => {
                return Err(Error::Option {
                    option: "pins".into(),
                    problem: format!("auto needs a body, and no part of {} looks like one", path.display()),
                    hint: "choose its parts with --body (`gimage list` shows their names), or pin with --pin".into(),
                });
            }
            (true, None) => {
                assemble.pins.push(Pin::Top(PINNED_TOP));
                let top = 100.0 * PINNED_TOP;
                let message =
                    format!("Without a body, --pin and an attribute _PIN, the top {top} % of each garment are pinned.");
                plan.findings.push(hint("hint-pins", message));
            }
            (false, _) => {}
        }
        let painted = Pin::Attribute(ATTRIBUTE.into(), PINS_ABOVE);
        if is_painted && assemble.rule != Some(PinRule::Flags) && !assemble.pins.contains(&painted) {
            assemble.pins.push(painted);
            let message = format!(
                "The attribute {ATTRIBUTE} of the file pins particles where it is above {PINS_ABOVE}; --pins flags ignores it."
            );
            plan.findings.push(hint("hint-painted", message));
        }
        let limits =
            limits::ATTRIBUTES.iter().filter(|name| mesh.channel(&Semantic::Custom((**name).into())).is_some());
        for name in limits {
            let message = format!("The attribute {name} of the file limits particles where it is not negative.");
            plan.findings.push(hint("hint-painted", message));
        }
        Ok(plan)
    }

    /// Whether garments are pinned where they rest on the body.
    pub fn is_automatic(&self) -> bool {
        self.wearer.is_some()
    }

    /// The pins and limits of each piece where garments rest on the body; none without the rule. Adds the
    /// findings about them.
    pub fn hold(&self, pieces: &[Piece<'_>], families: &[Family<'_>], findings: &mut Vec<Finding>) -> Vec<Held> {
        let Some(wearer) = &self.wearer else { return Vec::new() };
        let holds = hold(wearer, pieces, families);
        findings.extend(holds.findings());
        holds.pieces
    }
}

/// Whether any value of a channel pins.
fn pins(channel: &Channel) -> bool {
    channel.values.chunks(channel.width.max(1)).any(|v| v.first().is_some_and(|x| f64::from(*x) > PINS_ABOVE))
}

fn hint(kind: &'static str, message: String) -> Finding {
    Finding { severity: Severity::Note, stage: "maps", kind, count: 1, examples: Vec::new(), message }
}
