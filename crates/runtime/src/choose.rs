//! Chooses the substeps and polishing rounds that the host leaves open, from what the scene is.

pub(crate) mod bend;
mod follow;
mod give;
mod hung;
mod reach;
mod settings;
mod spanned;
mod speed;
mod wish;

pub use follow::{FOLLOW_NUMBERS, Follow};
pub use settings::{Hold, Settings};
use speed::{fall, for_speed, length, own_speed, top_speed};
pub use wish::Wish;

use std::fmt;

use crate::cloth::{Cloth, Compliance};
use crate::levels;
use crate::options::{Options, Solver};
use crate::scene::Scene;

/// How a cloth is held, which decides how many substeps it needs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Support {
    /// Nothing holds it and nothing is in its way.
    Free,
    /// It hangs from pins, with tethers.
    Tethered,
    /// The same, and it is in wind, or starts far from where it will hang.
    Stirred,
    /// It hangs between three or more groups of pins that are not on one line, with tethers.
    Spanned,
    /// It hangs from a row of pins, with slack tethers.
    TetheredRow,
    /// It hangs from pins, with tethers, and colliders are in its way.
    TetheredOnColliders,
    /// A character wears it: it hangs from joints, with tethers, and the body is in its way.
    Worn,
    /// It hangs from pins by its springs alone.
    Springs,
    /// No pin holds it: it lies on colliders.
    OnColliders,
    /// No pin holds it: it falls on colliders, and meets them at this speed \[m/s\].
    Falls(f64),
    /// It meets a collider at this speed \[m/s\].
    Fast(f64),
}

