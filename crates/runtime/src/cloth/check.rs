//! Conditions that a cloth must meet before a solver may trust it.

use gimage_bundle::{MAX_PARTICLES, find_rings};

use super::{Mass, Particle, Parts, Rest};
use crate::error::{Error, Result};

/// Checks everything and returns the seam rings: offsets and members.
pub fn rings(parts: &Parts) -> Result<(Vec<u32>, Vec<u32>)> {
    grids(parts)?;
    lengths(parts)?;
    values(parts)?;
    let (rings, faults) = find_rings(&parts.particles);
    if let Some(&(index, fault)) = faults.first() {
        return Err(Error::Seam { cloth: parts.name.clone(), index, fault });
    }
    let (mut starts, mut members) = (vec![0], Vec::new());
    for ring in rings.iter() {
        members.extend_from_slice(ring);
        starts.push(members.len() as u32);
    }
    Ok((starts, members))
}

fn grids(parts: &Parts) -> Result<()> {
    let mut next = 0u64;
    for (index, g) in parts.grids.iter().enumerate() {
        let bad = |problem| {
            let (cloth, width, height) = (parts.name.clone(), g.width, g.height);
            Err(Error::Grid { cloth, grid: index, width, height, problem })
        };
        if g.width < 2 || g.height < 2 {
            return bad("a grid has at least 2 x 2");
        }
        if u64::from(g.first) != next {
            return bad("its particles do not follow those of the grid before it");
        }
        next += u64::from(g.width) * u64::from(g.height);
        if next > u64::from(MAX_PARTICLES) {
            return bad("a cloth has at most 16777214 particles");
        }
    }
    if parts.grids.is_empty() {
        let cloth = parts.name.clone();
        return Err(Error::Grid { cloth, grid: 0, width: 0, height: 0, problem: "a cloth has at least one grid" });
    }
    Ok(())
}

fn lengths(parts: &Parts) -> Result<()> {
    let expected = parts.grids.iter().map(super::Grid::texels).sum();
    let same = |what, found, expected| {
        if found == expected {
            return Ok(());
        }
        Err(Error::Length { cloth: parts.name.clone(), what, found, expected })
    };
    same("particle kinds", parts.particles.len(), expected)?;
    same("positions", parts.positions.len(), expected)?;
    match &parts.rest {
        Rest::None => {}
        Rest::Constant(r) => same("constant rest lengths", r.len(), parts.grids.len())?,
        Rest::Image(r) => same("rest lengths", r.len(), expected)?,
    }
    if let Mass::Image(m) = &parts.mass {
        same("masses", m.len(), expected)?;
    }
    Ok(())
}

fn values(parts: &Parts) -> Result<()> {
    let bad = |index, problem| Err(Error::Particle { cloth: parts.name.clone(), index, problem });
    positions(&parts.name, &parts.positions, &parts.particles)?;
    let length = |l: &[f32; 4]| l.iter().all(|x| x.is_finite() && *x >= 0.0);
    match &parts.rest {
        Rest::None => {}
        Rest::Constant(r) => {
            if let Some(g) = r.iter().position(|l| !length(l)) {
                return bad(parts.grids[g].first as usize, "a rest length is negative or not finite");
            }
        }
        Rest::Image(r) => {
            if let Some(k) = r.iter().position(|l| !length(l)) {
                return bad(k, "a rest length is negative or not finite");
            }
        }
    }
    masses(&parts.name, &parts.mass, &parts.particles)
}

/// Checks the positions of a cloth by name.
pub fn positions(name: &str, positions: &[[f32; 3]], particles: &[Particle]) -> Result<()> {
    if positions.len() != particles.len() {
        let (cloth, found, expected) = (name.into(), positions.len(), particles.len());
        return Err(Error::Length { cloth, what: "positions", found, expected });
    }
    let wrong = |(p, particle): (&[f32; 3], &Particle)| particle.exists() && !p.iter().all(|x| x.is_finite());
    let index = positions.iter().zip(particles).position(wrong);
    let problem = "its position is not finite";
    index.map_or(Ok(()), |index| Err(Error::Particle { cloth: name.into(), index, problem }))
}

/// The same of its masses, of the right number.
pub fn masses(name: &str, mass: &Mass, particles: &[Particle]) -> Result<()> {
    // The solver works with 1/mass, which has to be a number too.
    let fits = |m: f32| m > 0.0 && m.is_finite() && (1.0 / m).is_finite();
    let wrong = match mass {
        Mass::Constant(m) => (!fits(*m)).then_some(0),
        Mass::Image(m) => m.iter().zip(particles).position(|(m, p)| p.exists() && !fits(*m)),
    };
    let problem = "its mass is not above 0, or too small for its inverse";
    wrong.map_or(Ok(()), |index| Err(Error::Particle { cloth: name.into(), index, problem }))
}
