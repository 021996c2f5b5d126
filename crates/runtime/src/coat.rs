//! What a cloth is to colliders: how far it keeps from them, and how much of their friction holds it.
//!
//! Colliders are made larger by the thickness of a cloth, and rougher or smoother by its friction, before a frame begins:
//! cloths of one coat share them, and no step knows of it.

use crate::cloth::Cloth;
use crate::collider::Collider;
use crate::collider::solid::Solid;
use crate::number::real::Real;
use crate::options::Options;

/// What colliders are changed by.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Coat {
    /// \[m\]
    thickness: f32,
    /// A factor.
    friction: f32,
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
    /// Those of cloths, a cloth's own thickness before that of the options, and the place of each cloth's coat among them.
    pub fn new(cloths: &[Cloth], options: &Options) -> (Self, Vec<usize>) {
        let (mut coats, mut places) = (Coats::default(), Vec::new());
        let mut seen = std::collections::HashMap::new();
        for cloth in cloths {
            // Of the two zeros one.
            let coat =
                Coat { thickness: cloth.thickness.unwrap_or(options.thickness) + 0.0, friction: cloth.friction + 0.0 };
            let place = *seen.entry([coat.thickness, coat.friction].map(f32::to_bits)).or_insert(coats.list.len());
            if place == coats.list.len() {
                coats.list.push(coat);
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
        self.list.iter().map(|coat| colliders.iter().map(|c| of(c, coat)).collect()).collect()
    }

    /// Rows from list to list where all lie in one buffer; 0 for a single one.
    pub fn stride(&self, colliders: usize) -> usize {
        if self.list.len() > 1 { colliders.next_multiple_of(ROWS) } else { 0 }
    }
}
