//! Pins and seams of a cloth.

mod support;

use support::tube;

#[test]
fn pins_go_round_the_ring() {
    let mut cloth = tube(9, 4, 4);
    assert_eq!(cloth.ring_count(), 4);
    cloth.set_pinned(2, true).unwrap();
    assert!((0..4).all(|k| cloth.inverse_mass(k) == 0.0) && cloth.inverse_mass(4) > 0.0);
    cloth.set_pinned(0, false).unwrap();
    assert!((0..4).all(|k| cloth.inverse_mass(k) > 0.0));
    assert!(cloth.set_pinned(999, true).is_err());
}
