//! The lists of a cloth's state on the CPU, out and in.

use std::sync::Arc;

use bytemuck::cast_slice;

use super::body::Body;
use super::route::far;
use crate::choose::Settings;
use crate::cloth::{Cloth, Rest, Tethers};
use crate::state::{Layout, Part};

impl Body<f32> {
    /// The lists, in the order of a layout that [`Layout::of`] made.
    pub fn save(&self, layout: &Layout) -> Vec<u32> {
        let mut words: Vec<u32> = Vec::with_capacity(layout.words());
        words.extend_from_slice(cast_slice(&self.now));
        words.extend_from_slice(cast_slice(&self.before));
        if layout.good {
            words.extend_from_slice(cast_slice(&self.good));
        }
        if layout.lost {
            words.extend_from_slice(cast_slice(&self.lost()));
        }
        if layout.cut {
            words.extend_from_slice(&self.holes);
        }
        if layout.rest {
            words.extend_from_slice(cast_slice(&self.image));
        }
        if let Some(held) = self.held.as_ref().filter(|_| layout.slots > 0) {
            words.extend(held.anchors.iter().zip(&held.most).flat_map(|(anchor, most)| [*anchor, most.to_bits()]));
        }
        words
    }

    /// The low bits that positions are too coarse for; 0 if positions were changed from outside, as the next frame begins so.
    fn lost(&self) -> Vec<[f32; 4]> {
        let mut texels = vec![[0.0; 4]; self.now.len()];
        if let Some(fabric) = self.fabric.as_ref().filter(|_| !self.edited) {
            fabric.store_lost(&mut texels);
        }
        texels
    }

    /// Takes over the lists of a state. Levels, cells and tethers that cuts have changed are rebuilt from it.
    pub fn load(&mut self, (cloth, tethers): (&Cloth, &Tethers), options: &Settings, layout: &Layout, words: &[u32]) {
        if layout.cut || !self.holes.is_empty() {
            // Positions, velocities included, follow below.
            *self = Body::new(cloth, tethers, options, 0.0);
        }
        let vectors = |part| cast_slice::<u32, [f32; 4]>(&words[layout.range(part)]);
        self.now.copy_from_slice(vectors(Part::Now));
        self.before.copy_from_slice(vectors(Part::Before));
        self.good.copy_from_slice(vectors(Part::Good));
        if layout.cut {
            self.open(cloth, tethers);
            self.holes.copy_from_slice(&words[layout.range(Part::Holes)]);
            if layout.rest {
                Arc::make_mut(&mut self.image).copy_from_slice(vectors(Part::Rest));
            }
            self.hold(cast_slice(&words[layout.range(Part::Tethers)]));
            self.cut = !matches!(cloth.rest(), Rest::None);
        }
        self.edited = true;
        self.forget_surface();
        self.begin();
        if let Some(fabric) = self.fabric.as_mut().filter(|_| layout.lost) {
            fabric.load_lost(vectors(Part::Lost));
        }
        self.faulty = None;
        self.forget_normals();
    }

    /// Tethers that cuts have left: pin and length of each.
    fn hold(&mut self, rows: &[[u32; 2]]) {
        let (Some(held), Some(fabric)) = (&mut self.held, &mut self.fabric) else { return };
        for (n, [anchor, most]) in rows.iter().enumerate() {
            held.anchors[n] = *anchor;
            held.most[n] = if *anchor == u32::MAX { far() } else { f32::from_bits(*most) };
        }
        fabric.hold(held.slots, |t| (held.most[t] < far()).then_some((held.anchors[t], held.most[t])));
    }
}
