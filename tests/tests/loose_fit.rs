//! Solids that are far from the body matter where the cloth meets them, and not where it meets the body's surface.

use gimage::colliders::{ColliderOptions, Tier};
use gimage::pipeline::dress;
use gimage::progress::Quiet;
use gimage::record::Severity;
use gimage_tests::{asset, texels};

#[test]
fn solids_far_from_the_body_are_a_warning_where_cloth_meets_them() {
    let mut options = texels(2048);
    options.gate.metrics = false;
    for (tier, severity) in
        [(Tier::Capsules, Severity::Warning), (Tier::Auto, Severity::Note), (Tier::Surface, Severity::Note)]
    {
        let solids = ColliderOptions { tier, error: 1e-4, ..ColliderOptions::default() };
        let built = dress(&asset("figure.glb"), &options, &solids, &Quiet).unwrap();
        assert_eq!(built.bundle.body.is_some(), tier != Tier::Capsules);
        let found: Vec<Severity> =
            built.report.findings.iter().filter(|f| f.kind == "loose-fit").map(|f| f.severity).collect();
        assert_eq!(found, [severity], "{tier:?}");
    }
}