/// The number of substeps and of polishing rounds that a stepper uses, and why.
///
/// A number given in [`Options`] is used as it is; substeps given alone have no polish. Otherwise every cloth asks for what
/// its support needs, and the largest numbers are used. N is the square root of the number of particles, at least half of
/// the longest side in texels. Substeps are those of 1/60 s; a longer or shorter [`Options::step`] has more or fewer.
///
/// | support | substeps | rounds | measured |
/// |---|---|---|---|
/// | free, or the classic solver | 8 | 0 | |
/// | pins with tethers, flat | 3, 4, 5, 6 for N up to 40, 128, 196, 256; above N / 32 | 2; 3 of strips, 8 if damped less than 0.5 1/s | scene s1, N = 32, 64, 128, 256: largest stretch 0.8, 0.9, 1.5, 1.4 %; 20 other sizes up to 320 at most 1.5 % |
/// | the same, of a garment | 5 sqrt(N / 64); 24 sqrt(N / 64) of a material, at least 24 | 4; 8 if damped less than 0.5 1/s | a T-shirt on two pins: p99 under 4 % |
/// | spanned between three or more groups of pins that are not on one line, with tethers | 8 sqrt(N / 64) | 4; 8 if damped less than 0.5 1/s | canopies: p99 at most 1.5 and 3.5 % at N = 64 and 128 |
/// | the same, in wind of 2 m/s and more, while pins move, and at a start far from where it will hang | 21, 16, 13, 9 sqrt(N / 64) with 2, 3, 4, 8 rounds; 40 sqrt(N / 64) of a material, at least 40, among colliders too | the same | sheets and T-shirts that are shaken and in wind of 8 m/s: p99 3 to 6 %, N = 128 6 to 19 % |
/// | the same, thrown at more than 1 m/s | 12 sqrt(N / 64) | 8 | random scenes: p99 under 10 % |
/// | a row of pins with tethers | 16 (N / 64)^0.75; of a garment that is stirred half as many more | 4 | scene s3: period within 0.2 % at N = 32 and 64 |
/// | pins with tethers, among colliders | 12 sqrt(N / 64), of a material 16 | 4 | T-shirt and cape of `assets/scenes` |
/// | cloth without a material that follows joints, among colliders or not | 12 sqrt(N / 64) f, at least 8 | 6, 8 if f is 1 | figure and mage of `docs/characters.md` |
/// | pins, no tethers | 16 sqrt(N / 64) | 4 | scene s3 without tethers |
/// | the same, with [`Options::pyramid`], no colliders, all pins at nodes of a grid of at most 4 cells along a side | 7 sqrt(N / 64) | 4 | scene s1 without tethers, N = 64, 128, 256: largest stretch 2.9, 3.3, 5.9 % |
/// | colliders, no pins | 12 sqrt(N / 64), of a material 48 | 8 | a T-shirt on moving arms: p99 4 % at N = 64, 5 % at 128 |
/// | the same, starting high enough to fall on them at more than 1 m/s | 25 sqrt(N / 64) | 3 | scene s2: see `docs/solvers.md` |
/// | a collider at speed v \[m/s\] | in a step, it moves at most a tenth of its radius past cloth, a fourth past cloth that follows joints | 8 | scene s2f |
///
/// f is the way along the surface to the nearest pin, in cells (95 % of the particles have none that is longer), over 0.8 N, at most 1: a skirt settles sooner than a cape.
///
/// Substeps of hanging cloth that is stirred are in force at once, 1 s after the last pin moved, and from the start for 1 s and a period of a rod as long as the diagonal of its box (3 s of a sheet of 1 m); then they fall as those of fast colliders do.
///
/// The choice is made again when a cloth loses its last pin or gets its first one, to which no tether leads, and when the first collider comes. A cloth that is added raises the
/// numbers if it asks for more ([`crate::Stepper::add_cloth`]). Speed is that of cloth and colliders, and what a fall onto the highest collider adds. It is looked at again when
/// colliders change: the number rises at once, and falls gradually one second after the need ends. Cloth with a compliance
/// or a material is not polished, as its stretch is wanted. Cloth on pins whose compliance is seen has up to 128 relaxations per
/// frame (64 substeps and a round), so that it stretches by its compliance and not by the solver's error; its tethers are longer by
/// the stretch of the springs at the pins. Tethers of a spanned fabric are longer by the stretch that its sag needs. Cloth of a material has at least the substeps in which it bends as
/// stiffly as it should: the finer the grid and the stiffer the fabric, the more. At most 64 substeps are chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Steps per [`Options::step`].
    pub substeps: u32,
    /// Steps per [`Options::step`] while hanging cloth is stirred: in wind, while its pins move, or as it swings down from its start. 0 where
    /// that makes no difference.
    pub stirred: u32,
    /// Rounds of polish.
    pub polish: u32,
    /// Whether the host gave the number of substeps, and that of rounds.
    pub given: [bool; 2],
    /// The cloth that asks for most, by name; none in a scene without cloth.
    pub cloth: Option<String>,
    /// Its support.
    pub support: Support,
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let plural = |n: u32| if n == 1 { "" } else { "s" };
        let Choice { substeps, polish, given, .. } = self;
        write!(f, "{substeps} substep{}", plural(*substeps))?;
        if self.stirred > *substeps {
            write!(f, ", {} while wind or its pins stir the cloth", self.stirred)?;
        }
        write!(f, ", {polish} round{} of polish", plural(*polish))?;
        let chosen = match given {
            [true, _] => return f.write_str(": given"),
            [false, false] => "chosen",
            [false, true] => "substeps chosen",
        };
        let name = self.cloth.as_deref().unwrap_or("");
        let because = match self.support {
            Support::Free => return write!(f, ": {chosen}"),
            Support::Tethered => "hangs from pins with tethers".to_owned(),
            Support::Stirred => "hangs from pins, and is in wind or swings down".to_owned(),
            Support::Spanned => "is spanned between pins".to_owned(),
            Support::TetheredRow => "hangs from a row of pins".to_owned(),
            Support::TetheredOnColliders => "hangs from pins among colliders".to_owned(),
            Support::Worn => "hangs from the joints of a body".to_owned(),
            Support::Springs => "hangs from pins by its springs alone".to_owned(),
            Support::OnColliders => "lies on colliders and no pin holds it".to_owned(),
            Support::Falls(speed) => format!("falls on colliders at {speed:.1} m/s"),
            Support::Fast(speed) => format!("meets a collider at {speed:.1} m/s"),
        };
        write!(f, ": {chosen}, as cloth '{name}' {because}")
    }
}

