//! The figure in three garments sits down and walks: with the tier `safe` no two triangles of cloth ever cross.

use crate::motion::{LEAD, Motion};
use gimage::colliders::{ColliderOptions, Tier};
use gimage::pipeline::dress;
use gimage::progress::Quiet;
use gimage_runtime::crossings::{self, Drawn};
use gimage_runtime::{BodyCollider, Cloth, ClothContact, ContactTier, Fate, Options, Scene, Stepper};
use gimage_tests::texels;

const FRAME: f64 = 1.0 / 60.0;

#[test]
fn no_cloth_of_the_figure_in_a_cape_crosses_while_it_sits_down() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("figure_cape.glb");
    std::fs::write(&file, gimage_assets::figure_in_cape()).unwrap();
    let options = ColliderOptions { tier: Tier::Capsules, ..ColliderOptions::default() };
    let built = dress(&file, &texels(2048), &options, &Quiet).expect("the figure dresses");
    let names: Vec<&str> = built.bundle.manifest.pieces.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["Skirt", "T-shirt", "Cape"]);
    let mut cloth = Cloth::from_bundle("figure", &built.bundle).unwrap();
    cloth.contact = Some(ClothContact { tier: ContactTier::Safe, ..ClothContact::default() });
    // A point of the T-shirt at a corner of its image has two quads, which lie on one another.
    let start = crossings::find(&[Drawn::new(&cloth)], 1).unwrap();
    assert_eq!(start.total(), 0, "{start:?}");

    let motion = Motion::new(&file, &cloth, "Sit");
    cloth.follow_joints(&motion.matrices(&cloth, -LEAD)).unwrap();
    let body = BodyCollider::of_bundle(&built.bundle);
    let colliders = body.iter().map(|part| part.collider).collect();
    let scene = Scene { cloths: vec![cloth.clone()], colliders, ..Scene::new("figure in a cape") };
    let mut stepper = Stepper::on_cpu(scene, Options::default()).unwrap();
    // Until it sits: 2.1 s of the clip.
    let (lead, frames) = ((LEAD / FRAME).round() as usize, (2.1 / FRAME).round() as usize);
    let mut lowest = f64::INFINITY;
    for frame in 1..=lead + frames {
        let matrices = motion.matrices(&cloth, (frame as f64 - lead as f64) * FRAME);
        stepper.set_joints(0, &matrices).unwrap();
        stepper.move_body(0, 0, &body, &matrices).unwrap();
        stepper.advance(FRAME).unwrap();
        let now = stepper.positions(0).unwrap();
        let found = crossings::find(&[Drawn::at(&cloth, now)], 1).unwrap();
        assert_eq!((found.total(), found.not_finite), (0, 0), "frame {frame}: {found:?}");
        let tall = now.iter().map(|p| f64::from(p[1])).fold(f64::NEG_INFINITY, f64::max);
        lowest = lowest.min(tall);
    }
    assert!(lowest < 1.2, "the collar is at {lowest} m when it sits");
    let fates: Vec<_> = stepper.findings().iter().filter(|f| matches!(f.fate, Fate::Crossed { .. })).collect();
    assert!(fates.is_empty(), "{fates:?}");
}
