//! Cloth that hangs from pins by its tethers. At rest few substeps hold it; stirred by wind, by pins that move or by a start far from
//! where it will hang, the same numbers stretch it several times as far, so it then has more.

use std::f64::consts::TAU;

use super::{Need, Support, longest, own_speed, scaled, spanned, stiff};
use crate::cloth::{Cloth, Rest};
use crate::number::real::{V3, add, cast, cross, dot, scale, sub};
use crate::scene::Scene;

/// Speed \[m/s\] at the start from which hanging cloth whips about, and its substeps at N = 64.
const THROWN_M_S: f64 = 1.0;
const THROWN_SUBSTEPS: f64 = 12.0;
/// Rounds of polish of hanging sheets. At rest one is as good in nine tenths of the time; while they are stirred, three would be.
pub const HANG_POLISH: u32 = 2;
/// Those of hanging strips, which swing far from a corner: with two, one of 78 x 14 is stretched by 15 % at p99 on its way.
pub const STRIP_POLISH: u32 = 3;
/// Damping \[1/s\] below which hanging cloth goes on whipping, and the rounds of polish that keep it together.
const DAMPED: f32 = 0.5;
pub const WHIP_POLISH: u32 = 8;
/// Substeps at N = 64 of a garment, and its rounds: its load takes ways that sheets do not have.
const GARMENT_SUBSTEPS: f64 = 5.0;
const GARMENT_POLISH: u32 = 4;
/// Substeps at N = 64 of a garment of a material, which has no rounds.
const FABRIC_GARMENT_SUBSTEPS: f64 = 24.0;
/// Substeps of a garment on a row of pins, such as a loop, while it is stirred, over those at rest: wind pulls more at a tube than at a flag.
const ROW_STIRRED: f64 = 1.5;
/// Substeps at N = 64 of cloth that is spanned between pins, and its rounds: its weight pulls across, which tethers to the nearest pins
/// hold to a part.
const SPANNED_SUBSTEPS: f64 = 8.0;
const SPANNED_POLISH: u32 = 4;
/// Relaxations per frame at N = 64 of cloth that is stirred, one more than the rounds of polish per substep, and its fewest substeps there.
const STIRRED_RELAXATIONS: f64 = 63.0;
const STIRRED_SUBSTEPS: f64 = 9.0;
/// Substeps at N = 64 of cloth of a material that is stirred: it has no rounds of polish. With 8 a flag of cotton in wind of 8 m/s is stretched by
/// 56 % at p99, with these by 5 %, with 64 by 3 %.
const FABRIC_SUBSTEPS: f64 = 40.0;
/// Coarser grids of a material have as many as this: fewer would drape otherwise than finer grids do.
const FABRIC_N: f64 = 64.0;
/// Speed \[m/s\] of wind that stirs.
const WINDY_M_S: f64 = 2.0;
/// Share of its area, seen along gravity, from which cloth lies more than it hangs, so that it swings down from the start.
const LYING: f64 = 0.5;
/// Shortest and longest time \[s\] for which cloth is stirred that swings down.
const SWING_S: [f64; 2] = [1.0, 5.0];

/// Numbers of cloth at rest; `n` particles along a side.
pub fn need(cloth: &Cloth, n: f64) -> (u32, u32, Support) {
    let garment = is_garment(cloth);
    let substeps = match n {
        _ if garment && cloth.membrane().is_some() => scaled(FABRIC_GARMENT_SUBSTEPS, n.max(FABRIC_N)),
        _ if garment => ((GARMENT_SUBSTEPS * (n / 64.0).sqrt()).ceil() as u32).max(4),
        n if n <= 40.0 => 3,
        n if n <= 128.0 => 4,
        n if n <= 196.0 => 5,
        n if n <= 256.0 => 6,
        n => (n / 32.0).ceil().min(super::MAX_SUBSTEPS.into()) as u32,
    };
    let (substeps, polish) = match () {
        () if own_speed(cloth) > THROWN_M_S => (substeps.max(scaled(THROWN_SUBSTEPS, n)), WHIP_POLISH),
        () if cloth.damping < DAMPED => (substeps, WHIP_POLISH),
        () if garment => (substeps, GARMENT_POLISH),
        () if longest(cloth) > 2.0 * (cloth.len() as f64).sqrt() => (substeps, STRIP_POLISH),
        () => (substeps, HANG_POLISH),
    };
    if spanned::span(cloth).is_some() {
        return (substeps.max(scaled(SPANNED_SUBSTEPS, n)), polish.max(SPANNED_POLISH), Support::Spanned);
    }
    (substeps, polish, Support::Tethered)
}

