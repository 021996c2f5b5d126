//! The gate: what does not stand for its surface is refused, what is suspicious is said.

use std::fmt::Write;

use crate::common::Place;

/// A sheet of 30 x 30 cells whose vertices lie anywhere in a cube: far more shape than a few texels can hold.
fn crumpled() -> String {
    let mut state = 7u64;
    let mut draw = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / f64::from(1 << 24)
    };
    let mut text = String::new();
    for _ in 0..31 * 31 {
        writeln!(text, "v {} {} {}", draw(), draw(), draw()).unwrap();
    }
    for k in (1..=30 * 31).filter(|k| k % 31 != 0) {
        writeln!(text, "f {k} {} {} {}", k + 1, k + 32, k + 31).unwrap();
    }
    text
}

#[test]
fn an_image_that_does_not_stand_for_its_surface_is_an_error_unless_accepted() {
    for metrics in ["", "--no-metrics"] {
        let place = Place::new();
        place.write("ball.obj", &crumpled());
        let args = format!("build ball.obj -o ball.gim --size 5x5 {metrics}");
        let run = place.run(&args).expect(&[2]);
        for word in ["ball.obj", "piece piece", "dB", "--accept-poor"] {
            assert!(run.stderr.contains(word), "{word}: {}", run.stderr);
        }
        assert!(!place.path("ball.gim").exists());
        let run = place.run(&format!("{args} --accept-poor")).expect(&[1]);
        assert!(run.stderr.contains("warning") && run.stderr.contains("low-quality"), "{}", run.stderr);
        let run = place.run("inspect ball.gim").expect(&[0]);
        assert!(metrics.len() > 1 || run.stdout.contains("poor"), "{}", run.stdout);
    }
}

#[test]
fn a_suspicious_image_is_a_warning_and_an_ordinary_one_is_not() {
    let place = Place::new();
    place.write("ball.obj", &crumpled());
    let run = place.run("build ball.obj -o ball.gim --size 12x12 --json --accept-poor").expect(&[1]);
    assert!(run.stderr.contains("piece piece: PSNR"), "{}", run.stderr);
    let json = run.json();
    assert!(json["pieces"][0]["remarks"][0].as_str().unwrap().contains("PSNR"), "{}", json["pieces"][0]);
    let tried = json["pieces"][0]["ladder"].as_array().unwrap();
    assert!(tried.len() > 1 && tried[0]["rung"] == "first", "{tried:?}");
    assert_eq!(tried.iter().filter(|r| r["kept"] == true).count(), 1, "{tried:?}");
    let json = place.built("--json").json();
    assert_eq!(json["pieces"][0]["rating"], "good");
    assert!(json["pieces"][0]["ladder"].is_null(), "{}", json["pieces"][0]);
}

#[test]
fn a_piece_below_the_psnr_asked_for_fails_the_build() {
    for metrics in ["", "--no-metrics"] {
        let place = Place::new();
        let run = place.run(&format!("build tube.obj -o tube.gim --min-psnr 500 {metrics}")).expect(&[2]);
        assert!(run.stderr.contains("--min-psnr") && run.stderr.contains("500 dB"), "{}", run.stderr);
        assert!(!place.path("tube.gim").exists());
        place.run(&format!("build tube.obj -o tube.gim --min-psnr 40 {metrics}")).expect(&[0]);
    }
    Place::new().run("build tube.obj -o tube.gim --min-psnr nan").expect(&[2]);
}
