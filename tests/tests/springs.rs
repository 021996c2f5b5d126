//! Rest lengths: chords are distances of texels, arcs are no shorter.

use gimage::options::RestLength;
use gimage_bundle::{Bundle, MapKind, SPRING_STEPS};
use gimage_tests::{asset, build, check, point, texels, texels_of};

/// For every spring inside the grid: its rest length and the distance of its ends.
fn springs(bundle: &Bundle) -> Vec<(f64, f64)> {
    let piece = &bundle.manifest.pieces[0];
    let (w, h) = (i64::from(piece.width), i64::from(piece.height));
    let (all, rest) = (texels_of(bundle, 0), bundle.image(0, &MapKind::Rest).expect("a rest map"));
    let mut out = Vec::new();
    for k in 0..w * h {
        for (c, (di, dj)) in SPRING_STEPS.iter().enumerate() {
            let length = f64::from(rest.at(k as usize)[c]);
            let (i, j) = (k % w + di, k / w + dj);
            if !(0..w).contains(&i) || !(0..h).contains(&j) {
                assert_eq!(length, 0.0, "texel {k}: a spring that leaves the grid");
                continue;
            }
            let (p, q) = (all[k as usize], all[(j * w + i) as usize]);
            let distance = (0..3).map(|c| (f64::from(p[c]) - f64::from(q[c])).powi(2)).sum::<f64>().sqrt();
            out.push((length, distance));
        }
    }
    assert_eq!(out.iter().filter(|s| s.0 > 0.0).count(), piece.counts.springs as usize);
    out
}

#[test]
fn chords_are_distances() {
    for options in [point(3000), texels(3000)] {
        let built = build(&asset("tshirt.glb"), &options).unwrap();
        for (length, distance) in springs(&built.bundle) {
            // Two duplicates side by side are one point, and there is no spring between them.
            assert!((length - distance).abs() <= 1e-6 * distance, "{length} m over {distance} m");
        }
    }
}

#[test]
fn arcs_are_no_shorter_than_chords() {
    for mut options in [point(3000), texels(3000)] {
        options.assemble.rest = RestLength::Arc;
        let built = build(&asset("tshirt.glb"), &options).unwrap();
        check("arc", &built);
        let all = springs(&built.bundle);
        let mut longer = 0.0;
        for &(length, distance) in &all {
            assert!(length >= distance * (1.0 - 1e-6), "an arc of {length} m over a chord of {distance} m");
            longer += length - distance;
        }
        let chords: f64 = all.iter().map(|s| s.1).sum();
        assert!(longer > 0.0 && longer < 0.1 * chords, "{longer} m over {chords} m");
    }
}
