//! Real garments and classical models, where the shared folder is there.

use std::path::Path;

use gimage::caps::{CapsOptions, open_caps};
use gimage::options::BuildOptions;
use gimage_tests::{build, check, garments_or_skip, point, psnr, reread, surface, texels, topology};

/// Files with repairs to make or parts to set apart: file, texels.
const DIRTY: &[(&str, u32)] = &[
    ("jacket_fleece.glb", 16_384),
    ("dress_summer.glb", 16_384),
    ("dress_belted_202k.glb", 16_384),
    ("outfit_skinned.glb", 16_384),
    ("mage_skinned.glb", 16_384),
    ("knight_skinned/scene.gltf", 16_384),
    ("compressed/polo_draco.glb", 16_384),
    ("compressed/shorts_meshopt.glb", 16_384),
];

/// File, pieces, sum of Euler numbers, sum of loops, and a floor for the PSNR \[dB\] with texels on the surface, where
/// one is known: 3 dB under what it was when this was written.
const CLEAN: &[(&str, usize, i32, u32, Option<f64>)] = &[
    ("skirt_evening.obj", 1, 0, 2, Some(72.6 - 3.0)),
    ("tshirt_1900.obj", 1, -2, 4, Some(81.1 - 3.0)),
    ("hat_fedora.obj", 1, 1, 1, Some(70.1 - 3.0)),
    ("suit_male06.obj", 2, -3, 7, None),
    ("models/spot.obj", 1, 2, 0, Some(70.9 - 3.0)),
    ("models/feline.obj", 1, -2, 0, None),
    ("models/camel.obj", 1, 2, 0, Some(61.4 - 3.0)),
    ("models/stanford-bunny.obj", 1, -3, 5, None),
];

const TEXELS: u32 = 16_641;

/// Builds, checks what all builds keep, and says how good it is.
fn made(folder: &Path, file: &str, options: &BuildOptions) -> Option<gimage::pipeline::Built> {
    let path = folder.join(file);
    if !path.exists() {
        println!("{file} is not here");
        return None;
    }
    let built = build(&path, options).unwrap_or_else(|e| panic!("{file}: {e}"));
    check(file, &built);
    let m = &built.bundle.manifest;
    println!("{file}: {} pieces, {} accessories, {:.1} dB", m.pieces.len(), m.accessories.len(), psnr(&built.bundle));
    Some(built)
}

#[test]
fn clean_meshes_keep_their_topology_and_are_faithful() {
    let Some(folder) = garments_or_skip("clean_meshes_keep_their_topology_and_are_faithful") else { return };
    let mut wrong = Vec::new();
    for &(file, pieces, euler, loops, floor) in CLEAN {
        let Some(built) = made(&folder, file, &point(TEXELS)) else { continue };
        let m = &built.bundle.manifest;
        let own: Vec<_> = m.pieces.iter().map(|p| p.surface.as_ref().unwrap()).collect();
        let sums = (own.len(), own.iter().map(|s| s.euler).sum::<i32>(), own.iter().map(|s| s.loops).sum::<u32>());
        if sums != (pieces, euler, loops) || !m.accessories.is_empty() {
            wrong.push(format!("{file}: pieces, Euler number, loops {sums:?}, {} accessories", m.accessories.len()));
        }
        let welded = surface(&reread(&built.bundle));
        for (k, s) in own.iter().enumerate() {
            let t = topology(&welded, k);
            assert_eq!((t.euler, t.boundary_loops), (i64::from(s.euler), s.loops as usize), "{file}, piece {k}");
            assert!(t.is_oriented_manifold(), "{file}, piece {k}: {t:?}");
        }
        if let Some(floor) = floor.filter(|f| psnr(&built.bundle) < *f) {
            wrong.push(format!("{file}: {:.2} dB is under {floor:.1}", psnr(&built.bundle)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn fitted_texels_are_better_than_texels_on_the_surface() {
    let Some(folder) = garments_or_skip("fitted_texels_are_better_than_texels_on_the_surface") else { return };
    let mut wrong = Vec::new();
    for file in ["skirt_evening.obj", "tshirt_1900.obj", "hat_fedora.obj", "models/spot.obj"] {
        let Some(on) = made(&folder, file, &point(TEXELS)) else { continue };
        let Some(fitted) = made(&folder, file, &texels(TEXELS)) else { continue };
        let (a, b) = (psnr(&on.bundle), psnr(&fitted.bundle));
        println!("{file}: fitting gains {:.2} dB", b - a);
        if b < a + 2.0 {
            wrong.push(format!("{file}: {b:.2} dB fitted, {a:.2} dB on the surface"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn dirty_garments_come_out_sound() {
    let Some(folder) = garments_or_skip("dirty_garments_come_out_sound") else { return };
    for &(file, n) in DIRTY {
        let mut options = texels(n);
        // Bodies and props too: they are the dirtiest.
        options.select.cloth = vec!["*".parse().unwrap()];
        let Some(built) = made(&folder, file, &options) else { continue };
        let m = &built.bundle.manifest;
        // The budget is for the whole; a small piece may take up to four times its share.
        assert!(m.texels() < 2 * n, "{file}: {} texels", m.texels());
        if file.contains("skinned") {
            let skeleton = m.skeleton.as_ref().unwrap();
            assert!(skeleton.joints.iter().any(|j| j.parent.is_some()), "{file}");
        }
        assert!(m.accessories.iter().all(|a| (a.piece as usize) < m.pieces.len() && !a.reason.is_empty()), "{file}");
        // Nothing is dropped in silence: pieces, what is bound to them, accessories and caps have the triangles that repair left.
        let kept: u32 = m.pieces.iter().map(|p| p.surface.as_ref().unwrap().triangles).sum::<u32>()
            + m.pieces.iter().filter_map(|p| Some(p.shell.as_ref()?.bound_triangles)).sum::<u32>()
            + m.accessories.iter().map(|a| a.triangles).sum::<u32>();
        let mesh = gimage::import::import(&folder.join(file), &Default::default()).unwrap().mesh;
        let repaired = gimage::repair::repair(mesh, &Default::default()).unwrap().mesh;
        let count = repaired.triangles.len();
        let caps = open_caps(repaired, &CapsOptions::default()).caps;
        assert_eq!(kept as usize + caps.iter().map(|cap| cap.triangles.len()).sum::<usize>(), count, "{file}");
        assert_eq!(built.report.findings.iter().any(|f| f.kind == "caps-opened"), !caps.is_empty(), "{file}");
    }
}
