//! Limits of one relaxation per step in f32: settings beyond them are adjusted, with a warning.

mod lengths;
mod masses;

pub use lengths::MOST_LENGTHS;
pub use masses::MOST_RATIO;

use crate::choose::{Settings, bend};
use crate::cloth::{Cloth, Compliance, Rest, shear};
use crate::error::Result;
use crate::levels::pins;
use crate::options::Solver;
use crate::passes::has_levels;

/// Longest step \[s\] of [`Solver::Xpbd`]: in a longer one cloth falls too far for tethers to hold it.
pub const LONGEST: f64 = 1.0 / 60.0;
/// Longest step \[s\] of cloth without tethers: in a longer one springs alone tremble, and soft ones gain energy.
pub const LONGEST_FREE: f64 = 1.0 / 120.0;
/// In shorter steps \[s\] damping and gravity move particles by so few units in the last place that rounding counts.
const SHORT: f64 = 1e-3;
/// Where a unit in the last place a step is faster than this \[m/s\], keeping what rounding takes does more harm than good.
const COARSE: f64 = 2e-3;
/// Tethers of a particle where springs alone will not do.
const GIVEN: u32 = 2;
/// Cloth that bends more easily than its material by this factor hangs differently.
const LIMP: f64 = 2.0;

/// A setting beyond the limits of the solver, which the stepper adjusted, or keeps but handles poorly.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// Particles joined by a spring differed in mass by more than one relaxation a step can even out: the lighter ones
    /// were made heavier, and a particle far heavier than all around it lighter.
    #[error(
        "cloth {cloth}: neighbouring particles differ by a factor of up to {ratio:.1e} in mass; {particles} masses were \
         changed to limit the factor to {limit}, which springs can hold: make the masses more even"
    )]
    Masses {
        /// The cloth by name.
        cloth: String,
        /// Particles whose mass was changed.
        particles: usize,
        /// The largest mass over that of a neighbour, as given.
        ratio: f64,
        /// The largest that is left.
        limit: f64,
    },
    /// Cloth hung by springs alone, whose masses or rest lengths are too uneven for that: it is held by tethers too.
    #[error(
        "cloth {cloth}: neighbours differ by a factor of {masses:.1e} in mass and {lengths:.1e} in rest length, which springs \
         alone do not hold: {given} tethers per particle were added; request tethers, or make the cloth more even"
    )]
    Tethers {
        /// The cloth by name.
        cloth: String,
        /// Tethers per particle.
        given: u32,
        /// The largest mass over that of a neighbour, as given.
        masses: f64,
        /// The largest rest length over that of the next spring in its row or column.
        lengths: f64,
    },
    /// Grids that no pin holds, and no seam or stitch ties to one that is held.
    #[error(
        "cloth {cloth}: nothing holds {}{}: no pin, and no seam or stitch to a piece that is held: pin them, or build the bundle with a \
         larger --stitch",
        names.iter().take(4).cloned().collect::<Vec<_>>().join(", "),
        if names.len() > 4 { format!(" and {} more pieces", names.len() - 4) } else { String::new() }
    )]
    Loose {
        /// The cloth by name.
        cloth: String,
        /// The grids by name.
        names: Vec<String>,
    },
    /// All pins are at one point: nothing keeps the cloth from turning about it. The residual of sequential relaxations turns
    /// it, by some centimetres a second at 8 substeps in 1/60 s, and the less the shorter steps are.
    #[error(
        "cloth {cloth} hangs from one point and can turn about it: it does not come to rest; pin it at two distant points, \
         or use more substeps"
    )]
    Turns {
        /// The cloth by name.
        cloth: String,
    },
    /// The classic solver has no contact with the surface of a body.
    #[error(
        "cloth {cloth}: the solver `classic` does not collide with the surface of a body: the cloth meets the solids of its body instead, if the \
         scene has them; use `xpbd` for the surface"
    )]
    BodyLeftOut {
        /// The cloth by name.
        cloth: String,
    },
    /// Springs so soft that they do nothing against rounding, which moves the cloth by millimetres a second.
    #[error(
        "cloth {cloth}: its softest springs have a period of {period:.4} s, and steps of {dt:.6} s are too short for them: \
         rounding keeps the cloth in motion; use fewer substeps, {enough} are enough"
    )]
    Soft {
        /// The cloth by name.
        cloth: String,
        /// Period \[s\] of a particle on the springs around it.
        period: f64,
        /// The step \[s\].
        dt: f64,
        /// Substeps of a 16th of that period.
        enough: u32,
    },
    /// Steps so long for a material on its cells that bending is bounded, and the cloth hangs softer than the material says.
    #[error(
        "cloth {cloth}: steps of {dt:.6} s are too long for its bending stiffness on cells of this size: it bends up to {softer:.1} \
         times as easily as its material says; use {enough} substeps, or a coarser grid"
    )]
    Limp {
        /// The cloth by name.
        cloth: String,
        /// The step \[s\].
        dt: f64,
        /// The stiffness of the material over that of the cloth.
        softer: f64,
        /// Substeps in which nine tenths of the cloth bend as stiffly as the material says.
        enough: u32,
    },
    /// Lengths are limited on coarser grids in every step, and nothing damps the cloth: the limits feed its motion.
    #[error(
        "cloth {cloth}: a pyramid in every step adds energy, and the cloth has no damping: use the pyramid every second step \
         or less often, or add damping"
    )]
    Pyramid {
        /// The cloth by name.
        cloth: String,
    },
    /// Cloth crossed itself or other cloth at the start, which the GPU backend does not take apart: it made some frames on the CPU first
    /// ([`crate::Scene::take_apart`]).
    #[error("{done}{}", if *left > 0 { ": the GPU leaves them so; start the layers apart, or step on the CPU backend" } else { "" })]
    Crossed {
        /// The cloths, and the result, in words.
        done: String,
        /// Pairs of triangles that still cross.
        left: u64,
    },
    /// The classic solver has no contact of cloth with cloth.
    #[error("cloth {cloth}: the classic solver has no contact of cloth with cloth: use xpbd, or leave contact out")]
    ContactClassic {
        /// The cloth by name.
        cloth: String,
    },
    /// Lengths are not limited on coarser grids, which ignore contact and would pull the cloth through colliders.
    #[error(
        "cloth {cloth}: the pyramid is not used, because it ignores contact and the cloth meets colliders: leave the pyramid out, \
         and use 8 or more rounds of polish"
    )]
    PyramidOnColliders {
        /// The cloth by name.
        cloth: String,
    },
    /// Lengths are not limited on coarser grids, which would pull the cloth away from pins between their nodes.
    #[error(
        "cloth {cloth}: the pyramid is not used, because pins lie between the nodes of its coarse grids: leave the pyramid out, use \
         tethers, or pin particles of even columns and rows"
    )]
    PyramidOffPins {
        /// The cloth by name.
        cloth: String,
    },
    /// Steps were too long: more are made.
    #[error(
        "{asked} substeps in {step:.4} s were requested, and {made} are used: a step may take at most {longest:.4} s here; \
         request more substeps, or tethers"
    )]
    Substeps {
        /// As asked for.
        asked: u32,
        /// As made.
        made: u32,
        /// [`crate::Options::step`] \[s\].
        step: f64,
        /// The longest step \[s\].
        longest: f64,
    },
    /// The host's device was not checked: in a browser the host awaits the check before it makes a stepper.
    #[error("the GPU {name} runs without a self-check: await self_check_async before the stepper is made")]
    Unchecked {
        /// The adapter, its interface and its driver.
        name: String,
    },
    /// The host's device failed its self-check ([`crate::self_check`]).
    #[error(
        "the GPU {name} failed its self-check ({found}): {}",
        if *used {
            "it runs because it was requested explicitly, and results may be wrong; update its driver, or use the CPU backend"
        } else {
            "the CPU backend runs instead; update the driver, or request the GPU explicitly to use it anyway"
        }
    )]
    Adapter {
        /// The adapter, its interface and its driver.
        name: String,
        /// The mismatches, in words.
        found: String,
        /// Whether the device steps all the same.
        used: bool,
    },
}

