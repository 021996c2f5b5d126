//! `gimage doctor`.

use crate::common::Place;

#[test]
fn every_adapter_is_listed_with_its_limits_and_its_self_check() {
    let place = Place::new();
    let run = place.run("doctor --json").expect(&[0, 1]);
    let json = run.json();
    let adapters = json["adapters"].as_array().unwrap();
    let passed = |a: &serde_json::Value| a["self_check"].is_null() || a["self_check"]["passed"] == true;
    assert_eq!(run.code == 0, adapters.iter().all(passed), "{json}");
    assert_eq!(json["exit"], run.code);
    for adapter in adapters {
        assert!(!adapter["name"].as_str().unwrap().is_empty() && adapter["limits"]["storage_buffers"].is_u64());
        // An adapter is examined, or it says why not.
        assert!(adapter["self_check"].is_null() != adapter["error"].is_null(), "{adapter}");
        if let Some(ms) = adapter["self_check"]["ms"].as_f64() {
            assert!(ms > 0.0);
            let words = adapter["self_check"]["mismatches"].as_array().unwrap();
            assert_eq!(words.is_empty(), adapter["self_check"]["passed"] == true);
        }
    }
    assert!(json["cpu_threads"].as_u64().unwrap() > 0);
    assert!(["cpu", "gpu"].contains(&json["auto"]["backend"].as_str().unwrap()));
    assert!(!json["auto"]["reason"].as_str().unwrap().is_empty());
    let text = place.run("doctor").expect(&[run.code]).stdout;
    assert!(text.contains("--backend auto") && text.contains("--backend cpu"), "{text}");
    assert!(adapters.iter().all(|a| text.contains(a["name"].as_str().unwrap())), "{text}");
}

#[test]
fn auto_runs_what_doctor_says() {
    let place = Place::new();
    let doctor = place.run("doctor --json").expect(&[0, 1]).json();
    let run = place.run("simulate s1 --n 9 --frames 2 --json").expect(&[0]).json();
    assert_eq!(run["backend"], doctor["auto"]["backend"]);
    let gpu = place.run("simulate s1 --n 9 --frames 3 --backend gpu --json");
    assert_eq!(gpu.code, if doctor["gpu"].is_null() { 2 } else { 0 }, "{}", gpu.stderr);
    if gpu.code == 0 {
        let json = gpu.json();
        // A frame that is timed pass by pass counts as a frame, and has all dispatches. Not every device has timestamps.
        assert_eq!(json["frames"].as_u64(), Some(3));
        let passes = json["gpu_passes"].as_array().unwrap();
        if !passes.is_empty() {
            let dispatches: u64 = passes.iter().map(|p| p["dispatches"].as_u64().unwrap()).sum();
            assert_eq!(Some(dispatches), json["dispatches_per_frame"].as_u64(), "{passes:?}");
            assert!(passes.iter().map(|p| p["ms_median"].as_f64().unwrap()).sum::<f64>() > 0.0, "{passes:?}");
        }
        let required = std::env::var("GIMAGE_REQUIRE_GPU").is_ok_and(|v| v == "1");
        assert!(!required || !passes.is_empty(), "the software adapter of CI has timestamps");
    }
}
