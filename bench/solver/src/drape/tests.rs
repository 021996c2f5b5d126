use super::piece::PLATE;
use super::*;

#[test]
fn a_piece_on_a_table_covers_its_ring() {
    let piece = Piece::new(4, 0, &Material::default(), 1.0).unwrap();
    let ring = std::f64::consts::PI * (RIM * RIM - PLATE * PLATE);
    let found = Shadow::of(&piece, &piece.flat()).area();
    assert!((found / ring - 1.0).abs() < 0.01, "{found} for {ring}");
    // Folded in half it covers half of it; the triangles of the other half have turned over.
    let folded: Vec<[f64; 4]> = piece.flat().iter().map(|p| [p[0].abs(), p[1], p[2], 1.0]).collect();
    let half = Shadow::of(&piece, &folded).area();
    assert!((half / ring - 0.5).abs() < 0.01, "{half} for {ring}");
}

#[test]
fn folds_of_a_rim_are_counted_once_each() {
    let rim = |waves: f64, height: f64| -> Vec<f64> {
        (0..48).map(|k| RIM - height * (1.0 + (waves * std::f64::consts::TAU * f64::from(k) / 48.0).cos())).collect()
    };
    assert_eq!([0.0, 2.0, 5.0, 7.0].map(|waves| folds(&rim(waves, 0.02))), [0, 2, 5, 7]);
    assert_eq!(folds(&rim(5.0, 1e-4)), 0);
}

#[test]
fn a_start_is_the_same_on_every_grid() {
    let at = |along: u32, column: u32| {
        let piece = Piece::new(along, 3, &Material::default(), 1.0).unwrap();
        piece.cloth.positions()[((along + 1) * (AROUND_OF * along + 1) + column * along) as usize]
    };
    for column in 0..AROUND_OF {
        let (a, b) = (at(2, column), at(6, column));
        assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-6), "{a:?} {b:?}");
    }
}

const AROUND_OF: u32 = 12;

#[test]
fn fabrics_keep_their_order_on_two_grids() {
    let order = ["silk", "denim", "felt"];
    let drapes = |along| order.map(|name| settle(name, (along, None), 0).unwrap().drape);
    let both = [drapes(3), drapes(5)];
    for drapes in both {
        assert!(drapes.is_sorted(), "{drapes:?}");
        assert!(drapes[0] > 0.1 && drapes[2] < 1.0 && drapes[2] - drapes[0] > 0.3, "{drapes:?}");
    }
    for (name, (coarse, fine)) in order.iter().zip(both[0].iter().zip(both[1])) {
        assert!((coarse - fine).abs() < 0.1, "{name}: {coarse} {fine}");
    }
}
