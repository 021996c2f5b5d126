//! Soft, heavy and unevenly fine cloth.

use gimage_runtime::{Cloth, Compliance, Mass, Parts, Rest, Result};

use crate::case::{Case, N, Stretch, flag, held, scene, sheet, tuned};
use crate::random::Random;

const COUNT: usize = N * N;
/// Mass of a particle \[kg\].
const LIGHT: f64 = 0.2 / COUNT as f64;

pub fn cases() -> Result<Vec<Case>> {
    let mut out = Vec::new();
    for soft in [0.0, 1e-9, 1e-6, 1e-3, 1.0] {
        let cloth = tuned(flag()?, |c| c.compliance = Compliance::Constant(soft));
        // At 1 m/N the cloth itself is several times as long.
        let stretch = if soft < 1.0 { Stretch::Judged } else { Stretch::Open };
        out.push(Case::new(format!("compliance {soft} m/N"), scene(cloth)).stretch(stretch));
    }
    let mut random = Random(1);
    let mut each = || 10f64.powf(-9.0 * random.unit()) as f32;
    let list = (0..COUNT).map(|_| [each(), each(), each(), each()]).collect();
    let cloth = tuned(flag()?, |c| c.compliance = Compliance::Image(list));
    out.push(Case::new("compliance 1e-9 to 1 m/N at random", scene(cloth)).stretch(Stretch::Open));
    for ratio in [1e2f64, 1e4, 1e6] {
        let one = |k: usize| if k == COUNT / 2 { ratio } else { 1.0 };
        let board = |k: usize| if (k % N + k / N).is_multiple_of(2) { ratio } else { 1.0 };
        let mut random = Random(2);
        let any: Vec<f64> = (0..COUNT).map(|_| ratio.powf(random.unit())).collect();
        for (words, mass) in [
            ("one heavy particle", masses(one)),
            ("heavy and light by turns", masses(board)),
            ("masses at random", masses(|k| any[k])),
        ] {
            let case = Case::new(format!("mass ratio {ratio:.0e}, {words}"), scene(held(with(sheet()?, mass)?)?));
            // A heavy particle on light ones: a relaxation moves the light ones alone, so it sinks, and slowly.
            out.push(Case { calm: 30.0, ..case }.stretch(Stretch::WithTethers));
        }
    }
    for each in [1e-12, 1e12] {
        let cloth = held(with(sheet()?, Mass::Constant(each))?)?;
        out.push(Case::new(format!("{each:.0e} kg a particle"), scene(cloth)));
    }
    for ratio in [1e1f64, 1e2, 1e3, 1e4] {
        let stripes = |k: usize| if k.is_multiple_of(2) { 1.0 } else { ratio };
        let one = |k: usize| if k == N / 2 { 1.0 } else { ratio };
        let any = |k: usize| ratio.powf((k * 7 % 16) as f64 / 15.0);
        for (words, cloth) in
            [("by turns", spaced(stripes)?), ("one fine row", spaced(one)?), ("all sizes", spaced(any)?)]
        {
            let case = Case::new(format!("rest length ratio {ratio:.0e}, {words}"), scene(cloth));
            out.push(case.stretch(Stretch::OfLongest));
        }
    }
    Ok(out)
}

fn masses(of: impl Fn(usize) -> f64) -> Mass {
    Mass::Image((0..COUNT).map(|k| (LIGHT * of(k)) as f32).collect())
}

/// A cloth with other masses.
pub fn with(cloth: Cloth, mass: Mass) -> Result<Cloth> {
    let parts = Parts {
        name: cloth.name().into(),
        grids: cloth.grids().to_vec(),
        positions: cloth.positions().to_vec(),
        particles: cloth.particles().to_vec(),
        rest: cloth.rest().clone(),
        mass,
    };
    Ok(tuned(Cloth::new(parts)?, |c| c.damping = cloth.damping))
}

/// A held square of 1 m whose columns and rows are as far apart as `gap` says, up to a factor.
fn spaced(gap: impl Fn(usize) -> f64) -> Result<Cloth> {
    let whole: f64 = (0..N - 1).map(&gap).sum();
    let at: Vec<f64> = (0..N).map(|k| (0..k).map(&gap).sum::<f64>() / whole).collect();
    let square = sheet()?;
    let positions: Vec<[f32; 3]> = (0..COUNT).map(|k| [at[k % N] as f32, 0.0, at[k / N] as f32]).collect();
    let length = |k: usize, d: usize| {
        let (i, j) = (k % N, k / N);
        let (across, along) =
            (if i + 1 < N { at[i + 1] - at[i] } else { 0.0 }, if j + 1 < N { at[j + 1] - at[j] } else { 0.0 });
        let above = if j > 0 { at[j] - at[j - 1] } else { 0.0 };
        let diagonal = |x: f64, y: f64| if x > 0.0 && y > 0.0 { x.hypot(y) } else { 0.0 };
        [across, along, diagonal(across, along), diagonal(across, above)][d] as f32
    };
    let rest = (0..COUNT).map(|k| [0, 1, 2, 3].map(|d| length(k, d))).collect();
    // As heavy everywhere as the area around a particle, like a woven cloth.
    let share = |k: usize| {
        let (low, high) = (at[k.saturating_sub(1)], at[(k + 1).min(N - 1)]);
        0.5 * (high - low)
    };
    let mass = (0..COUNT).map(|k| (0.2 * share(k % N) * share(k / N)) as f32).collect();
    let cloth = Cloth::new(Parts {
        name: "cloth".into(),
        grids: square.grids().to_vec(),
        positions,
        particles: square.particles().to_vec(),
        rest: Rest::Image(rest),
        mass: Mass::Image(mass),
    })?;
    held(tuned(cloth, |c| c.damping = 2.0))
}
