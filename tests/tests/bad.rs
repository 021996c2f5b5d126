//! Bad and odd files: a sound bundle or a clear message, never a panic, a hang or a silently wrong surface.

use std::path::Path;

use gimage::component::ComponentOptions;
use gimage::options::BuildOptions;
use gimage::pipeline::Built;
use gimage::repair::RepairOptions;
use gimage::topology::Topology;
use gimage::{Error, Result};
use gimage_tests::{build, check, garments_or_skip, surface, texels, topology};

/// The outcome that a file must come to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Is {
    /// A bundle, and nothing to say.
    Clean,
    /// A bundle, with repairs or warnings.
    Findings,
    /// `Error::Malformed`.
    Malformed,
    /// `Error::Empty`.
    Empty,
    /// `Error::Unsupported`.
    Unsupported,
    /// `Error::TooLarge`.
    TooLarge,
    /// `Error::Io`.
    Io,
}
use Is::*;

const TABLE: &[(&str, Is)] = &[
    ("all_degenerate.glb", Empty),
    ("all_nan.glb", Empty),
    ("bowtie_spheres.obj", Findings),
    ("bowtie_vertex.obj", Findings),
    ("bufferview_overrun.glb", Malformed),
    ("concave_quad.obj", Clean),
    ("confetti_200_components.glb", Empty),
    ("constant_uv.glb", Clean),
    ("double_sided_sheet.glb", Findings),
    ("double_torus.obj", Clean),
    ("duplicate_faces.glb", Findings),
    ("empty.obj", Empty),
    ("empty_scene.glb", Empty),
    ("genus16.obj", Findings),
    ("huge_count.glb", TooLarge),
    ("index_out_of_range.glb", Malformed),
    ("index_out_of_range.obj", Malformed),
    ("klein_bottle.obj", Clean),
    ("lfs_pointer.glb", Malformed),
    ("line_continuation.obj", Clean),
    ("lines_only.glb", Empty),
    ("missing_bin.gltf", Io),
    ("missing_vt.obj", Clean),
    ("mixed_winding.obj", Findings),
    ("moebius.obj", Clean),
    ("nan_positions.glb", Findings),
    ("nan_text.obj", Malformed),
    ("near_duplicate_soup_tube.glb", Findings),
    ("needles_1e4.obj", Clean),
    ("needles_1e6.obj", Findings),
    ("node_cycle.gltf", Malformed),
    ("nonmanifold_edge.obj", Findings),
    ("not_a_glb.glb", Malformed),
    ("one_triangle.obj", Clean),
    ("one_triangle_uv.obj", Clean),
    ("plane_3_holes.glb", Clean),
    ("points_only.obj", Empty),
    ("polygons_negative.obj", Findings),
    ("requires_draco.glb", Clean),
    ("skin_joint_out_of_range.glb", Findings),
    ("skin_ok_tube.glb", Clean),
    ("skin_unnormalised.glb", Findings),
    ("skin_zero_weights.glb", Findings),
    ("sphere.obj", Clean),
    ("t_junction_wall.glb", Findings),
    ("torus.obj", Clean),
    ("torus_with_hole.obj", Clean),
    ("triangle_soup_tube.glb", Clean),
    ("truncated.glb", Malformed),
    ("truncated_header.glb", Malformed),
    ("tube_far_1e6.obj", Findings),
    ("tube_huge_1e6.obj", Clean),
    ("tube_tiny_1e-6.obj", Clean),
    ("two_components.obj", Clean),
    ("vt_out_of_range.obj", Findings),
    ("zero_area.glb", Findings),
    ("zero_bytes.glb", Empty),
    ("zero_indices.glb", Empty),
];

fn outcome(built: &Result<Built>) -> Option<Is> {
    Some(match built {
        Ok(b) if b.report.has_findings() => Findings,
        Ok(_) => Clean,
        Err(Error::Malformed { .. }) => Malformed,
        Err(Error::Empty { .. }) => Empty,
        Err(Error::Unsupported { .. }) => Unsupported,
        Err(Error::TooLarge { .. }) => TooLarge,
        Err(Error::Io { .. }) => Io,
        Err(_) => return None,
    })
}

fn with(folder: &Path, name: &str, options: &BuildOptions) -> Result<Built> {
    let built = build(&folder.join(name), options);
    if let Ok(b) = &built {
        check(name, b);
    }
    built
}

fn folder(test: &str) -> Option<std::path::PathBuf> {
    Some(garments_or_skip(test)?.join("bad")).filter(|f| f.is_dir())
}

