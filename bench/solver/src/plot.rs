//! The plot: time per frame against error, both axes logarithmic: a row of panels per built-in scene and a column per size,
//! and below them a row per size of the garments and a column per garment.

mod points;

use gimage_bench_plot::{Log, Page, Panel, colour};

pub use points::{Point, read};

/// Width and height of a panel in pixels.
const PANEL: [f64; 2] = [230.0, 170.0];
/// Errors below this are drawn at it: a logarithm has no zero \[%\].
const FLOOR: f64 = 1e-3;
/// And above this \[%\].
const CEILING: f64 = 1e3;

/// An error as it is drawn.
fn shown(error: f64) -> f64 {
    error.clamp(FLOOR, CEILING)
}

/// The different values of a property of points, in the order in which they first occur.
fn distinct<'a, K: PartialEq>(points: impl Iterator<Item = &'a Point>, of: impl Fn(&Point) -> K) -> Vec<K> {
    let mut out: Vec<K> = Vec::new();
    for value in points.map(of) {
        if !out.contains(&value) {
            out.push(value);
        }
    }
    out
}

/// The plot as SVG.
pub fn draw(points: &[Point]) -> String {
    let flat = || points.iter().filter(|p| !p.worn);
    let worn = || points.iter().filter(|p| p.worn);
    let mut sizes = distinct(flat(), |p| p.n);
    sizes.sort_unstable();
    let scenes = distinct(flat(), |p| p.scene.clone());
    let (garments, texels) = (distinct(worn(), |p| p.scene.clone()), distinct(worn(), |p| p.n));
    let solvers = distinct(points.iter(), |p| p.solver.clone());
    let notes = [
        "Built-in scenes, without normals: least (s2, s2f: median) milliseconds of a frame; largest stretch, for s3 error of the period.",
        "Garments, with normals: 99th percentile of extension, mean and range of the runs. Numbers at the points: steps per frame, \
         iterations of NvCloth. Lower left is better.",
    ];
    let grid = [sizes.len().max(garments.len()), scenes.len() + texels.len()];
    let mut page = Page::new(PANEL, grid, "Run time against error", &notes);
    page.legend(&solvers);
    for (line, scene) in scenes.iter().enumerate() {
        let y = upwards(flat().filter(|p| p.scene == *scene));
        for (column, n) in sizes.iter().enumerate() {
            let x = Log::around(flat().filter(|p| p.n == *n).map(|p| p.ms), 0.0, PANEL[0]);
            let here: Vec<&Point> = flat().filter(|p| p.scene == *scene && p.n == *n).collect();
            let title = &format!("{scene}, {n} x {n}");
            panel(&mut page, [column, line], (title, line + 1 == scenes.len()), (x, y), (&solvers, &here));
        }
    }
    let y = upwards(worn());
    for (line, n) in texels.iter().enumerate() {
        for (column, garment) in garments.iter().enumerate() {
            let x = Log::around(worn().filter(|p| p.scene == *garment).map(|p| p.ms), 0.0, PANEL[0]);
            let here: Vec<&Point> = worn().filter(|p| p.scene == *garment && p.n == *n).collect();
            let (title, place) = (&format!("{garment}, {} texels", n * n), [column, scenes.len() + line]);
            panel(&mut page, place, (title, line + 1 == texels.len()), (x, y), (&solvers, &here));
        }
    }
    page.finish("time per frame [ms]", "error [%]")
}

/// The axis of errors.
fn upwards<'a>(points: impl Iterator<Item = &'a Point>) -> Log {
    Log::around(points.flat_map(|p| p.error).map(shown), PANEL[1], 0.0)
}

fn panel(
    page: &mut Page,
    place: [usize; 2],
    (title, bottom): (&str, bool),
    (x, y): (Log, Log),
    (solvers, here): (&[String], &[&Point]),
) {
    let y_labels = |d| vec![10f64.powi(d).to_string()];
    page.panel(place, &Panel { title, x, y, y_labels, left: place[0] == 0, bottom });
    for (k, solver) in solvers.iter().enumerate() {
        series(page, k, here.iter().filter(|p| p.solver == *solver), (x, y));
    }
}

/// The points of a solver in one panel, joined in the order of their steps; points with names stand alone.
fn series<'a>(page: &mut Page, solver: usize, points: impl Iterator<Item = &'a &'a Point>, (x, y): (Log, Log)) {
    let mut points: Vec<_> = points.map(|p| (p.label.parse::<u32>().ok(), *p)).collect();
    points.sort_by_key(|(steps, _)| *steps);
    let at = |p: &Point, error: f64| [x.at(p.ms), y.at(shown(error))];
    let joined: Vec<_> = points.iter().filter(|(steps, _)| steps.is_some()).map(|(_, p)| at(p, p.error[0])).collect();
    page.curve(solver, &joined);
    for (k, (steps, point)) in points.into_iter().enumerate() {
        let [middle, low, high] = point.error;
        if low < high {
            page.curve(solver, &[at(point, low), at(point, high)]);
        }
        let p = at(point, middle);
        page.marker(solver, p);
        // Names are long: they go where the panel has room, above and below their points in turn.
        let (anchor, side) = if steps.is_none() && p[0] > 0.5 * PANEL[0] { ("end", -1.0) } else { ("start", 1.0) };
        let up = if steps.is_none() && k % 2 == 1 { 11.0 } else { -5.0 };
        page.text([p[0] + 5.0 * side, p[1] + up], anchor, 8, colour(solver), &point.label);
    }
}

#[cfg(test)]
#[path = "plot/tests.rs"]
mod tests;
