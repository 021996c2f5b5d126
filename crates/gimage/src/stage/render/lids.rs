//! The drawn mesh keeps the caps that are left out of the cloth. The rim of a cap moves with the cloth; its middle, deep inside of the opening, stays on the
//! limb. Bound to the rim alone, the middle would swing as the rim turns.

use super::bind::Bound;
use super::classes::Classes;
use super::trace::Trace;

/// Distance from the cloth, as shares of the radius of the opening, from which a vertex leaves the cloth and up to which it is on the skin.
const LEAVES: [f64; 2] = [0.15, 0.45];

/// Gives the vertices of caps that follow joints their blend from the cloth to the skin. O(n).
pub(super) fn to_skin(classes: &Classes, trace: &Trace, bound: &mut [Option<Bound>]) {
    for (v, &class) in classes.of.iter().enumerate() {
        let radius = f64::from(trace.lid(v as u32));
        let Some(Some(bound)) = bound.get_mut(class as usize).filter(|_| radius > 0.0) else { continue };
        if trace.joints(v as u32).is_none() {
            continue;
        }
        let along = ((bound.far / radius - LEAVES[0]) / (LEAVES[1] - LEAVES[0])).clamp(0.0, 1.0);
        bound.binding.blend = bound.binding.blend.min((1.0 - along * along * (3.0 - 2.0 * along)) as f32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::render::bind::UNBOUND;

    #[test]
    fn a_lid_goes_over_from_the_cloth_to_the_skin() {
        let positions: Vec<[f64; 3]> = (0..6).map(|k| [f64::from(k), 0.0, 0.0]).collect();
        let follows = ([0.0; 4], [1.0, 0.0, 0.0, 0.0]);
        let trace = Trace {
            is_cloth: vec![true; 6],
            lids: vec![0.1, 0.1, 0.1, 0.1, 0.0, 0.1],
            influences: (0..6).map(|k| if k == 5 { Default::default() } else { follows }).collect(),
            sets: 1,
            positions,
            ..Trace::default()
        };
        let far = [0.0, 0.014, 0.03, 0.05, 0.05, 0.05];
        let mut bound: Vec<_> = far.map(|far| Some(Bound { binding: UNBOUND, far, miss: 0.0 })).into();
        to_skin(&Classes::new(&trace), &trace, &mut bound);
        let blends: Vec<f32> = bound.iter().flatten().map(|b| b.binding.blend).collect();
        assert_eq!((blends[0], blends[1], blends[3]), (1.0, 1.0, 0.0));
        assert!((blends[2] - 0.5).abs() < 1e-6);
        // Not a lid, and one that follows no joint.
        assert_eq!(blends[4..], [1.0, 1.0]);
    }
}
