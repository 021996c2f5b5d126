//! Takes cloth apart that crosses itself or other cloth.
//!
//! Each step finds the edges that pierce faces ([`pierce`]), joins them to contours along which two sheets cross ([`contour`]), decides which side of
//! a contour is wrong ([`side`]), and moves the particles there to the other side ([`shift`]). Contact lets all pairs of particles near contours
//! pass, so that it does not hold them on the wrong side; such particles are loose.
//!
//! Crossings are found again after every step, and no decision is kept: a state continues with the same bits. Sources: D. Baraff, A. Witkin,
//! M. Kass, "Untangling Cloth", 2003 (the smaller side of a contour is wrong); P. Volino, N. Magnenat-Thalmann, "Resolving Surface Collisions
//! through Intersection Contour Minimization", 2006 (contours that separate no sheet become shorter). Here the sides are flooded in the mesh
//! at each step, and layers decide between cloths that have different ones.

mod contour;
pub mod loose;
mod net;
mod pierce;
mod shift;
mod side;
#[cfg(test)]
mod tests;

use crate::cpu::truncation::surface::Surface;
use crate::memory::Tally;
use crate::number::real::V3;
use loose::Loose;
use net::Net;
use pierce::Finder;

/// Looks in which points stay loose at least.
const KEPT_LOOKS: u32 = 2;

/// The surface of all cloths that have contact, while some of it crosses.
pub struct Untangle {
    pub surface: Surface,
    net: Net,
    finder: Finder,
    /// Where points are \[m\].
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
}

impl Untangle {
    /// That of a surface whose neighbours are `spacing` \[m\] apart; `layer` has the layer of a cloth by its index.
    pub fn new(surface: Surface, spacing: f64, layer: impl Fn(u32) -> i32) -> Self {
        let count = surface.count();
        let layers = (0..count).map(|point| layer(surface.of_point(point)[0].cloth)).collect();
        let net = Net::new(&surface);
        Untangle {
            finder: Finder::new(&surface),
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
        }
    }

    /// How a point is loose; not at all for no point.
    pub fn loose_at(&self, point: u32) -> Loose {
        self.loose.get(point as usize).copied().unwrap_or_default()
    }

    /// The index of a point's cloth.
    fn cloth(&self, point: u32) -> u32 {
        self.surface.of_point(point as usize)[0].cloth
    }

    /// Compares all features from the next look on, also where it is unlikely that they cross.
    pub fn be_thorough(&mut self) {
        self.finder.thorough = true;
    }

    /// Counts its lists.
    pub fn tally(&self, tally: &mut Tally) {
        [&self.at, &self.moves].into_iter().for_each(|list| tally.state(list));
        tally.state(&self.layers);
        self.surface.tally(tally);
        self.net.tally(tally);
        self.finder.tally(tally);
    }

    /// Finds how points move in the next step, and which are loose, from where they are. Returns the number of edges that pierce faces.
    pub fn look(&mut self) -> usize {
        self.moves.fill([0.0; 3]);
        let hits = self.finder.find(&self.surface, &self.net, &self.at);
        // Each change of what is loose costs the tier safe a search, so that points stay loose for some steps.
        self.looks = if self.looks < KEPT_LOOKS && !hits.is_empty() { self.looks + 1 } else { 0 };
        if self.looks == 0 {
            self.loose.fill(Loose::default());
        }
        if hits.is_empty() {
            return 0;
        }
        let contours = contour::contours(&self.net, &hits);
        shift::run(self, &hits, &contours);
        hits.len()
    }
}
