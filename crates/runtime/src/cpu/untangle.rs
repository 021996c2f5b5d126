//! Takes cloth apart that crosses itself or other cloth.
//!
//! Each step finds the edges that pierce faces ([`pierce`]), joins them to contours along which two sheets cross ([`contour`]), decides which side of
//! a contour is wrong ([`side`]), and moves the particles there to the other side ([`shift`]). Contact lets all pairs of particles near contours
//! pass, so that it does not hold them on the wrong side; such particles are loose.
//!
//! Crossings are found again after some steps, everywhere in the first look and then around those that are known ([`Region`]). No decision is kept: a state
//! continues with the same bits. Sources: D. Baraff, A. Witkin,
//! M. Kass, "Untangling Cloth", 2003 (the smaller side of a contour is wrong); P. Volino, N. Magnenat-Thalmann, "Resolving Surface Collisions
//! through Intersection Contour Minimization", 2006 (contours that separate no sheet become shorter). Here the sides are flooded in the mesh
//! at each step, and layers decide between cloths that have different ones.

mod contour;
pub mod loose;
mod net;
pub mod pierce;
mod region;
mod shift;
mod side;
mod stuck;
#[cfg(test)]
mod tests;

use crate::cpu::truncation::surface::{Surface, Texel};
use crate::memory::Tally;
use crate::number::real::V3;
use loose::Loose;
use net::Net;
use pierce::{Finder, Hit};
use region::Region;
use stuck::Ages;

/// Looks in which points stay loose at least.
const KEPT_LOOKS: u32 = 2;

/// Crossings that a look has found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Number of edges that pierce faces.
    pub hits: usize,
    /// Whether some of them are moved.
    pub is_moved: bool,
}

/// The surface of all cloths that have contact, while some of it crosses.
pub struct Untangle {
    pub surface: Surface,
    net: Net,
    finder: Finder,
    /// The part that is searched; none until the first look, and after [`Untangle::be_thorough`].
    region: Option<Region>,
    /// Where points are \[m\]: those of the part that is searched.
    pub at: Vec<V3<f64>>,
    /// Whether a point moves.
    pub free: Vec<bool>,
    /// The layer of each point's cloth.
    layers: Vec<i32>,
    /// Mean distance of neighbours \[m\].
    spacing: f64,
    /// How points move in the next step \[m\], 0 for most of them.
    pub moves: Vec<V3<f64>>,
    /// Which points contact lets each point pass.
    pub loose: Vec<Loose>,
    /// Rings of points around a contour that are loose, of two cloths and of one.
    pub rings: [usize; 2],
    /// Looks since points that need not be loose any more were dropped.
    looks: u32,
    /// Whether contours are left alone for a time that stay where they are.
    pub gives_up: bool,
    ages: Ages,
}

impl Untangle {
    /// That of a surface whose neighbours are `spacing` \[m\] apart; `layer` has the layer of a cloth by its index.
    pub fn new(surface: Surface, spacing: f64, layer: impl Fn(u32) -> i32) -> Self {
        let count = surface.count();
        let layers = (0..count).map(|point| layer(surface.of_point(point)[0].cloth)).collect();
        let net = Net::new(&surface);
        Untangle {
            finder: Finder::new(&surface),
            region: None,
            net,
            surface,
            at: vec![[0.0; 3]; count],
            free: vec![true; count],
            layers,
            spacing,
            moves: vec![[0.0; 3]; count],
            loose: vec![Loose::default(); count],
            rings: loose::RINGS,
            looks: 0,
            gives_up: false,
            ages: Ages::default(),
        }
    }

    /// Lets time \[s\] pass.
    pub fn pass(&mut self, seconds: f64) {
        self.ages.pass(self.surface.count(), seconds);
    }

    /// Begins afresh: nothing is known of where it crosses.
    pub fn forget(&mut self) {
        self.region = Some(Region::new(&self.surface));
        self.ages.forget();
    }

    /// How a point is loose; not at all for no point.
    pub fn loose_at(&self, point: u32) -> Loose {
        self.loose.get(point as usize).copied().unwrap_or_default()
    }

    /// The index of a point's cloth.
    fn cloth(&self, point: u32) -> u32 {
        self.surface.of_point(point as usize)[0].cloth
    }

    /// Searches all of the surface in the next look, and compares features also where it is unlikely that they cross.
    pub fn be_thorough(&mut self) {
        (self.finder.thorough, self.region) = (true, None);
    }

    /// Counts its lists.
    pub fn tally(&self, tally: &mut Tally) {
        [&self.at, &self.moves].into_iter().for_each(|list| tally.state(list));
        tally.state(&self.layers);
        self.ages.tally(tally);
        self.surface.tally(tally);
        self.net.tally(tally);
        self.finder.tally(tally);
    }

    /// Searches around these points too in the next look. Before the first look: there only.
    pub fn search_around(&mut self, points: impl Iterator<Item = u32>) {
        let region = self.region.get_or_insert_with(|| Region::new(&self.surface));
        region.grow(&self.surface, points);
    }

    /// Finds how points move in the next step, and which are loose; `place` has where a texel of the surface, by its number, is \[m\]: f32 values.
    pub fn look(&mut self, place: impl Fn(usize, Texel) -> V3<f64>) -> Found {
        self.moves.fill([0.0; 3]);
        let hits = self.find(place);
        self.ages.see(&self.net, &hits);
        // Each change of what is loose costs the tier safe a search, so that points stay loose for some steps.
        self.looks = if self.looks < KEPT_LOOKS && !hits.is_empty() { self.looks + 1 } else { 0 };
        if self.looks == 0 {
            self.loose.fill(Loose::default());
        }
        if hits.is_empty() {
            return Found::default();
        }
        let mut contours = contour::contours(&self.net, &hits);
        if self.gives_up {
            contours.retain(|contour| !self.ages.is_stuck(&self.net, &hits, contour));
        }
        shift::run(self, &hits, &contours);
        Found { hits: hits.len(), is_moved: !contours.is_empty() }
    }

    fn find(&mut self, place: impl Fn(usize, Texel) -> V3<f64>) -> Vec<Hit> {
        let Untangle { surface, net, finder, region, at, .. } = self;
        let place = |point: usize| {
            let first = surface.starts[point] as usize;
            place(first, surface.texels[first])
        };
        let points_of = |hit: &Hit| net.edges[hit.edge as usize].into_iter().chain(net.faces[hit.face as usize]);
        if let Some(region) = region {
            // A contour that leads out of the region is followed to its end.
            loop {
                region.points(surface).for_each(|point| at[point] = place(point));
                let hits = finder.find_among(net, at, &region.cells);
                if !region.grow(surface, hits.iter().flat_map(points_of)) {
                    // Where cloth has crossed it may soon cross again.
                    if !hits.is_empty() {
                        region.keep(surface, hits.iter().flat_map(points_of));
                    }
                    return hits;
                }
            }
        }
        at.iter_mut().enumerate().for_each(|(point, at)| *at = place(point));
        let hits = finder.find(surface, net, at);
        region.insert(Region::new(surface)).keep(surface, hits.iter().flat_map(points_of));
        hits
    }
}
