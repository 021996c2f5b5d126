//! Pins that hold each particle, and their distances along the cloth.

use std::sync::Arc;

use gimage_bundle::{Bridge, RestLengths, SpringGrid, Tethers, bridges, tethers};

use super::{Cloth, Rest, groups};

impl Cloth {
    /// Up to `most` (at most [`gimage_bundle::MAX_ANCHORS`]) anchors of every particle: the nearest pins of the nearest
    /// groups of pins, with geodesic distances \[m\] at rest. Those of the bundle if no joined grids have more groups of pins than it
    /// stores anchors, or no more are asked for, and pins have not
    /// changed since; else recomputed from the present pins, rest lengths and stitches as [`gimage_bundle::tethers`] does, which
    /// takes about 2 microseconds per particle and anchor.
    pub fn tethers(&self, most: usize) -> Tethers {
        let enough = |t: &&Tethers| most <= t.per_particle || self.most_groups() <= t.per_particle;
        if let Some(stored) = self.stored_tethers().filter(enough) {
            let most = most.min(stored.per_particle);
            let slots = stored.anchors.chunks_exact(stored.per_particle.max(1));
            return Tethers { per_particle: most, anchors: slots.flat_map(|s| &s[..most]).copied().collect() };
        }
        tethers(&self.spring_grids(), &self.parts.particles, self.stitches(), most)
    }

    /// The most groups of pins of grids that seams and stitches join, which is the most anchors that a particle can have.
    fn most_groups(&self) -> usize {
        let (joined, (group, _)) = (self.joined_grids(), groups::of_pins(self));
        let grids = self.grids().iter().zip(joined);
        let mut all: Vec<(u32, u32)> =
            grids.flat_map(|(grid, joined)| group[grid.range()].iter().map(move |g| (joined, *g))).collect();
        all.retain(|(_, group)| *group != u32::MAX);
        all.sort_unstable();
        all.dedup();
        all.chunk_by(|a, b| a.0 == b.0).map(<[_]>::len).max().unwrap_or(0)
    }

    /// Stitches as paths between particles, by the present rest lengths.
    pub(crate) fn bridges(&self) -> Vec<Bridge> {
        bridges(&self.spring_grids(), self.stitches())
    }

