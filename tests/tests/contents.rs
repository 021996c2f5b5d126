//! The output of `list` for real garments and of broken files, and which parts a build makes cloth.

use std::path::Path;

use gimage::Error;
use gimage::caps::Caps;
use gimage::contents::{Contents, Kind, list};
use gimage::options::BuildOptions;
use gimage::select::Role;
use gimage::shell::Layer;
use gimage_tests::{asset, build, garments_or_skip, texels};

fn contents(path: &Path) -> Contents {
    list(path, &BuildOptions::default()).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn nodes(contents: &Contents, role: Role) -> Vec<&str> {
    contents.parts.iter().filter(|p| p.verdict.role == role).map(|p| p.node.as_str()).collect()
}

fn kinds(contents: &Contents, kind: Kind) -> usize {
    contents.components.iter().filter(|c| c.kind == kind).count()
}

/// Checks that pieces, accessories and loops are those of the build.
fn agrees(path: &Path, options: &BuildOptions) {
    let contents = list(path, options).unwrap();
    let built = build(path, options).unwrap();
    let m = &built.bundle.manifest;
    let cloth = contents.components.iter().filter(|c| c.role == Role::Cloth);
    let (crumbs, pieces): (Vec<_>, Vec<_>) = cloth.partition(|c| matches!(c.kind, Kind::Crumb | Kind::Overlay));
    assert_eq!(pieces.len(), m.pieces.len(), "{}", path.display());
    for (a, b) in pieces.iter().zip(&m.pieces) {
        let own = b.surface.as_ref().unwrap();
        assert_eq!(
            (a.name.as_str(), a.size.triangles as u32, a.loops.len() as u32),
            (&*b.name, own.triangles, own.loops)
        );
    }
    assert_eq!(crumbs.len(), m.accessories.len(), "{}", path.display());
    let mut pins: Vec<_> = pieces.iter().flat_map(|c| &c.loops).map(|l| l.pin.unwrap()).collect();
    pins.sort_unstable();
    assert!(pins.iter().enumerate().all(|(k, pin)| k == *pin), "{pins:?}");
}

#[test]
fn the_samples_are_all_cloth_and_listed_as_they_are_built() {
    for name in ["cape.glb", "dress.glb", "skirt.glb", "trousers.glb", "tshirt.glb"] {
        let contents = contents(&asset(name));
        assert!(contents.components.iter().all(|c| c.role == Role::Cloth), "{name}");
        assert_eq!(kinds(&contents, Kind::ThinShell) + kinds(&contents, Kind::ClosedShell), 0, "{name}");
    }
    agrees(&asset("tshirt.glb"), &texels(2048));
}

#[test]
fn the_rule_is_right_on_skinned_garments() {
    let Some(folder) = garments_or_skip("the_rule_is_right_on_skinned_garments") else { return };
    let mage = contents(&folder.join("mage_skinned.glb"));
    assert_eq!(nodes(&mage, Role::Cloth), ["Mage_Cape"]);
    assert_eq!(nodes(&mage, Role::Rigid), ["Spellbook", "Spellbook_open", "1H_Wand", "2H_Staff", "Mage_Hat"]);
    assert_eq!((mage.animations.len(), mage.skins.len(), mage.skins[0].joints), (76, 1, 41));
    let outfit = contents(&folder.join("outfit_skinned.glb"));
    assert_eq!(nodes(&outfit, Role::Cloth), ["Wolf3D_Outfit_Bottom", "Wolf3D_Outfit_Top"]);
    assert_eq!(nodes(&outfit, Role::Rigid), ["Wolf3D_Outfit_Footwear"]);
    // Nothing of the knight is cloth: all is built, with a warning.
    let knight = contents(&folder.join("knight_skinned/scene.gltf"));
    assert!(knight.parts.iter().all(|p| p.verdict.role == Role::Cloth && p.verdict.looks_like != Role::Cloth));

    let built = build(&folder.join("mage_skinned.glb"), &texels(1024)).unwrap();
    let names: Vec<&str> = built.bundle.manifest.pieces.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["Mage_Cape"]);
    let finding = built.report.findings.iter().find(|f| f.kind == "left-out").unwrap();
    assert!(finding.count == 11 && finding.message.contains("cloth: Mage_Cape; body: Mage_ArmLeft"), "{finding:?}");
    let mut options = texels(8192);
    options.select.cloth = vec!["*_hat".parse().unwrap(), "Plane*".parse().unwrap()];
    agrees(&folder.join("mage_skinned.glb"), &options);
}

/// The caps that are left out of a file, as its finding counts them.
fn caps(path: &Path, caps: Caps) -> u64 {
    let mut options = BuildOptions::default();
    options.caps.caps = caps;
    let contents = list(path, &options).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    contents.findings.iter().find(|f| f.kind == "caps-opened").map_or(0, |f| f.count)
}

