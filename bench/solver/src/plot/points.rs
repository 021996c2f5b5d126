//! The points that the plot draws from a table.

use std::collections::BTreeMap;

use crate::Failure;

/// One setting of a solver in one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// The scene.
    pub scene: String,
    /// Particles along a side.
    pub n: u32,
    /// Whether it is a garment on a body, in a panel of another kind.
    pub worn: bool,
    /// The solver: its curve.
    pub solver: String,
    /// Steps per frame, which order the points of a curve; or a name, where each point stands alone.
    pub label: String,
    /// Milliseconds of a frame.
    pub ms: f64,
    /// The error, and the least and the largest of several runs \[%\].
    pub error: [f64; 3],
}

/// The lines of a table by the names of their columns.
struct Lines<'a> {
    names: Vec<&'a str>,
    lines: Vec<Vec<&'a str>>,
}

impl<'a> Lines<'a> {
    fn has(&self, name: &str) -> bool {
        self.names.contains(&name)
    }

    fn text(&self, line: &[&'a str], name: &str) -> &'a str {
        self.names.iter().position(|n| *n == name).and_then(|k| line.get(k)).copied().unwrap_or("")
    }

    fn number(&self, line: &[&str], name: &str) -> f64 {
        self.names.iter().position(|n| *n == name).and_then(|k| line.get(k)?.parse().ok()).unwrap_or(f64::NAN)
    }
}

/// The points of a table: of [`crate::row`], of [`crate::worn`], or of peers (`bench/peers/cloth.csv`). Lines without a time
/// or an error have none. Errors on a table of another kind.
pub fn read(table: &str) -> Result<Vec<Point>, Failure> {
    let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names = rows.next().unwrap_or_default();
    let lines = Lines { names, lines: rows.collect() };
    let all: Vec<Point> = if lines.has("extension_p99") {
        worn(&lines)
    } else if lines.has("error_pct") {
        lines.lines.iter().map(|line| peer(&lines, line)).collect()
    } else if lines.has("stretch_max") {
        lines.lines.iter().map(|line| built_in(&lines, line)).collect()
    } else {
        return Err("not a table of this program: no column extension_p99, error_pct or stretch_max".into());
    };
    Ok(all.into_iter().filter(|p| p.ms > 0.0 && p.ms.is_finite() && p.error.iter().all(|e| e.is_finite())).collect())
}

/// The least time where every frame has the same work, the median where cloth falls on a ball, as frames before it are
/// cheaper; the error of the period for the pendulum, the largest stretch for all others.
fn built_in(lines: &Lines, line: &[&str]) -> Point {
    let scene = lines.text(line, "scene").to_owned();
    let ms = lines.number(line, if scene.starts_with("s2") { "ms_median" } else { "ms_min" });
    let error = if scene == "s3" {
        lines.number(line, "period_error_pct").abs()
    } else {
        100.0 * lines.number(line, "stretch_max")
    };
    let (n, label) = (lines.number(line, "n") as u32, lines.text(line, "substeps").into());
    Point { scene, n, worn: false, solver: lines.text(line, "solver").into(), label, ms, error: [error; 3] }
}

fn peer(lines: &Lines, line: &[&str]) -> Point {
    let (scene, n) = (lines.text(line, "scene").into(), lines.number(line, "n") as u32);
    let (name, iterations) = (lines.text(line, "solver"), lines.text(line, "iterations"));
    let alone = iterations.is_empty();
    let (solver, label) = if alone { ("other solvers", name) } else { (name, iterations) };
    let (ms, error) = (lines.number(line, "ms"), lines.number(line, "error_pct"));
    Point { scene, n, worn: false, solver: solver.into(), label: label.into(), ms, error: [error; 3] }
}

/// A point for the runs of a setting: the least time, and the mean and range of the 99th percentile of extension.
fn worn(lines: &Lines) -> Vec<Point> {
    let (mut order, mut runs) = (Vec::new(), BTreeMap::<_, Vec<[f64; 2]>>::new());
    for line in &lines.lines {
        let key = ["scene", "texels", "substeps", "polish", "given"].map(|name| lines.text(line, name));
        if !order.contains(&key) {
            order.push(key);
        }
        let figures = [lines.number(line, "ms_min"), 100.0 * lines.number(line, "extension_p99")];
        runs.entry(key).or_default().push(figures);
    }
    let point = |key: [&str; 5]| {
        let [scene, texels, substeps, polish, given] = key;
        let all = runs.get(&key).map_or(&[][..], Vec::as_slice);
        let fold = |k: usize, start: f64, pick: fn(f64, f64) -> f64| all.iter().map(|f| f[k]).fold(start, pick);
        let mean = fold(1, 0.0, |a, b| a + b) / all.len().max(1) as f64;
        let solver = match (given, polish) {
            ("0", _) => "defaults".into(),
            (_, "0") => "xpbd".into(),
            (_, rounds) => format!("xpbd+polish{rounds}"),
        };
        Point {
            scene: scene.into(),
            n: texels.parse::<f64>().unwrap_or(0.0).sqrt() as u32,
            worn: true,
            solver,
            label: substeps.into(),
            ms: fold(0, f64::INFINITY, f64::min),
            error: [mean, fold(1, f64::INFINITY, f64::min), fold(1, 0.0, f64::max)],
        }
    };
    order.into_iter().map(point).collect()
}
