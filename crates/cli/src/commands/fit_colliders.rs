//! `gimage fit-colliders`: solids in place of the body of a character.

use gimage::colliders::{Collider, Fit, Form, fit_colliders};
use gimage::record::Severity;
use serde_json::{Map, Value, json};

use crate::args::FitCollidersArgs;
use crate::exit::{Exit, Failure};
use crate::files::{Pending, check_file_target};
use crate::output::{Output, Tone, plain};
use crate::table::{NOTHING, Table};

/// Runs it.
pub fn run(args: &FitCollidersArgs, out: &Output) -> Result<Exit, Failure> {
    if let Some(path) = &args.output {
        check_file_target(path, args.force)?;
    }
    let found = fit_colliders(&args.input, &args.read.options(), &args.fit.options())
        .map_err(|e| Failure::of_input(&args.input, e))?;
    // Written before the report, and in its place after it: no report of what could not be written, no file without one.
    let scene = (args.output.as_ref())
        .map(|path| {
            let text = serde_json::to_string_pretty(&scene(&found)).map_err(|e| Failure::refused(e.to_string()))?;
            Ok::<_, Failure>((path, Pending::write(path, (text + "\n").as_bytes())?))
        })
        .transpose()?;
    if out.json {
        out.json(&report(&found))?;
    } else {
        out.data(&text(out, &found))?;
    }
    let mut exit = Exit::Done;
    for finding in &found.findings {
        let tone = if finding.severity == Severity::Warning { Tone::Warning } else { Tone::Note };
        if finding.stage == "colliders" {
            exit = if finding.severity == Severity::Warning { Exit::Findings } else { exit };
        } else if !out.verbose {
            continue;
        }
        let label = if finding.severity == Severity::Warning { "warning" } else { "note" };
        out.remark(tone, label, &format!("{}: {}: {}", found.file, finding.kind, finding.message));
    }
    if let Some((path, file)) = scene {
        file.commit()?;
        out.say(&format!("wrote {}: {} colliders", path.display(), found.colliders.len()));
    }
    Ok(exit)
}

fn text(out: &Output, fit: &Fit) -> String {
    let mut table = Table::new(&["<joint", "<shape", "<sizes (mm)", "mean (mm)", "95 % (mm)", "max (mm)"]);
    let mm = |x: f64| format!("{:.2}", 1e3 * x);
    for (collider, error) in fit.colliders.iter().zip(&fit.figures.of_each) {
        let (name, sizes) = match collider.solid.form {
            Form::Sphere { radius } => ("sphere", vec![radius]),
            Form::Capsule { half_height, radius } => ("capsule", vec![half_height, radius]),
            Form::TaperedCapsule { half_height, radii: [low, high] } => {
                ("tapered_capsule", vec![half_height, low, high])
            }
            Form::Box { half } => ("box", half.to_vec()),
            Form::Ellipsoid { radii } => ("ellipsoid", radii.to_vec()),
        };
        let sizes: Vec<String> = sizes.iter().map(|s| format!("{:.1}", 1e3 * s)).collect();
        table.row([
            collider.joint.clone().unwrap_or_else(|| NOTHING.into()) + if collider.guessed { " (guessed)" } else { "" },
            name.into(),
            sizes.join(" x "),
            mm(error.mean),
            mm(error.p95),
            mm(error.max),
        ]);
    }
    let body = &fit.figures.body;
    format!(
        "{}  body: {}\n{} colliders; body to colliders: mean {} mm, 95 % {} mm, max {} mm; outside the body: {:.2} l, up to {} mm\n\n{}",
        out.heading(&plain(&fit.file)),
        plain(&fit.parts.join(", ")),
        fit.colliders.iter().filter(|collider| !collider.guessed).count(),
        mm(body.mean),
        mm(body.p95),
        mm(body.max),
        1e3 * fit.figures.outside,
        mm(fit.figures.farthest),
        table.render(),
    )
}

fn report(fit: &Fit) -> Value {
    let each = fit.colliders.iter().zip(&fit.figures.of_each).map(|(collider, error)| {
        let mut entry = collider_json(collider);
        entry.insert("error".into(), json!(error));
        if collider.guessed {
            entry.insert("guessed".into(), json!(true));
        }
        entry
    });
    json!({
        "file": fit.file,
        "body": fit.parts,
        "error": fit.figures.body,
        "outside_m3": fit.figures.outside,
        "outside_max": fit.figures.farthest,
        "colliders": each.collect::<Vec<_>>(),
        "findings": fit.findings,
    })
}

/// A scene file (SCENE.md) of the colliders alone.
fn scene(fit: &Fit) -> Value {
    let colliders: Vec<_> = fit.colliders.iter().map(collider_json).collect();
    json!({"format": "gimage-scene", "version": 1, "name": fit.file, "cloths": [], "colliders": colliders})
}

/// Shape and pose, as SCENE.md has them.
fn collider_json(collider: &Collider) -> Map<String, Value> {
    let shape = match collider.solid.form {
        Form::Sphere { radius } => json!({"sphere": {"radius": radius}}),
        Form::Capsule { half_height, radius } => json!({"capsule": {"half_height": half_height, "radius": radius}}),
        Form::TaperedCapsule { half_height, radii } => {
            json!({"tapered_capsule": {"half_height": half_height, "radii": radii}})
        }
        Form::Box { half } => json!({"box": {"half": half}}),
        Form::Ellipsoid { radii } => json!({"ellipsoid": {"radii": radii, "closest": true}}),
    };
    let [x, y, z, w] = collider.solid.rotation;
    let sine = (x * x + y * y + z * z).sqrt();
    let mut entry = Map::new();
    if let Some(joint) = &collider.joint {
        entry.insert("joint".into(), json!(joint));
    }
    entry.insert("shape".into(), shape);
    entry.insert("position".into(), json!(collider.solid.center));
    if sine > 1e-9 {
        let degrees = 2.0 * sine.atan2(w).to_degrees();
        entry.insert("rotation".into(), json!({"axis": [x / sine, y / sine, z / sine], "degrees": degrees}));
    }
    entry
}
