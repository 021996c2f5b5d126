use gimage_bundle::manifest::{Joint, Skeleton};
use gimage_bundle::{Bundle, Image, MapKind};

use super::*;
use crate::Flat;

const STILL: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
/// A quarter turn about z, then 1 m along x.
const TURNED: [f32; 16] = [0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0];

fn joint(name: &str) -> SkinJoint {
    SkinJoint { name: name.into(), parent: None, inverse_bind: STILL }
}

/// A square of 3 x 3 particles over x and z from 0 to 1; each follows the first joint, the second, or both alike.
fn cloth() -> Cloth {
    let mut cloth = Flat::square("flat", 3).cloth().unwrap();
    let of = |k: usize| match k % 3 {
        0 => Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] },
        1 => Influence { joints: [1, 0, 7, 7], weights: [2.0, 2.0, 0.0, 0.0] },
        _ => Influence { joints: [1; 4], weights: [0.25; 4] },
    };
    cloth.set_skin(vec![joint("hip"), joint("knee")], &(0..9).map(of).collect::<Vec<_>>()).unwrap();
    cloth
}

#[test]
fn particles_are_where_linear_blending_puts_them() {
    let mut cloth = cloth();
    assert!(!cloth.follows_joints());
    cloth.follow_joints(&[STILL, TURNED]).unwrap();
    assert!(cloth.follows_joints());
    // (x, 0, z) goes to (x, 0, z), to (1, x, z), or to the middle of both.
    assert_eq!(cloth.positions()[3], [0.0, 0.0, 0.5]);
    assert_eq!(cloth.positions()[4], [0.75, 0.25, 0.5]);
    assert_eq!(cloth.positions()[8], [1.0, 1.0, 1.0]);
    // Always from the positions at rest.
    cloth.follow_joints(&[STILL, STILL]).unwrap();
    assert_eq!(cloth.positions(), Flat::square("flat", 3).cloth().unwrap().positions());
}

#[test]
fn matrices_are_those_of_joints_times_their_inverse_binds() {
    let mut cloth = cloth();
    let mut moved = STILL;
    moved[12..15].copy_from_slice(&[0.0, -2.0, 0.0]);
    let joints = vec![SkinJoint { inverse_bind: moved, ..joint("hip") }];
    cloth.set_skin(joints, &[Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] }; 9]).unwrap();
    let skin = cloth.skin().unwrap();
    // -2 m along y, turned by a quarter about z: 2 m along x.
    let mut expected = TURNED;
    expected[12] = 3.0;
    assert_eq!(skin.matrices(&[TURNED]).unwrap(), [expected]);
    assert!(skin.matrices(&[]).unwrap_err().to_string().contains("0 joint matrices for 1 joints"));
}

#[test]
fn influences_that_name_no_joint_or_have_no_weight_are_refused() {
    let sound = Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] };
    let bad = |one: Influence| {
        let mut list = [sound; 9];
        list[4] = one;
        let error = Flat::square("flat", 3).cloth().unwrap().set_skin(vec![joint("hip")], &list).unwrap_err();
        assert!(error.to_string().contains("particle 4"), "{error}");
        error.to_string()
    };
    assert!(bad(Influence { joints: [1, 0, 0, 0], ..sound }).contains("does not exist"));
    assert!(bad(Influence { weights: [0.0; 4], ..sound }).contains("all 0"));
    assert!(bad(Influence { weights: [f32::NAN; 4], ..sound }).contains("not finite"));
    assert!(bad(Influence { weights: [2.0, -1.0, 0.0, 0.0], ..sound }).contains("negative"));
    let mut cloth = Flat::square("flat", 3).cloth().unwrap();
    assert!(cloth.set_skin(vec![joint("hip")], &[sound; 8]).unwrap_err().to_string().contains("8 influences"));
    assert!(cloth.follow_joints(&[STILL]).unwrap_err().to_string().contains("no joints"));
    cloth.set_skin(vec![joint("hip")], &[sound; 9]).unwrap();
    let mut infinite = STILL;
    infinite[12] = f32::INFINITY;
    assert!(cloth.follow_joints(&[infinite]).unwrap_err().to_string().contains("joint 0 (hip)"));
    assert!(cloth.follow_joints(&[STILL; 2]).unwrap_err().to_string().contains("2 joint matrices"));
}

/// A bundle of one piece of 2 x 2 particles on two joints, with as many sets as are asked for.
fn bundle(sets: u8) -> Bundle {
    let mut bundle = Bundle::new("test");
    bundle.add_piece("p", 2, 2).unwrap();
    let image = |channels: u32, at: fn(usize) -> f32| {
        let data = (0..4 * channels as usize).map(at).collect();
        Image { width: 2, height: 2, channels, data }
    };
    bundle.insert(0, MapKind::Position, image(4, |n| if n % 4 == 3 { 1.0 } else { (n / 4 % 2) as f32 })).unwrap();
    for set in 0..sets {
        bundle.insert(0, MapKind::Joints(set), image(4, |n| (n % 2) as f32)).unwrap();
        bundle.insert(0, MapKind::Weights(set), image(4, |_| 0.25)).unwrap();
    }
    let joints = ["hip", "knee"].map(|name| Joint { name: name.into(), parent: None, inverse_bind: STILL });
    bundle.manifest.skeleton = Some(Skeleton { joints: joints.to_vec() });
    bundle
}

#[test]
fn a_bundle_brings_its_joints_and_all_their_sets() {
    assert_eq!(Cloth::from_bundle("p", &bundle(0)).unwrap().skin(), None);
    let cloth = Cloth::from_bundle("p", &bundle(2)).unwrap();
    let skin = cloth.skin().unwrap();
    assert_eq!((skin.sets, skin.joints()[1].name.as_str()), (2, "knee"));
    assert_eq!(skin.influences[7], Influence { joints: [0, 1, 0, 1], weights: [0.125; 4] });
    // A bundle with a piece that follows no joint follows none.
    let mut mixed = bundle(1);
    mixed.add_piece("q", 2, 2).unwrap();
    let image = mixed.image(0, &MapKind::Position).unwrap().clone();
    mixed.insert(1, MapKind::Position, image).unwrap();
    assert_eq!(Cloth::from_bundle("p", &mixed).unwrap().skin(), None);
}
