//! Lists that copies of a cloth share.

use std::sync::Arc;

use super::{Cloth, Compliance, Mass, Rest};
use crate::memory::Tally;

/// Whether two lists are one, or equal.
fn same<T: PartialEq + ?Sized>(a: &Arc<T>, b: &Arc<T>) -> bool {
    Arc::ptr_eq(a, b) || a == b
}

fn both<T: PartialEq + ?Sized>(a: &Option<Arc<T>>, b: &Option<Arc<T>>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => same(a, b),
        (None, None) => true,
        _ => false,
    }
}

impl Cloth {
    /// Whether a cloth has the same images: grids, particle kinds, rest lengths, masses, tethers, compliance, membrane, bending, stitches and skin.
    /// Positions, limits and settings may differ.
    pub(crate) fn has_images_of(&self, other: &Cloth) -> bool {
        let (own, others) = (&self.parts, &other.parts);
        let soft = match (&self.compliance, &other.compliance) {
            (Compliance::Image(a), Compliance::Image(b)) => same(a, b),
            (a, b) => a == b,
        };
        self.cut == other.cut
            && soft
            && own.particles.len() == others.particles.len()
            && same(&own.grids, &others.grids)
            && same(&own.rest, &others.rest)
            && same(&own.mass, &others.mass)
            && same(&own.particles, &others.particles)
            && both(&self.stored_tethers, &other.stored_tethers)
            && both(&self.membrane, &other.membrane)
            && both(&self.bending, &other.bending)
            && both(&self.sewing, &other.sewing)
            && both(&self.skin, &other.skin)
    }

    /// Takes the lists of a cloth with the same images in place of its own. Positions and limits are shared if they are equal.
    pub(crate) fn share(&mut self, other: &Cloth) {
        let (own, others) = (&mut self.parts, &other.parts);
        own.grids = others.grids.clone();
        own.particles = others.particles.clone();
        own.rest = others.rest.clone();
        own.mass = others.mass.clone();
        if own.positions == others.positions {
            own.positions = others.positions.clone();
        }
        if self.limits == other.limits {
            self.limits = other.limits.clone();
        }
        if self.backstops == other.backstops {
            self.backstops = other.backstops.clone();
        }
        (self.ring_starts, self.ring_members) = other.ring_lists();
        self.compliance = other.compliance.clone();
        self.stored_tethers = other.stored_tethers.clone();
        (self.membrane, self.bending) = (other.membrane.clone(), other.bending.clone());
        self.sewing = other.sewing.clone();
        self.skin = other.skin.clone();
    }

    /// Counts its lists.
    pub(crate) fn tally(&self, tally: &mut Tally) {
        let own = &self.parts;
        tally.image(&own.particles);
        tally.image(&self.ring_starts);
        tally.image(&self.ring_members);
        if let Rest::Image(rest) = &*own.rest {
            tally.image(rest);
        }
        if let Mass::Image(mass) = &*own.mass {
            tally.image(mass);
        }
        if let Compliance::Image(soft) = &self.compliance {
            tally.image(soft);
        }
        self.stored_tethers().iter().for_each(|held| tally.image(&held.anchors));
        self.membrane().iter().for_each(|membrane| tally.image(&membrane.cells));
        self.bending().iter().for_each(|bending| {
            tally.image(&bending.weights);
            tally.image(&bending.compliance);
        });
        self.grain().iter().for_each(|uv| tally.image(uv));
        self.limits.iter().for_each(|limits| tally.image(limits));
        self.backstops.iter().for_each(|backstops| tally.image(backstops));
        if let Some(sewing) = &self.sewing {
            tally.image(&sewing.stitches);
            tally.image(&sewing.threads);
            tally.image(&sewing.entries);
            tally.image(&sewing.moved);
        }
        if let Some(skin) = &self.skin {
            tally.image(&skin.rest);
            tally.image(&skin.influences);
        }
        tally.state(&own.positions);
    }

    /// As [`Cloth::rings`], to be shared.
    pub(crate) fn ring_lists(&self) -> (Arc<Vec<u32>>, Arc<Vec<u32>>) {
        (self.ring_starts.clone(), self.ring_members.clone())
    }
}
