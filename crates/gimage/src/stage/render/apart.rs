//! Accessories far from all cloth, such as gums that were taken for cloth, stay on their joints: the nearest garment would swing them about.

use std::collections::BTreeMap;

use super::bind::Bound;
use super::classes::Classes;
use super::trace::Trace;

/// Takes accessories off the pieces that are farther than `far` \[m\] and follow joints, and returns their numbers. Owners from `pieces` on are accessories. O(n log n).
pub(super) fn leave(
    classes: &Classes,
    trace: &Trace,
    bound: &mut [Option<Bound>],
    pieces: usize,
    far: f64,
) -> Vec<usize> {
    let rider = |class: u32| (*classes.owner.get(class as usize)? as usize).checked_sub(pieces);
    let mut apart: BTreeMap<usize, bool> = BTreeMap::new();
    for (v, &class) in classes.of.iter().enumerate() {
        let (Some(rider), Some(Some(bound))) = (rider(class), bound.get(class as usize)) else { continue };
        *apart.entry(rider).or_insert(true) &= bound.far > far && trace.joints(v as u32).is_some();
    }
    for (class, slot) in bound.iter_mut().enumerate() {
        if rider(class as u32).is_some_and(|rider| apart.get(&rider) == Some(&true)) {
            *slot = None;
        }
    }
    apart.into_iter().filter(|(_, is_apart)| *is_apart).map(|(rider, _)| rider).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::render::bind::UNBOUND;

    #[test]
    fn an_accessory_far_from_all_cloth_stays_on_its_joints() {
        let follows = ([0.0; 4], [1.0, 0.0, 0.0, 0.0]);
        let trace = Trace {
            is_cloth: vec![true; 6],
            positions: (0..6).map(|k| [f64::from(k), 0.0, 0.0]).collect(),
            influences: (0..6).map(|k| if k < 4 { follows } else { Default::default() }).collect(),
            sets: 1,
            ..Trace::default()
        };
        let mut classes = Classes::new(&trace);
        // A piece; gums; a button of which one vertex is near; and far away what follows no joint.
        classes.owner = vec![0, 1, 2, 2, 3, 3];
        let far = [9.0, 0.2, 0.2, 0.01, 0.2, 0.2];
        let mut bound: Vec<_> = far.map(|far| Some(Bound { binding: UNBOUND, far, miss: 0.0 })).into();
        assert_eq!(leave(&classes, &trace, &mut bound, 1, 0.1), [0]);
        assert_eq!(bound.iter().map(Option::is_some).collect::<Vec<_>>(), [true, false, true, true, true, true]);
    }
}