    fn spring_grids(&self) -> Vec<SpringGrid<'_>> {
        let rest = |(index, grid): (usize, &super::Grid)| match &*self.parts.rest {
            Rest::None => RestLengths::Constant([0.0; 4]),
            Rest::Constant(lengths) => RestLengths::Constant(lengths[index]),
            Rest::Image(lengths) => RestLengths::Image(&lengths[grid.range()]),
        };
        (self.parts.grids.iter().enumerate())
            .map(|(index, grid)| SpringGrid { width: grid.width, height: grid.height, rest: rest((index, grid)) })
            .collect()
    }

    /// The tethers that came with the bundle, one a particle; none where it had none, or pins or stitches have changed since.
    pub fn stored_tethers(&self) -> Option<&Tethers> {
        self.stored_tethers.as_deref()
    }

    /// Takes the tethers of a bundle over, unless they are not of this cloth: one a particle, all to pinned particles.
    pub(crate) fn keep_tethers(&mut self, stored: Option<Tethers>) {
        let pinned = |k: u32| self.parts.particles.get(k as usize).is_some_and(|p| p.is_pinned());
        // Duplicates of a seam point hang on the same anchors.
        let points = self.points();
        let fits = |t: &Tethers| {
            t.anchors.len() == self.len() * t.per_particle
                && t.anchors.iter().all(|a| !a.exists() || pinned(a.particle))
                && points.iter().enumerate().all(|(k, p)| t.of(k) == t.of(*p as usize))
        };
        self.stored_tethers = stored.filter(fits).map(Arc::new);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Flat;
    use super::*;
    use gimage_bundle::{Bundle, Image, MapKind};

    /// A flat square of 5 x 5 particles whose first corner is pinned, as a bundle.
    fn bundle() -> Bundle {
        let mut bundle = Bundle::new("test");
        bundle.add_piece("p", 5, 5).unwrap();
        let mut image = Image::zeros(5, 5, 4);
        for (k, texel) in image.data.chunks_mut(4).enumerate() {
            texel.copy_from_slice(&[(k % 5) as f32, 0.0, (k / 5) as f32, if k == 0 { -1.0 } else { 1.0 }]);
        }
        bundle.insert(0, MapKind::Position, image).unwrap();
        bundle.manifest.pieces[0].constants.rest = Some([1.0, 1.0, 2f32.sqrt(), 2f32.sqrt()]);
        bundle.write_tethers().unwrap();
        bundle
    }

    #[test]
    fn the_tethers_of_a_bundle_hold_until_pins_change() {
        let mut bundle = bundle();
        bundle.images.get_mut(&(0, MapKind::Tether)).unwrap().data[3 * 24] = 7.5;
        let mut cloth = Cloth::from_bundle("p", &bundle).unwrap();
        // Stored tethers are used, not made again, where no particle can have more.
        for most in [1, 2, 4] {
            let found = cloth.tethers(most);
            assert_eq!((found.of(24)[0].distance, found.of(24)[0].particle, found.per_particle), (7.5, 0, 1));
        }
        assert_eq!(cloth.tethers(0).anchors, []);
        cloth.set_pinned(0, true).unwrap();
        assert!(cloth.stored_tethers().is_some());
        cloth.set_pinned(4, true).unwrap();
        assert_eq!(cloth.stored_tethers(), None);
        let found = cloth.tethers(2);
        assert_eq!((found.of(24)[0].particle, found.of(24)[0].distance), (4, 4.0));
        assert!(found.of(24)[1].particle == 0 && (found.of(24)[1].distance - 32f32.sqrt()).abs() < 1e-6);
    }

    #[test]
    fn one_stored_tether_is_not_enough_for_two_groups_of_pins() {
        let mut bundle = bundle();
        let image = bundle.images.get_mut(&(0, MapKind::Position)).unwrap();
        image.data[4 * 4 + 3] = -1.0;
        bundle.write_tethers().unwrap();
        bundle.images.get_mut(&(0, MapKind::Tether)).unwrap().data[3 * 24] = 7.5;
        let cloth = Cloth::from_bundle("p", &bundle).unwrap();
        assert_eq!(cloth.tethers(1).of(24)[0].distance, 7.5);
        let found = cloth.tethers(4);
        let of: Vec<u32> = found.of(24).iter().filter(|a| a.exists()).map(|a| a.particle).collect();
        assert_eq!((of, found.of(24)[0].distance), (vec![4, 0], 4.0));
        // Grids that nothing joins have groups of their own.
        bundle.add_piece("q", 5, 5).unwrap();
        let image = bundle.image(0, &MapKind::Position).unwrap().clone();
        bundle.insert(1, MapKind::Position, image).unwrap();
        for piece in [0, 1] {
            let image = bundle.images.get_mut(&(piece, MapKind::Position)).unwrap();
            image.data[4 * 4 + 3] = 1.0;
        }
        bundle.manifest.pieces[1].constants.rest = bundle.manifest.pieces[0].constants.rest;
        bundle.write_tethers().unwrap();
        bundle.images.get_mut(&(1, MapKind::Tether)).unwrap().data[3 * 24] = 7.5;
        assert_eq!(Cloth::from_bundle("p", &bundle).unwrap().tethers(4).of(49)[0].distance, 7.5);
    }

    #[test]
    fn tethers_that_are_not_of_the_cloth_are_not_kept() {
        for anchor in [1.0, 25.0, -7.0] {
            let mut bundle = bundle();
            bundle.images.get_mut(&(0, MapKind::Tether)).unwrap().data[3 * 24 + 1] = anchor;
            let cloth = Cloth::from_bundle("p", &bundle).unwrap();
            // A free particle cannot be an anchor; an index outside the bundle counts as no anchor.
            assert_eq!(cloth.stored_tethers().is_some(), anchor != 1.0, "{anchor}");
        }
    }

    #[test]
    fn a_bundle_without_tethers_gets_them() {
        let mut bundle = bundle();
        bundle.images.remove(&(0, MapKind::Tether));
        let cloth = Cloth::from_bundle("p", &bundle).unwrap();
        assert_eq!(cloth.stored_tethers(), None);
        assert_eq!(cloth.tethers(1).of(3)[0].distance, 3.0);
    }

    #[test]
    fn images_of_rest_lengths_and_no_lengths_at_all() {
        let mut bundle = bundle();
        let constant = Cloth::from_bundle("p", &bundle).unwrap();
        let lengths = bundle.manifest.pieces[0].constants.rest.take().unwrap();
        let data: Vec<f32> = (0..25).flat_map(|_| lengths).collect();
        bundle.images.remove(&(0, MapKind::Tether));
        let none = Cloth::from_bundle("p", &bundle).unwrap();
        assert_eq!(none.tethers(1).anchors.iter().filter(|a| a.exists()).count(), 1);
        bundle.insert(0, MapKind::Rest, Image { width: 5, height: 5, channels: 4, data }).unwrap();
        let image = Cloth::from_bundle("p", &bundle).unwrap();
        assert_eq!(image.tethers(1), constant.tethers(1));
        let mut free = Flat::square("flat", 4).cloth().unwrap();
        assert!(free.tethers(4).is_empty());
        free.set_pinned(0, true).unwrap();
        assert!((free.tethers(1).of(15)[0].distance - 2f32.sqrt()).abs() < 1e-6);
    }
}
