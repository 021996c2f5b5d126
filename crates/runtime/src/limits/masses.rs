//! Masses of neighbours that one relaxation a step can even out.

use super::Warning;
use crate::cloth::Cloth;
use crate::error::Result;

/// Largest mass over that of a neighbour. A relaxation moves the heavier end of a spring by the lighter's share of their
/// masses alone, so that what the heavier one falls in a step is made good by stretch of that many times the fall.
pub const MOST_RATIO: f64 = 30.0;

/// Limits the masses of neighbours. A particle heavier than [`MOST_RATIO`] times the mean of its neighbours is made
/// lighter; then, until no more change, the lighter end of a spring heavier. Masses of pinned particles do not count.
pub fn even(cloth: &mut Cloth) -> Result<Option<Warning>> {
    let most = MOST_RATIO;
    let points = cloth.points();
    let free = |k: usize| cloth.inverse_mass(k) > 0.0;
    let mut edges = Vec::new();
    let (mut ratio, mut uneven) = (1f64, false);
    for (g, grid) in cloth.grids().iter().enumerate() {
        for (k, d) in (0..grid.texels()).flat_map(|k| (0..4).map(move |d| (k, d))) {
            let (a, b) = (grid.first as usize + k, cloth.neighbour(g, k, d));
            let Some(b) = b.filter(|b| free(a) && free(*b) && cloth.spring(g, k, d) > 0.0) else { continue };
            let [m, n] = [a, b].map(|k| f64::from(cloth.mass(k)));
            ratio = ratio.max((m / n).max(n / m));
            uneven |= m != n;
            edges.push((points[a] as usize, points[b] as usize));
        }
    }
    if !uneven || ratio <= most {
        return Ok(None);
    }
    let given: Vec<f64> = (0..cloth.len()).map(|k| f64::from(cloth.mass(k))).collect();
    let (mut mass, mut around) = (given.clone(), vec![(0.0, 0u32); cloth.len()]);
    for &(a, b) in &edges {
        for (k, other) in [(a, b), (b, a)] {
            around[k] = (around[k].0 + given[other], around[k].1 + 1);
        }
    }
    for (mass, (sum, count)) in mass.iter_mut().zip(around).filter(|(_, around)| around.1 > 0) {
        *mass = mass.min(most * sum / f64::from(count));
    }
    let mut changed = true;
    while changed {
        changed = false;
        for &(a, b) in &edges {
            for (light, heavy) in [(a, b), (b, a)] {
                let least = mass[heavy] / most;
                if mass[light] < least * (1.0 - 1e-9) {
                    (mass[light], changed) = (least, true);
                }
            }
        }
    }
    let even: Vec<f32> = (0..cloth.len()).map(|k| mass[points[k] as usize] as f32).collect();
    let particles = (0..cloth.len()).filter(|k| even[*k] != cloth.mass(*k)).count();
    cloth.set_masses(even)?;
    Ok(Some(Warning::Masses { cloth: cloth.name().into(), particles, ratio, limit: most }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Flat;

    fn limited(mass: impl Fn(usize) -> f32) -> (Vec<f32>, Option<Warning>) {
        let mut cloth = Flat::square("x", 5).cloth().unwrap();
        cloth.set_masses((0..25).map(mass).collect()).unwrap();
        let warning = even(&mut cloth).unwrap();
        ((0..25).map(|k| cloth.mass(k)).collect(), warning)
    }

    #[test]
    fn a_heavy_particle_is_made_lighter_and_those_among_heavy_ones_heavier() {
        let (masses, warning) = limited(|k| if k == 12 { 1e6 } else { 1.0 });
        assert_eq!((masses[12], masses[11], masses[0]), (30.0, 1.0, 1.0));
        assert_eq!(warning, Some(Warning::Masses { cloth: "x".into(), particles: 1, ratio: 1e6, limit: MOST_RATIO }));
        let (masses, warning) = limited(|k| if k.is_multiple_of(2) { 9e4 } else { 1.0 });
        assert!(
            masses.iter().enumerate().all(|(k, m)| *m == if k.is_multiple_of(2) { 9e4 } else { 3e3 }),
            "{masses:?}"
        );
        assert!(matches!(warning, Some(Warning::Masses { particles: 12, .. })));
        // From a heavy half it falls step by step.
        let (masses, _) = limited(|k| if k < 10 { 9e6 } else { 1.0 });
        assert!([9e6, 9e6, 3e5, 1e4, 333.333_34].iter().enumerate().all(|(j, m)| masses[5 * j] == *m), "{masses:?}");
    }

    #[test]
    fn masses_that_springs_can_hold_are_left_alone() {
        let given = |k: usize| if k.is_multiple_of(2) { 29.0 } else { 1.0 };
        assert_eq!(limited(given), ((0..25).map(given).collect(), None));
        // Not one mass is unlike another: nothing is looked at.
        let mut cloth = Flat::square("x", 5).cloth().unwrap();
        assert_eq!(even(&mut cloth).unwrap(), None);
        assert!((cloth.mass(3) - 0.2 / 25.0).abs() < 1e-9);
    }
}
