//! Twin of shaders/shadow.wgsl: a cloth as other cloths see it for some steps.

use std::sync::Arc;

use super::extents;
use super::tiles::{LANES_OF_TILE, Tiles};
use crate::cpu::fabric::tree::{self, Tree};
use crate::memory::Tally;
use crate::number::aligned::Aligned;
use crate::number::real::{Real, V3, scale, sub, xyz};

/// Places are those of [`Tiles`].
pub struct Shadow<T: Real> {
    pub tree: Tree<T>,
    pub now: [Aligned<T>; 3],
    /// \[m/s\]
    pub velocity: [Aligned<T>; 3],
    /// Inverse masses; 0 for cloth that is asleep.
    pub w: Aligned<T>,
    /// The same of each place, for those who read single particles: its position and inverse mass, and its velocity.
    pub each: Vec<[[T; 4]; 2]>,
    pub out: Aligned<T>,
    pub rest: [Aligned<T>; 3],
    /// As [`Tiles::crossing2`].
    pub crossing2: Arc<Vec<T>>,
    /// Particles near those of cloth that crosses theirs at rest.
    pub crossed: Vec<bool>,
    /// Particles that may pass loose ones of other cloths.
    pub loose: Vec<bool>,
    /// \[m\]
    pub distance: T,
    pub friction: T,
    /// Length of the frame \[s\].
    pub length: T,
    /// Of cloth that is asleep: the speed \[m/s\] above which particles that come into contact wake it. Infinite for all others.
    pub wakes_at: T,
}

/// The beginning of a frame of a cloth.
pub struct Dawn<'a, T> {
    /// Positions and previous ones, by texels.
    pub now: &'a [[T; 4]],
    pub before: &'a [[T; 4]],
    /// One over the length of the last step \[1/s\]; 0 for cloth that is asleep.
    pub rate: T,
    /// Length of the frame \[s\].
    pub length: T,
    /// As [`Shadow::wakes_at`].
    pub wakes_at: T,
}

impl<T: Real> Shadow<T> {
    /// Of particles at rest.
    pub fn new(tiles: &Tiles<T>, distance: T, friction: T) -> Self {
        let list = || std::array::from_fn(|_| Aligned::zeros(tiles.texel.len()));
        Shadow {
            tree: Tree::new(tiles),
            now: list(),
            velocity: list(),
            w: Aligned::zeros(tiles.texel.len()),
            each: vec![[[T::of(0.0); 4]; 2]; tiles.texel.len()],
            out: tiles.out.clone(),
            rest: tiles.rest.clone(),
            crossing2: tiles.crossing2.clone(),
            crossed: tiles.crossed.clone(),
            loose: Vec::new(),
            distance,
            friction,
            length: T::of(0.0),
            wakes_at: T::of(f64::INFINITY),
        }
    }

    /// Takes in where particles are, and makes boxes around all that they pass in the frame.
    pub fn follow(&mut self, tiles: &Tiles<T>, dawn: &Dawn<T>) {
        (self.length, self.wakes_at) = (dawn.length, dawn.wakes_at);
        for tile in 0..tiles.count() {
            for place in tile * LANES_OF_TILE..(tile + 1) * LANES_OF_TILE {
                let Some(p) = dawn.now.get(tiles.texel[place] as usize) else { continue };
                let (at, was) = (xyz(*p), xyz(dawn.before[tiles.texel[place] as usize]));
                let velocity = scale(sub(at, was), dawn.rate);
                self.w[place] = if dawn.rate > T::of(0.0) { p[3].max(T::of(0.0)) } else { T::of(0.0) };
                for c in 0..3 {
                    (self.now[c][place], self.velocity[c][place]) = (at[c], velocity[c]);
                }
                let ([x, y, z], [u, v, w]) = (at, velocity);
                self.each[place] = [[x, y, z, self.w[place]], [u, v, w, T::of(0.0)]];
            }
            self.tree.nodes[tile] = extents::around(self, tiles, tile);
        }
        tree::run(&mut self.tree);
    }

    /// Numbers that it takes.
    pub fn tally(&self, tally: &mut Tally) {
        self.tree.tally(tally);
        let vectors = self.now.iter().chain(&self.velocity).chain(&self.rest);
        vectors.chain([&self.w, &self.out]).for_each(|list| tally.state(list));
        tally.state(&self.each);
        [&self.crossed, &self.loose].into_iter().for_each(|list| tally.state(list));
    }

    /// A position.
    #[inline(always)]
    pub fn at(&self, place: usize) -> V3<T> {
        xyz(self.each[place][0])
    }

    /// A velocity.
    #[inline(always)]
    pub fn velocity_at(&self, place: usize) -> V3<T> {
        xyz(self.each[place][1])
    }
}
