//! `gimage list`, and the flags that choose parts.

use crate::common::Place;

const TWO: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nv 3 0 0\nv 2 2 0\no shirt\nusemtl red\nf 1 2 3\no head\nf 4 5 6\n";

#[test]
fn the_list_says_what_a_build_does() {
    let place = Place::new();
    place.write("two.obj", TWO);
    let run = place.run("list two.obj --cloth sh*").expect(&[0]);
    for text in ["Parts", "--cloth sh*", "left out", "Components", "open surface", "Boundary loops", "3.414 m"] {
        assert!(run.stdout.contains(text), "{text}: {}", run.stdout);
    }
    let json = place.run("list two.obj --cloth sh* --json").expect(&[0]).json();
    assert_eq!(json["parts"][0]["verdict"]["role"], "cloth");
    assert_eq!((&json["parts"][1]["node"], &json["parts"][1]["verdict"]["role"]), (&"head".into(), &"other".into()));
    assert_eq!(
        (&json["components"][0]["kind"], &json["components"][0]["loops"][0]["pin"]),
        (&"open-surface".into(), &0.into())
    );
    assert_eq!(json["size"]["triangles"], 2);
}

#[test]
fn a_build_reports_the_parts_that_it_leaves_out() {
    let place = Place::new();
    place.write("two.obj", TWO);
    let run = place.run("build two.obj -o two.gim --texels 200 --body head").expect(&[0]);
    assert!(run.stderr.contains("left-out: 1 part (1 triangle) left out; cloth: shirt; body: head."), "{}", run.stderr);
    let json = place.run("inspect two.gim --json").expect(&[0]).json();
    assert_eq!((json["pieces"].as_array().unwrap().len(), &json["pieces"][0]["name"]), (1, &"shirt".into()));
    let run = place.run("build two.obj -o b.gim --cloth skirt*,shirt").expect(&[2]);
    assert!(run.stderr.contains("matches `skirt*`; choose from `shirt`, `red`, `head`"), "{}", run.stderr);
}
