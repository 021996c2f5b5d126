//! How a cloth meets colliders: the colliders that it meets, its distance from their surfaces, and its share of their friction.
//!
//! Colliders are chosen by the groups of a cloth, made larger by its thickness, and rougher or smoother by its friction,
//! before a frame begins: cloths of one coat share them, and no step knows of it.

use crate::collider::Collider;
use crate::collider::solid::Solid;
use crate::number::real::Real;
use crate::options::Options;
use crate::scene::Scene;

/// The properties of a cloth that select and change colliders.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Coat {
    /// \[m\]
    thickness: f32,
    /// A factor.
    friction: f32,
    /// Those that it meets.
    collision_groups: u32,
    /// The row of the first of them, where all lists lie one after the other.
    first: usize,
    /// How many there are.
    count: usize,
}

/// The coats of all cloths.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coats {
    /// No two are the same.
    list: Vec<Coat>,
}

/// Lists of colliders begin at multiples of this number of rows (80 bytes each), where a binding may begin.
const ROWS: usize = 16;

impl Coats {
    /// Those of a scene's cloths, a cloth's own thickness before that of the options, and the place of each cloth's coat
    /// among them.
    pub fn new(scene: &Scene, options: &Options) -> (Self, Vec<usize>) {
        let (mut coats, mut places) = (Coats::default(), Vec::new());
        let mut seen = std::collections::HashMap::new();
        let mut end = 0;
        for cloth in &scene.cloths {
            // Of the two zeros one.
            let (thickness, friction) = (cloth.thickness.unwrap_or(options.thickness) + 0.0, cloth.friction + 0.0);
            let collision_groups = cloth.met_groups();
            let kind = (thickness.to_bits(), friction.to_bits(), collision_groups);
            let place = *seen.entry(kind).or_insert(coats.list.len());
            if place == coats.list.len() {
                let (first, count) = (end, scene.met(collision_groups).count());
                end = (first + count).next_multiple_of(ROWS);
                coats.list.push(Coat { thickness, friction, collision_groups, first, count });
            }
            places.push(place);
        }
        (coats, places)
    }

    /// The colliders as cloths meet them, a list a coat.
    pub fn solids<T: Real>(&self, colliders: &[Collider]) -> Vec<Vec<Solid<T>>> {
        let of = |c: &Collider, coat: &Coat| {
            let solid = Solid::new(c).coated(T::of(coat.thickness.into()));
            // Infinity times a depth of 0 is NaN.
            let friction = solid.friction * T::of(coat.friction.into());
            Solid { friction: friction.min(T::of(f32::MAX.into())), ..solid }
        };
        let met =
            |coat: &Coat| colliders.iter().filter(|c| c.is_met(coat.collision_groups)).map(|c| of(c, coat)).collect();
        self.list.iter().map(met).collect()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// The row of a coat's first collider, where all lists lie one after the other.
    pub fn first(&self, place: usize) -> usize {
        self.list.get(place).map_or(0, |coat| coat.first)
    }

    /// The number of colliders of a coat.
    pub fn count(&self, place: usize) -> usize {
        self.list.get(place).map_or(0, |coat| coat.count)
    }
}