/// The fewest substeps that a scene may have, and the longest step \[s\] from which it follows; `free` if it has cloth that
/// springs alone hold together.
pub fn fewest(options: &Settings, free: bool) -> (u32, f64) {
    if options.solver != Solver::Xpbd {
        return (1, f64::INFINITY);
    }
    let longest = if free { LONGEST_FREE } else { LONGEST };
    // A quotient that rounding has put just above a whole number counts as that number.
    let steps = (options.step / longest - 1e-6).ceil();
    (steps.max(1.0) as u32, longest)
}

/// Prepares a cloth for a solver and changes what the solver cannot do, with a warning. `most` is the requested number of tethers per
/// particle; returns the largest number that the cloth may have.
pub fn prepare(cloth: &mut Cloth, options: &Settings, most: u32, warnings: &mut Vec<Warning>) -> Result<u32> {
    if options.solver != Solver::Xpbd {
        return Ok(0);
    }
    let uneven = masses::even(cloth)?;
    cloth.exact |= rounds(cloth, options);
    cloth.shear = shear::strength(cloth);
    let masses = if let Some(Warning::Masses { ratio, .. }) = uneven { ratio } else { 1.0 };
    warnings.extend(uneven);
    warnings.extend(soft(cloth, options));
    warnings.extend(limp(cloth, options));
    warnings.extend(turns(cloth));
    let loose: Vec<String> = cloth.loose_grids().into_iter().map(|g| cloth.grids()[g].name.clone()).collect();
    warnings.extend((!loose.is_empty()).then(|| Warning::Loose { cloth: cloth.name().into(), names: loose }));
    cloth.levels_with_pins = if options.pyramid > 0 { pins::levels(cloth) } else { u32::MAX };
    let blind = options.pyramid > 0 && cloth.levels_with_pins == 0;
    warnings.extend(blind.then(|| Warning::PyramidOffPins { cloth: cloth.name().into() }));
    let fed = options.pyramid == 1 && cloth.damping <= 0.0 && has_levels(cloth, options);
    warnings.extend(fed.then(|| Warning::Pyramid { cloth: cloth.name().into() }));
    if most > 0 || cloth.membrane().is_some() || !cloth.particles().iter().any(|p| p.is_pinned()) {
        return Ok(most);
    }
    let lengths = lengths::ratio(cloth);
    if masses <= MOST_RATIO && lengths <= MOST_LENGTHS {
        return Ok(0);
    }
    warnings.push(Warning::Tethers { cloth: cloth.name().into(), given: GIVEN, masses, lengths });
    Ok(GIVEN)
}

