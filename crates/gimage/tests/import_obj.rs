//! OBJ features and faults.

use crate::support::*;
use gimage::Error;
use gimage::import::{ImportOptions, Imported};
use gimage::mesh::{NONE, Semantic};

fn area(got: &Imported) -> f64 {
    check(got);
    (0..got.mesh.triangles.len()).map(|t| got.mesh.triangle_area(t)).sum()
}

const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn polygons_of_every_spelling() {
    for face in ["f 1 2 3 4", "f -4 -3 -2 -1", "f 1 2 \\\r\n 3 4\r\n", "f\t1\t2\t3\t4 ", "f 1 2 2 3 4 1 # comment"] {
        let got = load_obj(&format!("{QUAD}{face}\nl 1 2\np 1\ng\nusemtl\n")).unwrap();
        assert_eq!((got.mesh.triangles.len(), area(&got)), (2, 1.0), "{face}");
        assert!(has(&got, "points-and-lines"));
    }
    let got = load_obj("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap();
    assert_eq!(got.mesh.triangles, [[0, 1, 2]], "faces may come before their vertices");
}

#[test]
fn concave_and_crossing_polygons() {
    let got = load_obj("v 2 0 0\nv 0.5 0.5 0\nv 0 2 0\nv 0 0 0\nf 1 2 3 4\nf 4 3 2 1\n").unwrap();
    assert!((area(&got) - 2.0).abs() < 1e-12);
    let got = load_obj("v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n").unwrap();
    assert!(has(&got, "crossed-faces"));
}

#[test]
fn attributes_stay_on_their_corners() {
    let text = format!("{QUAD}vt 0 0.25\nvt 1 0.25\nvt 1 1\nvn 0 0 2\nf 1/1/1 2/2/1 3/3/1\nf 1//1 3 4//1\n");
    let got = load_obj(&text).unwrap();
    check(&got);
    let uv = got.mesh.channel(&Semantic::TexCoord(0)).unwrap();
    assert_eq!(uv.at(0, 0), Some(&[0.0, 0.75][..]), "v runs down");
    assert_eq!(uv.corners[3..], [NONE; 3]);
    let normal = got.mesh.channel(&Semantic::Normal).unwrap();
    assert_eq!((normal.at(1, 2), normal.at(1, 1)), (Some(&[0.0, 0.0, 1.0][..]), None));
    assert!(!has(&got, "attribute-out-of-range"));
}

#[test]
fn colours_after_positions() {
    let got = load_obj("v 0 0 0 1 0 0.5\nv 1 0 0\nv 0 1 0 0 0 1\nf 1 2 3\n").unwrap();
    let color = got.mesh.channel(&Semantic::Color(0)).unwrap();
    assert_eq!((color.at(0, 0), color.at(0, 1)), (Some(&[1.0, 0.0, 0.5, 1.0][..]), None));
    // A fourth number is a weight, not a colour.
    assert!(load_obj("v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n").unwrap().mesh.channels.is_empty());
}

#[test]
fn parts_and_pieces() {
    let text = format!("# by someone\n{QUAD}o shirt\ng sleeve\nusemtl wool\nf 1 2 3\no trousers\nf 1 3 4\n");
    let got = load_obj(&text).unwrap();
    let names: Vec<_> = got.mesh.parts.iter().map(|p| (&p.node[..], &p.mesh[..], &p.material[..])).collect();
    assert_eq!(names, [("shirt", "sleeve", "wool"), ("trousers", "", "wool")]);
    assert_eq!(got.source.extras, ["by someone"]);
    assert!(got.mesh.parts.iter().all(|p| !p.has_siblings));
    let several =
        load_obj(&format!("{QUAD}o shirt\nusemtl wool\nf 1 2 3\nusemtl silk\nf 1 3 4\no hat\nf 1 2 4\n")).unwrap();
    assert_eq!(several.mesh.parts.iter().map(|p| p.has_siblings).collect::<Vec<_>>(), [true, true, false]);
    let only = |name: &str| {
        let options = ImportOptions { pieces: vec![name.into()], ..Default::default() };
        load_with("a.obj", text.as_bytes(), &options)
    };
    let got = only("trousers").unwrap();
    check(&got);
    assert_eq!((got.mesh.triangles.len(), got.mesh.positions.len(), got.mesh.parts.len()), (1, 3, 1));
    assert_eq!(only("wool").unwrap().mesh.triangles.len(), 2);
    assert!(only("hat").unwrap_err().to_string().contains("`sleeve`"));
}

#[test]
fn faults_name_their_line() {
    let cases = [
        ("v 0 0 0\nv nan 0 0\n", "line 2", "finite"),
        ("v 0 0 0\nv 0 1e999 0\n", "line 2", "too large"),
        ("v 0 0 0\nv 0,5 1 0\n", "line 2", "decimals with a point"),
        ("v 0 0\n", "line 1", "2 numbers"),
        ("v 0 0 x\n", "line 1", "`x`"),
        ("v 0 0 0\nf 0 1 1\n", "line 2", "vertex 0"),
        ("v 0 0 0\nf -2 1 1\n", "line 2", "vertex -2"),
        ("v 0 0 0\nf 1/a 1 1\n", "line 2", "`1/a`"),
        ("v 0 0 0\nf /1 1 1\n", "line 2", "`/1`"),
        ("v 0 0 0\nv 1 0 0\nv 1 1 0\n\nf 1 2 999\n", "line 5, face 1", "vertex 999"),
    ];
    for (text, line, words) in cases {
        let got = load_obj(text);
        assert!(is_malformed(&got, line) && is_malformed(&got, words), "{text:?}: {got:?}");
    }
}

#[test]
fn nothing_to_work_on() {
    for text in ["# nothing\n", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "v 0 0 0\nf 1 1 1\n", "\n"] {
        assert!(matches!(load_obj(text), Err(Error::Empty { .. })), "{text:?}");
    }
}

#[test]
fn impostors_are_named() {
    let cases: [(&str, &[u8], &str); 8] = [
        ("a.glb", b"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"),
        ("a.glb", b"<!DOCTYPE html>", "HTML"),
        ("a.obj", b"PK\x03\x04aaaa", "ZIP"),
        ("a.fbx", b"Kaydara FBX Binary", "FBX"),
        ("a.obj", b"\x00\x01\x02", "binary"),
        ("a.txt", b"v 0 0 0", ".txt"),
        ("a.gltf", b"v 0 0 0", "`{`"),
        ("a.glb", b"glTF\x01\0\0\0\x20\0\0\0", "gltf-pipeline"),
    ];
    for (name, bytes, words) in cases {
        let error = load_with(name, bytes, &ImportOptions::default()).unwrap_err().to_string();
        assert!(error.contains(words) && error.contains(name), "{error}");
    }
    let got = load_with("a.obj", &square().finish(), &ImportOptions::default()).unwrap();
    assert!(has(&got, "wrong-extension"));
}
