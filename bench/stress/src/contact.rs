//! Contact of cloth with cloth under disturbances, in both tiers.
//!
//! Each case is judged by the promise of the tier, or by what the stepper reports in its place.

mod cases;

use std::fmt::Write;

use gimage_runtime::crossings::{self, Drawn};
use gimage_runtime::{ClothContact, ContactTier, Fate, Options, Result, Stepper};

use crate::crew;
use cases::Case;

/// The tiers that are tried.
const TIERS: [ContactTier; 2] = [ContactTier::Particles, ContactTier::Safe];
/// RMS speed \[m/s\] at the end below which cloth is at rest.
const REST_M_S: f64 = 0.05;
/// Extension that one spring in a hundred may have at the end.
const MAX_P99: f64 = 0.1;

/// The figures of a run.
struct Row {
    name: &'static str,
    tier: ContactTier,
    frames: u32,
    /// Most crossings in a frame, frames with some, and those in the last frame.
    crossings: [u64; 3],
    deepest_mm: f64,
    stretch: f64,
    speed: f64,
    findings: Vec<String>,
    /// Requirements that do not hold and that no finding reports.
    failures: Vec<String>,
}

/// Runs all cases whose names have `only` in them, and prints the figures of each; true if none fails.
#[allow(clippy::print_stdout)]
pub fn run(
    only: &str,
    threads: usize,
    out: Option<&std::path::Path>,
) -> std::result::Result<bool, Box<dyn std::error::Error>> {
    let names: Vec<_> = cases::all()?.into_iter().map(|case| case.name).collect();
    let chosen: Vec<usize> = (0..names.len()).filter(|k| names[*k].contains(only)).collect();
    let mut rows: Vec<Row> = Vec::new();
    let work =
        |cases: &Result<Vec<Case>>, n: usize| {
            let case = &cases.as_ref().ok()?[chosen[n / TIERS.len()]];
            let tier = TIERS[n % TIERS.len()];
            Some(try_case(case, tier).unwrap_or_else(|error| Row {
                failures: vec![format!("refused: {error}")],
                ..Row::new(case.name, tier)
            }))
        };
    crew::share((chosen.len() * TIERS.len(), threads), cases::all, work, |row| {
        if let Some(row) = row {
            println!("{}", row.line());
            rows.push(row);
        }
    });
    let kept = rows.iter().filter(|row| row.failures.is_empty()).count();
    println!("kept or reported: {kept} of {}", rows.len());
    if let Some(path) = out {
        std::fs::write(path, csv(&rows))?;
    }
    Ok(kept == rows.len())
}

fn try_case(case: &Case, tier: ContactTier) -> Result<Row> {
    let mut row = Row::new(case.name, tier);
    let mut scene = case.scene.clone();
    let distance = Some(case.distance);
    scene.cloths.iter_mut().for_each(|cloth| {
        cloth.contact = Some(ClothContact { tier, distance, ..ClothContact::default() });
    });
    let options = Options { threads: 1, normals: false, ..Options::default() };
    let mut stepper = Stepper::on_cpu(scene.clone(), options)?;
    let mut lost = None;
    while f64::from(row.frames) < 60.0 * case.seconds {
        row.frames += 1;
        (case.during)(&scene, &mut stepper, f64::from(row.frames) / 60.0)?;
        stepper.advance(1.0 / 60.0)?;
        let cloths = 0..scene.cloths.len();
        let at = |cloth: usize| stepper.positions(cloth).unwrap_or_default();
        if cloths.clone().flat_map(at).any(|p| p.iter().any(|x| !x.is_finite())) {
            lost = lost.or(Some(row.frames));
        }
        let drawn: Vec<Drawn> = cloths
            .map(|c| Drawn { cloth: &scene.cloths[c], positions: stepper.positions(c), holes: stepper.holes(c) })
            .collect();
        let found = crossings::find(&drawn, 0)?;
        let [most, some, last] = &mut row.crossings;
        (*most, *some, *last) = ((*most).max(found.total()), *some + u64::from(found.total() > 0), found.total());
        row.deepest_mm = row.deepest_mm.max(1e3 * found.deepest);
    }
    for (health, _) in (0..scene.cloths.len()).filter_map(|cloth| stepper.health(cloth)) {
        row.stretch = row.stretch.max(health.stretch.map_or(0.0, |stretch| stretch.p99));
        row.speed = row.speed.max(health.speed);
    }
    row.findings = stepper.findings().iter().map(ToString::to_string).collect();
    let has = |is: fn(&Fate) -> bool| stepper.findings().iter().any(|finding| is(&finding.fate));
    let crosses = has(|fate| matches!(fate, Fate::Crossed { .. } | Fate::Tangled { .. }));
    let mut fail = |words: String| row.failures.push(words);
    if let Some(frame) = lost {
        fail(format!("not finite after frame {frame}"));
    }
    if case.cuts && !stepper.holes(0).is_some_and(|holes| holes.iter().any(|hole| *hole != 0)) {
        fail("it is not cut".to_owned());
    }
    if tier == ContactTier::Safe && row.crossings[1] > 0 && !crosses {
        fail(format!("{} frames with crossings", row.crossings[1]));
    }
    if row.crossings[2] > 0 && !crosses {
        fail(format!("{} crossings at the end", row.crossings[2]));
    }
    if row.stretch > MAX_P99 && !has(|fate| matches!(fate, Fate::Stretched { .. })) {
        fail(format!("stretch {:.1} %", 100.0 * row.stretch));
    }
    if row.speed > REST_M_S && !has(|fate| matches!(fate, Fate::Stretched { .. } | Fate::Squeezed { .. })) {
        fail(format!("at rest {:.3} m/s", row.speed));
    }
    Ok(row)
}

impl Row {
    fn new(name: &'static str, tier: ContactTier) -> Self {
        Row {
            name,
            tier,
            frames: 0,
            crossings: [0; 3],
            deepest_mm: 0.0,
            stretch: 0.0,
            speed: 0.0,
            findings: Vec::new(),
            failures: Vec::new(),
        }
    }

    fn line(&self) -> String {
        let Row { name, tier, crossings: [most, frames, last], stretch, speed, findings, failures, .. } = self;
        let verdict = if failures.is_empty() { "ok".to_owned() } else { failures.join("; ") };
        let mut line =
            format!("{name:48} | {tier:9?} | {verdict:24} | crossings {most} in {frames} frames, {last} at the end");
        let _ = write!(line, ", stretch {:.1} %, {speed:.3} m/s", 100.0 * stretch);
        findings.iter().for_each(|finding| _ = write!(line, "\n    {finding}"));
        line
    }
}

/// A line per case and tier.
fn csv(rows: &[Row]) -> String {
    let mut out = "case,tier,frames,verdict,failures,crossings_most,frames_crossed,crossings_last,deepest_mm,stretch_p99_end,speed_rms_end,findings\n"
        .to_owned();
    for row in rows {
        let Row { name, frames, crossings: [most, some, last], deepest_mm, stretch, speed, .. } = row;
        let tier = format!("{:?}", row.tier).to_lowercase();
        let verdict = if row.failures.is_empty() { "ok" } else { "failed" };
        let _ =
            write!(out, "\"{name}\",{tier},{frames},{verdict},\"{}\",{most},{some},{last}", row.failures.join("; "));
        let _ =
            writeln!(out, ",{deepest_mm:.2},{stretch:.4},{speed:.4},\"{}\"", row.findings.join("; ").replace('"', "'"));
    }
    out
}
