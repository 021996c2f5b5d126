//! Looks for cloth that has crossed in motion, where contact does not exclude it: compares the triangles around particles that contact has found too
//! near to one another.

use super::World;
use crate::cpu::body::{Body, view};
use crate::cpu::untangle::pierce::pierces;
use crate::number::real::{Real, V3};

/// A particle: the index of its cloth, and its own.
pub(super) type Seed = [u32; 2];

/// A triangle; corners of one name are one point.
struct Facet {
    corners: [V3<f64>; 3],
    names: [Seed; 3],
}

impl Facet {
    /// Whether boxes around both meet.
    fn meets(&self, other: &Facet) -> bool {
        let least = |of: &Facet, c: usize| of.corners.iter().map(|p| p[c]).fold(f64::INFINITY, f64::min);
        let most = |of: &Facet, c: usize| of.corners.iter().map(|p| p[c]).fold(f64::NEG_INFINITY, f64::max);
        (0..3).all(|c| least(self, c) <= most(other, c) && least(other, c) <= most(self, c))
    }

    /// Whether an edge of this triangle pierces the other one. Edges that share a corner with it do not count.
    fn pierces(&self, other: &Facet) -> bool {
        [[0, 1], [1, 2], [2, 0]].into_iter().any(|edge| {
            let shares = edge.iter().any(|k| other.names.contains(&self.names[*k]));
            !shares && pierces(edge.map(|k| self.corners[k]), other.corners).is_some()
        })
    }
}

impl World {
    /// Particles around which triangles cross at the end of a frame, among those that contact suspects.
    pub(super) fn patrol<T: Real>(&self, bodies: &[Body<T>], cloths: &[usize]) -> Vec<Seed> {
        let mut seeds = Vec::new();
        for own in cloths.iter().filter(|own| !self.runs[**own].asleep) {
            let Some(fabric) = bodies[*own].fabric() else { continue };
            for suspect in fabric.suspects() {
                let other = suspect.cloth.map_or(*own, |cloth| cloth as usize);
                let there = bodies.get(other).and_then(|body| body.fabric()?.particle_at(suspect.other));
                if let (Some(here), Some(there)) = (fabric.particle_at(suspect.place), there) {
                    let pair = [[*own as u32, here], [other as u32, there]];
                    let [a, b] = pair.map(|seed| self.facets_at(bodies, seed));
                    let cross =
                        |one: &Facet| b.iter().any(|two| one.meets(two) && (one.pierces(two) || two.pierces(one)));
                    if a.iter().any(cross) {
                        seeds.extend(pair);
                    }
                }
            }
        }
        seeds
    }

    /// The triangles around a particle.
    fn facets_at<T: Real>(&self, bodies: &[Body<T>], [cloth, particle]: Seed) -> Vec<Facet> {
        let (of, body) = (&self.scene.cloths[cloth as usize], &bodies[cloth as usize]);
        let (Some(grid), Some(fabric)) = (of.grids().iter().rev().find(|grid| grid.first <= particle), body.fabric())
        else {
            return Vec::new();
        };
        let (k, first, width) = ((particle - grid.first) as usize, grid.first as usize, grid.width as usize);
        let mut facets = Vec::new();
        view(body.now(), &body.holes, grid).triangles(k % width, k / width, |b, c| {
            let particles = [k, b, c].map(|k| first + k);
            let corners = particles.map(|k| [0, 1, 2].map(|c| f64::from(body.now()[k][c].get() as f32)));
            facets.push(Facet { corners, names: particles.map(|k| [cloth, fabric.point(k as u32)]) });
        });
        facets
    }
}