/// The rules count substeps in this time \[s\].
const FRAME_S: f64 = 1.0 / 60.0;
/// Most substeps that are chosen without a target.
const MAX_SUBSTEPS: u32 = 64;
/// Substeps of cloth that asks for nothing.
const FREE_SUBSTEPS: u32 = 8;
/// Rounds of polish of cloth that follows joints, and the way to its pins, as a share of N, from which it swings as a cape does.
const WORN_POLISH: u32 = 6;
const CAPE_POLISH: u32 = 8;
const FREE_REACH: f64 = 0.8;
/// Rounds of polish of cloth that meets a collider fast.
const FAST_POLISH: u32 = 8;
/// Speed from which a fall on colliders counts, its substeps at N = 64, and its rounds. A slap presses cells together where
/// steps are long, and further rounds press them more.
const MIN_FALL_M_S: f64 = 1.0;
const FALL_SUBSTEPS: f64 = 25.0;
const FALL_POLISH: u32 = 3;
/// Substeps at N = 64 of cloth that hangs by its springs with a pyramid: the pyramid carries its weight.
const PYRAMID_SUBSTEPS: f64 = 7.0;

/// The numbers that one cloth needs.
#[derive(Clone, Copy)]
struct Need {
    substeps: u32,
    polish: u32,
    support: Support,
}

fn choose(given: &Options, scene: &Scene) -> Choice {
    let moves = top_speed(scene);
    let cloths = scene.cloths.iter().filter(|_| given.solver == Solver::Xpbd);
    let needs = cloths.flat_map(|cloth| {
        let (lasting, fast) = needs(cloth, given, scene, moves);
        [Some(lasting), fast].map(|n| Some((cloth, n?)))
    });
    let needs: Vec<(&Cloth, Need)> = needs.flatten().collect();
    let most = needs.iter().max_by_key(|(_, n)| (n.substeps, n.polish));
    let polish = needs.iter().map(|(_, n)| n.polish).max().unwrap_or(0);
    let open = given.substeps.is_none() && given.solver == Solver::Xpbd;
    let stirred = Wish::of(given, scene).iter().filter(|_| open).map(|w| w.stirred).max().unwrap_or(0);
    Choice {
        stirred,
        substeps: given.substeps.unwrap_or(in_step(most.map_or(FREE_SUBSTEPS, |(_, n)| n.substeps), given.step)),
        polish: given.polish.unwrap_or(if given.substeps.is_some() { 0 } else { polish }),
        given: [given.substeps.is_some(), given.polish.is_some()],
        cloth: most.map(|(cloth, _)| cloth.name().to_owned()),
        support: most.map_or(Support::Free, |(_, n)| n.support),
    }
}

/// The numbers that a cloth needs because of how it is held, and those for its speed, the wind and its start where they are larger.
/// Colliders move at up to `moves` \[m/s\].
fn needs(cloth: &Cloth, given: &Options, scene: &Scene, moves: f64) -> (Need, Option<Need>) {
    let speed = moves + own_speed(cloth) + fall(cloth, scene);
    let fast = Need {
        substeps: for_speed(own_speed(cloth) + fall(cloth, scene), cloth, scene),
        polish: if stiff(cloth) { FAST_POLISH } else { 0 },
        support: Support::Fast(speed),
    };
    let lasting = need(cloth, given, scene);
    let stirred = Need { substeps: hung::stirred(cloth, &lasting), support: Support::Stirred, ..lasting };
    let stirred = Some(stirred).filter(|_| hung::is_windy(scene) || hung::swings(cloth, scene.gravity));
    let more = [Some(fast), stirred].into_iter().flatten().max_by_key(|n| n.substeps);
    (lasting, more.filter(|n| n.substeps > lasting.substeps))
}