#[test]
fn every_file_comes_to_what_the_table_says() {
    let Some(folder) = folder("every_file_comes_to_what_the_table_says") else { return };
    let mut wrong = Vec::new();
    let mut names: Vec<String> =
        std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    for name in names.iter().filter(|n| !n.ends_with(".md")) {
        let built = std::panic::catch_unwind(|| build(&folder.join(name), &texels(1024)));
        let Ok(built) = built else {
            wrong.push(format!("{name}: panic"));
            continue;
        };
        let found = outcome(&built);
        match &built {
            Ok(b) => wrong.extend(gimage_tests::faults(b).iter().map(|f| format!("{name}: {f}"))),
            Err(e) => {
                // A glTF file may lack another file, whose name then is the better one.
                let text = e.to_string();
                let stem = name.split('.').next().unwrap_or_default();
                if !text.contains(stem) || text.len() < name.len() + 20 {
                    wrong.push(format!("{name}: a message that does not help: {text}"));
                }
            }
        }
        let want = TABLE.iter().find(|(n, _)| n == name).map(|(_, want)| *want);
        if found != want {
            let what = built.map(|b| b.report.findings.iter().map(|f| f.kind).collect::<Vec<_>>());
            wrong.push(format!("{name}: {found:?} instead of {want:?}: {what:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Euler number and loops after welding of the only component, which may be one piece or the parts of one.
fn only(folder: &Path, name: &str, options: &BuildOptions) -> (i64, usize) {
    let built = with(folder, name, options).unwrap();
    let pieces = &built.bundle.manifest.pieces;
    assert!(pieces.len() == 1 || pieces.iter().all(|p| p.part_of == Some(0)), "{name}");
    let t = Topology::of(&surface(&built.bundle).triangles);
    (t.euler, t.boundary_loops)
}

#[test]
fn topology_survives() {
    let Some(folder) = folder("topology_survives") else { return };
    for (name, euler, loops) in [
        ("moebius.obj", 0, 1),
        ("klein_bottle.obj", 0, 0),
        ("genus16.obj", 2 - 32, 0),
        ("double_torus.obj", -2, 0),
        ("torus.obj", 0, 0),
        ("torus_with_hole.obj", -1, 1),
        ("sphere.obj", 2, 0),
        ("plane_3_holes.glb", -2, 4),
        ("triangle_soup_tube.glb", 0, 2),
        ("mixed_winding.obj", 1, 1),
        ("one_triangle.obj", 1, 1),
    ] {
        assert_eq!(only(&folder, name, &texels(2048)), (euler, loops), "{name}");
    }
}

#[test]
fn sheets_and_spheres_that_touch_are_told_apart() {
    let Some(folder) = folder("sheets_and_spheres_that_touch_are_told_apart") else { return };
    let bowtie = with(&folder, "bowtie_spheres.obj", &texels(2048)).unwrap();
    assert_eq!(bowtie.bundle.manifest.pieces.len(), 2);
    let welded = surface(&bowtie.bundle);
    for k in 0..2 {
        let t = topology(&welded, k);
        assert_eq!((t.euler, t.boundary_loops), (2, 0));
    }
    let sheet = with(&folder, "double_sided_sheet.glb", &texels(1024)).unwrap();
    let pieces = &sheet.bundle.manifest.pieces;
    assert_eq!((pieces.len(), pieces[0].surface.as_ref().unwrap().triangles), (1, 128));
    let two = with(&folder, "two_components.obj", &texels(2048)).unwrap();
    assert_eq!(two.bundle.manifest.pieces.len(), 2);
}

#[test]
fn confetti_is_refused_with_the_way_out() {
    let Some(folder) = folder("confetti_is_refused_with_the_way_out") else { return };
    let e = with(&folder, "confetti_200_components.glb", &texels(1024)).unwrap_err().to_string();
    assert!(e.contains("--accessory-area") && e.contains("--weld") && e.contains("200"), "{e}");
    // The way out leads somewhere: with room for 200 images there are 200 pieces.
    let component = ComponentOptions { accessory_area: 0.0 };
    let built = with(&folder, "confetti_200_components.glb", &BuildOptions { component, ..texels(65_536) }).unwrap();
    assert_eq!(built.bundle.manifest.pieces.len() + built.bundle.manifest.accessories.len(), 200);
}

#[test]
fn near_duplicates_are_joined_as_rounding_or_on_request() {
    let Some(folder) = folder("near_duplicates_are_joined_as_rounding_or_on_request") else { return };
    let weld = |d| BuildOptions { repair: RepairOptions { weld: d }, ..texels(1024) };
    assert_eq!(only(&folder, "near_duplicate_soup_tube.glb", &weld(Some(1e-5))), (0, 2));
    // They differ by up to five steps of 32-bit numbers.
    assert_eq!(only(&folder, "near_duplicate_soup_tube.glb", &weld(None)), (0, 2));
    let built = with(&folder, "near_duplicate_soup_tube.glb", &weld(None)).unwrap();
    let joined = built.report.findings.iter().find(|f| f.kind == "rounded-borders").expect("a finding");
    assert_eq!(joined.count, 936);
}
