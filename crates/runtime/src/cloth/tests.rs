use gimage_bundle::manifest::ShellEntry;
use gimage_bundle::{Bundle, Image, MapKind};

use super::*;

fn parts() -> Parts {
    let cloth = Flat::square("flat", 3).cloth().unwrap();
    let (grids, positions) = (cloth.grids().to_vec(), cloth.positions().to_vec());
    let (particles, rest, mass) = (cloth.particles().to_vec(), cloth.rest().clone(), Mass::Constant(0.2 / 9.0));
    Parts { name: "flat".into(), grids, positions, particles, rest, mass }
}

#[test]
fn a_flat_cloth_has_constant_lengths_and_the_mass_asked_for() {
    let cloth = Flat { width: 5, height: 3, ..Flat::square("flat", 2) }.cloth().unwrap();
    assert_eq!(cloth.rest(), &Rest::Constant(vec![[0.25, 0.5, 0.3125f32.sqrt(), 0.3125f32.sqrt()]]));
    assert_eq!((cloth.len(), cloth.positions()[14]), (15, [1.0, 0.0, 1.0]));
    assert!(((0..15).map(|k| cloth.mass(k)).sum::<f32>() - 0.2).abs() < 1e-6);
    assert_eq!((cloth.ring_count(), cloth.directions()), (0, [true; 4]));
}

#[test]
fn every_fault_is_refused() {
    type Spoil = fn(&mut Parts);
    let spoils: [(&str, Spoil); 10] = [
        ("at least one grid", |p| p.grids.clear()),
        ("2 x 2", |p| p.grids[0].width = 1),
        ("do not follow", |p| p.grids[0].first = 3),
        ("at most", |p| (p.grids[0].width, p.grids[0].height) = (1 << 16, 1 << 16)),
        ("positions", |p| p.positions.truncate(1)),
        ("not finite", |p| p.positions[4][1] = f32::NAN),
        ("rest length", |p| p.rest = Rest::Constant(vec![[-1.0; 4]])),
        ("masses", |p| p.mass = Mass::Image(vec![1.0])),
        ("mass", |p| p.mass = Mass::Constant(0.0)),
        ("seam link", |p| p.particles[0] = Particle::Free { next: Some(7) }),
    ];
    for (words, spoil) in spoils {
        let mut parts = parts();
        spoil(&mut parts);
        let error = Cloth::new(parts).unwrap_err().to_string();
        assert!(error.contains(words), "{words}: {error}");
    }
}

#[test]
fn a_bundle_of_two_pieces_is_one_cloth() {
    let mut bundle = Bundle::new("test");
    for (piece, (w, h)) in [(2u32, 3u32), (3, 2)].into_iter().enumerate() {
        bundle.add_piece("p", w, h).unwrap();
        let mut image = Image::zeros(w, h, 4);
        for (k, texel) in image.data.chunks_mut(4).enumerate() {
            texel.copy_from_slice(&[k as f32, piece as f32, 0.0, 1.0]);
        }
        image.data[3] = -1.0;
        bundle.insert(piece, MapKind::Position, image).unwrap();
    }
    let cloth = Cloth::from_bundle("two", &bundle).unwrap();
    assert_eq!((cloth.grids().len(), cloth.len(), cloth.rest()), (2, 12, &Rest::None));
    assert_eq!((cloth.positions()[7], cloth.inverse_mass(6)), ([1.0, 1.0, 0.0], 0.0));
    bundle.manifest.pieces[0].constants.rest = Some([1.0; 4]);
    assert_eq!(Cloth::from_bundle("two", &bundle).unwrap().rest(), &Rest::Constant(vec![[1.0; 4], [0.0; 4]]));
    bundle.insert(1, MapKind::Mass, Image { width: 3, height: 2, channels: 1, data: vec![2.0; 6] }).unwrap();
    bundle.insert(1, MapKind::Rest, Image { width: 3, height: 2, channels: 4, data: vec![3.0; 24] }).unwrap();
    let cloth = Cloth::from_bundle("two", &bundle).unwrap();
    let Rest::Image(rest) = cloth.rest() else { panic!("an image is needed") };
    assert_eq!((rest[5], rest[6], cloth.mass(5), cloth.mass(6)), ([1.0; 4], [3.0; 4], 1e-3, 2.0));
    // The thickest piece decides, which keeps half of its thickness away from colliders.
    assert_eq!(cloth.thickness, None);
    for (piece, thickness) in [(0, 0.001), (1, 0.004)] {
        let shell = ShellEntry { layer: "mid".into(), thickness, ..ShellEntry::default() };
        bundle.manifest.pieces[piece].shell = Some(shell);
    }
    assert_eq!(Cloth::from_bundle("two", &bundle).unwrap().thickness, Some(0.002));
    bundle.manifest.pieces[0].shell.as_mut().unwrap().layer = "outer".into();
    bundle.manifest.pieces[1].shell.as_mut().unwrap().thickness = f64::MAX;
    assert_eq!(Cloth::from_bundle("two", &bundle).unwrap().thickness, Some(0.001));
    // A map of the second piece alone selects no particle of the first.
    let values = Cloth::map_values(&bundle, &MapKind::Mass, 0);
    assert_eq!(cloth.select(&Select::Map { values: &values, above: 1.0 }).unwrap(), [6, 7, 8, 9, 10, 11]);
}