#[test]
fn caps_are_opened_around_limbs_only() {
    for name in ["cape.glb", "dress.glb", "figure.glb", "skirt.glb", "sleeve.glb", "trousers.glb", "tshirt.glb"] {
        assert_eq!(caps(&asset(name), Caps::Open), 0, "{name}");
    }
    let Some(folder) = garments_or_skip("caps_are_opened_around_limbs_only") else { return };
    let outfit = folder.join("outfit_skinned.glb");
    assert_eq!((caps(&outfit, Caps::Auto), caps(&outfit, Caps::Keep)), (6, 0));
    let loops: Vec<usize> =
        contents(&outfit).components.iter().filter(|c| c.role == Role::Cloth).map(|c| c.loops.len()).collect();
    assert_eq!(loops, [3, 4], "the waist and the legs, and the waist, the sleeves and the neck");
    for name in ["spot", "camel", "feline", "stanford-bunny"] {
        assert_eq!(caps(&folder.join(format!("models/{name}.obj")), Caps::Open), 0, "{name}");
    }
    for name in ["skirt_evening.obj", "tshirt_1900.obj", "hat_fedora.obj", "suit_male06.obj"] {
        assert_eq!(caps(&folder.join(name), Caps::Open), 0, "{name}");
    }
    let others = ["dress_summer.glb", "jacket_fleece.glb", "mage_skinned.glb", "knight_skinned/scene.gltf"];
    for name in others.into_iter().chain(["compressed/polo_draco.glb", "compressed/shorts_meshopt.glb"]) {
        assert_eq!(caps(&folder.join(name), Caps::Auto), 0, "{name}");
    }
}

#[test]
fn garments_look_like_what_they_are() {
    let Some(folder) = garments_or_skip("garments_look_like_what_they_are") else { return };
    for name in ["skirt_evening.obj", "tshirt_1900.obj", "hat_fedora.obj", "suit_male06.obj"] {
        let contents = contents(&folder.join(name));
        assert_eq!(kinds(&contents, Kind::OpenSurface), contents.components.len(), "{name}");
        assert!(contents.parts.iter().all(|p| p.verdict.role == Role::Cloth), "{name}");
    }
    assert_eq!(kinds(&contents(&folder.join("models/spot.obj")), Kind::ClosedShell), 1);
    let dress = contents(&folder.join("dress_summer.glb"));
    assert_eq!((kinds(&dress, Kind::ThinShell), dress.components.len()), (4, 4));
    let thickness = dress.components[0].thickness.unwrap();
    assert!((1.5e-4..2.5e-4).contains(&thickness), "{thickness}");
    let jacket = contents(&folder.join("jacket_fleece.glb"));
    assert_eq!(kinds(&jacket, Kind::ThinShell), 10);
    // Its panels are pairs of sheets, which a build makes one layer each.
    let polo = contents(&folder.join("compressed/polo_draco.glb"));
    assert!(polo.components[0].kind == Kind::ThinShell && polo.components[0].other_sheet.is_none());
    let mut keep = BuildOptions::default();
    keep.shell.shell = Layer::Keep;
    let polo = list(&folder.join("compressed/polo_draco.glb"), &keep).unwrap();
    assert_eq!(polo.components[0].other_sheet.as_deref(), Some(&*polo.components[1].name));
    // Instances of one node are one part.
    assert!(contents(&folder.join("compressed/shorts_meshopt.glb")).parts.len() < 20);
    let skirt = contents(&folder.join("skirt_evening.obj"));
    let lengths: Vec<f64> = skirt.components[0].loops.iter().map(|l| (l.length * 1e3).round() / 1e3).collect();
    assert_eq!(lengths, [2.415, 1.181]);
    agrees(&folder.join("skirt_evening.obj"), &texels(1024));
}

/// The kind of an error.
fn kind(error: &Error) -> std::mem::Discriminant<Error> {
    std::mem::discriminant(error)
}

#[test]
fn broken_files_have_the_errors_of_a_build() {
    let Some(folder) = garments_or_skip("broken_files_have_the_errors_of_a_build") else { return };
    let Ok(files) = std::fs::read_dir(folder.join("bad")) else { return };
    let mut paths: Vec<_> = files.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        let listed = list(&path, &BuildOptions::default());
        let built = build(&path, &texels(1024));
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        match (&listed, &built) {
            (Err(a), Err(b)) => assert_eq!((kind(a), a.to_string()), (kind(b), b.to_string()), "{name}"),
            (Err(a), Ok(_)) => panic!("{name}: listed as {a}, but built"),
            // Too small to be pieces: the list shows crumbs.
            (Ok(a), Err(_)) => assert_eq!(kinds(a, Kind::Crumb), a.components.len(), "{name}"),
            (Ok(_), Ok(_)) => {}
        }
        assert_eq!(listed.ok(), list(&path, &BuildOptions::default()).ok(), "{name}");
    }
}