/// Substeps of the same cloth while it is stirred, of garments on a row of pins, and of a material among colliders; 0 for cloth that is not held so.
pub fn stirred(cloth: &Cloth, rest: &Need) -> u32 {
    let (sheet, n) = (cloth.membrane().is_some(), super::side(cloth));
    let substeps = match rest.support {
        Support::TetheredRow if is_garment(cloth) => {
            ((ROW_STIRRED * f64::from(rest.substeps)).ceil() as u32).min(super::MAX_SUBSTEPS)
        }
        Support::Tethered | Support::Spanned | Support::TetheredOnColliders if sheet => {
            scaled(FABRIC_SUBSTEPS, n.max(FABRIC_N))
        }
        Support::Tethered | Support::Spanned if stiff(cloth) => {
            scaled((STIRRED_RELAXATIONS / f64::from(rest.polish + 1)).max(STIRRED_SUBSTEPS), n)
        }
        _ => return 0,
    };
    substeps.max(rest.substeps)
}

/// Whether a cloth has rest lengths of its own at each texel, as garments do.
fn is_garment(cloth: &Cloth) -> bool {
    matches!(cloth.rest(), Rest::Image(_))
}

/// Whether the wind of a scene stirs cloth.
pub fn is_windy(scene: &Scene) -> bool {
    scene.wind.as_ref().is_some_and(|wind| super::length(cast(wind.velocity)) >= WINDY_M_S)
}

/// Whether cloth starts far from where it will hang: more across gravity than along it. Takes time linear in the particles.
pub fn swings(cloth: &Cloth, gravity: [f32; 3]) -> bool {
    let g: V3<f64> = cast(gravity);
    let strength = dot(g, g).sqrt();
    if strength <= 0.0 {
        return false;
    }
    let down = scale(g, 1.0 / strength);
    let (mut lies, mut all) = (0.0, 0.0);
    for normal in cells(cloth) {
        lies += dot(normal, down).abs();
        all += dot(normal, normal).sqrt();
    }
    lies > LYING * all
}

/// For how long \[s\] cloth is stirred that swings down from its start, 0 if it does not: a period of a rod as long as the diagonal of its
/// box, on a hinge. With fewer substeps while it is fast a kink comes into the hem between its pins, which then wanders for 8 s, 4 to 6 %
/// too long.
pub fn swing_time(cloth: &Cloth, gravity: [f32; 3]) -> f64 {
    if !swings(cloth, gravity) {
        return 0.0;
    }
    let there = cloth.positions().iter().zip(cloth.particles()).filter(|(_, p)| p.exists());
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for (at, _) in there {
        let at: V3<f64> = cast(*at);
        (low, high) = ([0, 1, 2].map(|a| low[a].min(at[a])), [0, 1, 2].map(|a| high[a].max(at[a])));
    }
    let strength = super::length(cast(gravity));
    let period = TAU * (2.0 * super::length(sub(high, low)) / (3.0 * strength)).sqrt();
    period.clamp(SWING_S[0], SWING_S[1])
}

/// Twice the area of each cell whose corners exist, along its normal.
fn cells(cloth: &Cloth) -> impl Iterator<Item = V3<f64>> + '_ {
    cloth.grids().iter().flat_map(move |grid| {
        let (first, width, height) = (grid.first as usize, grid.width as usize, grid.height as usize);
        let quads = (0..height.saturating_sub(1)).flat_map(move |j| (0..width.saturating_sub(1)).map(move |i| (i, j)));
        quads.filter_map(move |(i, j)| {
            let corners = [0, 1, width + 1, width].map(|by| first + j * width + i + by);
            let exist = corners.iter().all(|k| cloth.particles()[*k].exists());
            let [a, b, c, d]: [V3<f64>; 4] = corners.map(|k| cast(cloth.positions()[k]));
            let halves = [cross(sub(b, a), sub(c, a)), cross(sub(c, a), sub(d, a))];
            exist.then(|| add(halves[0], halves[1]))
        })
    })
}
