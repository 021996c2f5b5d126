//! The render mesh of a bundle as the source of another one, and render meshes of files that are damaged where an import does not look.

use gimage::Error;
use gimage::options::ImageSize;
use gimage_bundle::{COORD, JOINTS, MapKind, OFFSET, RenderFile, WEIGHTS};
use gimage_tests::glb::Glb;
use gimage_tests::{asset, build, check, reread, texels};

#[test]
fn a_render_mesh_is_a_source_of_which_other_parts_can_be_chosen() {
    let mut blended = texels(1024);
    blended.assemble.blends = vec!["above:-1=0.5".parse().unwrap()];
    let first = build(&asset("figure.glb"), &blended).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("render.glb");
    let bytes = first.bundle.render.as_ref().unwrap();
    let names = |bytes: &[u8]| [COORD, OFFSET, JOINTS, WEIGHTS].map(|n| String::from_utf8_lossy(bytes).contains(n));
    assert_eq!(names(bytes), [true; 4]);
    std::fs::write(&path, bytes).unwrap();

    let mut options = texels(1024);
    options.select.cloth = vec!["T-shirt".parse().unwrap()];
    let again = build(&path, &options).unwrap();
    check("again", &again);
    assert!(again.report.findings.iter().any(|f| f.kind == "bindings"));
    let bundle = reread(&again.bundle);
    assert!(!bundle.images.keys().any(|(_, kind)| matches!(kind, MapKind::Custom(_))));
    // Parts of the first bundle that are not of this one have no binding left.
    let file = RenderFile::parse(bundle.render.as_ref().unwrap()).unwrap();
    let bound: Vec<bool> = file.primitives().unwrap().iter().map(|p| !p.coords.is_empty()).collect();
    assert_eq!(bound.iter().filter(|b| **b).count(), 1, "{bound:?}");
    assert_eq!(names(bundle.render.as_ref().unwrap()), [true, true, false, false]);
}

#[test]
fn a_file_that_is_damaged_where_an_import_does_not_look_has_no_render_mesh_and_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.glb");
    let mut file = Glb::read(&asset("tshirt.glb"));
    file.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = 9999.into();
    file.write(&path);
    let built = build(&path, &texels(1024)).unwrap();
    check("damaged", &built);
    assert!(built.bundle.render.is_none() && built.bundle.manifest.render.is_none());
    let finding = built.report.findings.iter().find(|f| f.kind == "no-render-mesh").unwrap();
    let said = "accessor 9999: it does not exist; export the file again.";
    assert!(finding.message.ends_with(said), "{}", finding.message);
}

#[test]
fn images_that_are_too_large_together_are_refused_before_any_is_made() {
    // Each of the two pieces could be that large.
    let refused = |size: ImageSize| {
        let mut options = texels(1024);
        options.image.size = size;
        match build(&asset("figure.glb"), &options).unwrap_err() {
            Error::TooLarge { what, need, limit, .. } => (what, need, limit),
            other => panic!("{other}"),
        }
    };
    let (what, need, limit) = refused(ImageSize::Exact(4000, 4000));
    assert_eq!((&what[..], &need[..]), ("2 images of 4000 x 4000 texels", "32000000 texels"));
    assert_eq!(limit, "16777214 texels");
    // 0.93 and 0.51 m2.
    let (what, ..) = refused(ImageSize::Spacing(0.000_26));
    assert_eq!(what, "2 pieces at a spacing of 0.00026 m");
}