/// Whether steps are so short that rounding of positions matters, and numbers so fine that what it takes is worth keeping.
fn rounds(cloth: &Cloth, options: &Settings) -> bool {
    let dt = options.step / f64::from(options.substeps);
    let far = cloth.positions().as_flattened().iter().fold(0f32, |far, x| far.max(x.abs()));
    dt < SHORT && f64::from(far * f32::EPSILON) / dt < COARSE
}

/// Whether steps are so short for soft springs that rounding outdoes them.
fn soft(cloth: &Cloth, options: &Settings) -> Option<Warning> {
    let Compliance::Constant(soft) = cloth.compliance else { return None };
    let least = (0..cloth.len()).map(|k| f64::from(cloth.mass(k))).fold(f64::INFINITY, f64::min);
    // Eight springs hold a particle.
    let period = std::f64::consts::TAU * (least * f64::from(soft) / 8.0).sqrt();
    let dt = options.step / f64::from(options.substeps);
    let enough = (options.step / (period / 16.0)).ceil().max(1.0) as u32;
    let name = || cloth.name().to_owned();
    // Measured: the motion falls with the square of the step, and is 1 mm/s at about this one.
    (period > 24.0 * dt).then(|| Warning::Soft { cloth: name(), period, dt, enough })
}

/// Whether steps are so long that a material bends more easily than it should.
fn limp(cloth: &Cloth, options: &Settings) -> Option<Warning> {
    let (dt, longest) = (options.step / f64::from(options.substeps), bend::longest(cloth));
    let softer = (dt / longest).powi(2);
    let enough = (options.step / longest).ceil() as u32;
    (softer > LIMP).then(|| Warning::Limp { cloth: cloth.name().into(), dt, softer, enough })
}

/// Whether the cloth hangs from one point: its pins lie closer than a thousandth of its longer side at rest.
fn turns(cloth: &Cloth) -> Option<Warning> {
    let pins = || cloth.particles().iter().zip(cloth.positions()).filter(|(p, _)| p.is_pinned()).map(|(_, at)| at);
    let first = pins().next()?;
    let apart = pins().flat_map(|p| (0..3).map(|c| (p[c] - first[c]).abs())).fold(0.0, f32::max);
    let springs = match cloth.rest() {
        Rest::None => return None,
        Rest::Constant(lengths) | Rest::Image(lengths) => lengths,
    };
    let longest = springs.iter().fold(0f32, |longest, l| longest.max(l[0]).max(l[1]));
    let side = cloth.grids().iter().map(|g| g.width.max(g.height)).max().unwrap_or(0);
    (apart <= 1e-3 * longest * side as f32).then(|| Warning::Turns { cloth: cloth.name().into() })
}