/// The numbers that a cloth needs because of how it is held.
fn need(cloth: &Cloth, given: &Options, scene: &Scene) -> Need {
    let n = side(cloth);
    let scaled = |at_64: f64| scaled(at_64, n);
    // Rounds of polish would take the place of its stiffness.
    let sheet = cloth.membrane().is_some();
    let (substeps, polish, support) = match (
        is_pinned(cloth),
        given.tethers > 0 && !cloth.untethered,
        scene.meets(cloth.met_groups()) || cloth.body().is_some() || cloth.contact.is_some(),
    ) {
        (true, true, _) if !sheet && cloth.follows_joints() => {
            let far = (reach::to_pins(cloth) / (FREE_REACH * n)).min(1.0);
            (scaled(12.0 * far), if far < 1.0 { WORN_POLISH } else { CAPE_POLISH }, Support::Worn)
        }
        (true, true, false) if stiff(cloth) && pins(cloth) as f64 >= 0.5 * n => {
            let substeps = (16.0 * (n / 64.0).powf(0.75)).ceil().clamp(FREE_SUBSTEPS.into(), MAX_SUBSTEPS.into());
            (substeps as u32, 4, Support::TetheredRow)
        }
        (true, true, false) => hung::need(cloth, n),
        (true, true, true) => (scaled(if sheet { 16.0 } else { 12.0 }), 4, Support::TetheredOnColliders),
        (true, false, false) if given.pyramid > 0 && levels::pins::carry(cloth, n) => {
            (scaled(PYRAMID_SUBSTEPS), 4, Support::Springs)
        }
        (true, false, _) => (scaled(16.0), 4, Support::Springs),
        (false, _, true) if !sheet && fall(cloth, scene) > MIN_FALL_M_S => {
            (scaled(FALL_SUBSTEPS), FALL_POLISH, Support::Falls(fall(cloth, scene)))
        }
        (false, _, true) => (scaled(if sheet { 48.0 } else { 12.0 }), 8, Support::OnColliders),
        (false, _, false) => (FREE_SUBSTEPS, 0, Support::Free),
    };
    // Compliance, tension and bending are exact in short steps only.
    let bends = (FRAME_S / bend::longest(cloth)).ceil().min(MAX_SUBSTEPS.into()) as u32;
    let (substeps, polish) = match give::relaxed(n, give::at_pins(cloth, scene.gravity)) {
        _ if stiff(cloth) => (substeps, polish),
        Some((all, rounds)) => (substeps.max(all), rounds),
        None => (substeps.max(FREE_SUBSTEPS).max(bends), 0),
    };
    Need { substeps, polish, support }
}

fn is_pinned(cloth: &Cloth) -> bool {
    pins(cloth) > 0
}

fn pins(cloth: &Cloth) -> usize {
    cloth.particles().iter().filter(|p| p.is_pinned()).count()
}

/// Whether all stretch is error: springs without compliance.
pub(crate) fn stiff(cloth: &Cloth) -> bool {
    cloth.membrane().is_none() && matches!(cloth.compliance, Compliance::None | Compliance::Constant(0.0))
}

/// Substeps that grow with the root of the particles along a side, from their number for 64.
fn scaled(at_64: f64, n: f64) -> u32 {
    (at_64 * (n / 64.0).sqrt()).ceil().clamp(FREE_SUBSTEPS.into(), MAX_SUBSTEPS.into()) as u32
}

/// Particles along a side.
fn side(cloth: &Cloth) -> f64 {
    (cloth.len() as f64).sqrt().max(0.5 * longest(cloth))
}

/// Particles along the longest side of a grid.
fn longest(cloth: &Cloth) -> f64 {
    f64::from(cloth.grids().iter().map(|g| g.width.max(g.height)).max().unwrap_or(0))
}

/// As many steps in `step` \[s\] as `n` in a frame.
fn in_step(n: u32, step: f64) -> u32 {
    (f64::from(n) * step / FRAME_S - 1e-6).ceil().clamp(1.0, 4096.0) as u32
}

#[cfg(test)]
#[path = "choose_tests.rs"]
mod tests;
