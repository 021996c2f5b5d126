//! The plot: time a frame against error, a row of panels a scene and a column a size, both axes logarithmic.

use gimage_bench_plot::{Log, Page, Panel, colour};

use crate::row::Row;

/// Width and height of a panel in pixels.
const PANEL: [f64; 2] = [230.0, 170.0];
/// Errors below this are drawn at it: a logarithm has no zero \[%\].
const FLOOR: f64 = 1e-3;
/// And above this \[%\].
const CEILING: f64 = 1e3;

/// Time and error of a row, if it has any.
fn point(row: &Row) -> Option<[f64; 2]> {
    row.error().filter(|e| e.is_finite() && row.time() > 0.0).map(|e| [row.time(), e.clamp(FLOOR, CEILING)])
}

/// What differs between rows, each once, in the order of the table.
fn distinct<K: PartialEq>(rows: &[Row], of: impl Fn(&Row) -> K) -> Vec<K> {
    let mut out: Vec<K> = Vec::new();
    for value in rows.iter().filter(|r| point(r).is_some()).map(of) {
        if !out.contains(&value) {
            out.push(value);
        }
    }
    out
}

/// The plot as SVG.
pub fn draw(rows: &[Row]) -> String {
    let (scenes, sizes) = (distinct(rows, |r| r.scene.clone()), distinct(rows, |r| r.n));
    let solvers = distinct(rows, |r| r.solver.clone());
    let notes = [
        "Least (s2, s2f: median) milliseconds of a frame; numbers at the points: steps per frame.",
        "Error: largest stretch, for s3 that of the period; off scale above 1000 %. Lower left is better.",
    ];
    let mut page = Page::new(PANEL, [sizes.len(), scenes.len()], "Run time against error", &notes);
    page.legend(&solvers);
    for (line, scene) in scenes.iter().enumerate() {
        let of_scene = || rows.iter().filter(|r| r.scene == *scene).filter_map(point);
        let y = Log::around(of_scene().map(|p| p[1]), PANEL[1], 0.0);
        for (column, n) in sizes.iter().enumerate() {
            let of_size = rows.iter().filter(|r| r.n == *n).filter_map(point);
            let x = Log::around(of_size.map(|p| p[0]), 0.0, PANEL[0]);
            let title = &format!("{scene}, {n} x {n}");
            let y_labels = |d| vec![10f64.powi(d).to_string()];
            let (left, bottom) = (column == 0, line + 1 == scenes.len());
            page.panel([column, line], &Panel { title, x, y, y_labels, left, bottom });
            for (k, solver) in solvers.iter().enumerate() {
                let of = |r: &&Row| r.scene == *scene && r.n == *n && r.solver == *solver;
                series(&mut page, k, &rows.iter().filter(of).collect::<Vec<_>>(), x, y);
            }
        }
    }
    page.finish("time a frame [ms]", "error [%]")
}

/// The points of a solver in one panel, joined in the order of their substeps.
fn series(page: &mut Page, solver: usize, rows: &[&Row], x: Log, y: Log) {
    let mut points: Vec<(u32, [f64; 2])> = rows.iter().filter_map(|r| Some((r.substeps, point(r)?))).collect();
    points.sort_by_key(|p| p.0);
    let at: Vec<[f64; 2]> = points.iter().map(|(_, p)| [x.at(p[0]), y.at(p[1])]).collect();
    page.curve(solver, &at);
    for ((substeps, _), p) in points.iter().zip(at) {
        page.marker(solver, p);
        page.text([p[0] + 5.0, p[1] - 5.0], "start", 8, colour(solver), substeps);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::Figures;

    fn row(scene: &str, n: u32, solver: &'static str, ms_min: f64, stretch: f64) -> Row {
        let figures = Figures { stretch_max: Some(stretch), ..Figures::default() };
        let (scene, backend) = (scene.into(), "cpu");
        Row { scene, n, solver: solver.into(), substeps: 8, backend, frames: 1, ms_min, ms_median: ms_min, figures }
    }

    #[test]
    fn every_point_is_drawn_and_nothing_is_not_a_number() {
        let rows =
            [row("s1", 32, "classic", 0.1, 0.3), row("s1", 64, "xpbd", 0.2, f64::NAN), row("s2", 64, "xpbd", 0.2, 0.0)];
        let svg = draw(&rows);
        // Each solver once in the legend and once in its panel.
        assert_eq!((svg.matches("<circle").count(), svg.matches("width=\"6.6\"").count()), (2, 2));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert_eq!(svg.matches("<g ").count(), svg.matches("</g>").count());
    }

    #[test]
    fn a_table_without_points_still_draws() {
        assert!(draw(&[]).ends_with("</svg>\n"));
    }
}
