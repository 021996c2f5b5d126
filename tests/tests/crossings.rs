//! Triangles of the sample garments that cross at rest.

use gimage_runtime::Cloth;
use gimage_runtime::crossings::{self, Drawn};
use gimage_tests::{asset, build, texels};

/// Pairs that cross at rest in the bundles of 4,096 texels, at most. They are neighbours on the surface: the resampled surface folds
/// over itself by less than 2 mm in a few cells.
const MOST: [(&str, u64); 5] = [("cape", 0), ("dress", 0), ("skirt", 0), ("trousers", 32), ("tshirt", 8)];

#[test]
fn sample_garments_have_few_crossings_at_rest() {
    for (name, most) in MOST {
        let built = build(&asset(&format!("{name}.glb")), &texels(4096)).unwrap();
        let cloth = Cloth::from_bundle(name, &built.bundle).unwrap();
        let found = crossings::find(&[Drawn::new(&cloth)], 64).unwrap();
        let pairs: Vec<_> = found.worst.iter().map(|c| (c.first.texel, c.second.texel, c.depth)).collect();
        assert!(found.within <= most && found.deepest < 2e-3, "{name}: {} pairs: {pairs:?}", found.within);
        assert!(found.triangles > 7_000 && found.not_finite == 0, "{name}: {found:?}");
        // Across a seam, neighbours are far apart in the image.
        let near = |c: &crossings::Crossing| {
            let [p, q] = [c.first, c.second].map(|place| {
                let grid = &cloth.grids()[place.grid];
                cloth.positions()[(grid.first + place.texel[1] * grid.width + place.texel[0]) as usize]
            });
            (0..3).all(|k| (p[k] - q[k]).abs() < 0.1)
        };
        assert!(found.worst.iter().all(near), "{name}: {pairs:?}");
    }
}
