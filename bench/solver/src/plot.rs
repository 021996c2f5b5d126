//! The plot: time a frame against error, a row of panels a scene and a column a size, both axes logarithmic.

use std::fmt::{Display, Write};

use crate::row::Row;
use crate::scale::Log;

const PANEL: [f64; 2] = [230.0, 170.0];
const GAP: [f64; 2] = [18.0, 40.0];
/// Left, top, right, bottom.
const MARGIN: [f64; 4] = [92.0, 104.0, 22.0, 62.0];
/// Colours that also differ for colour-blind readers (Okabe, Ito 2008).
const COLOURS: [&str; 8] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000", "#9A8C00"];
const INK: &str = "#222";
const FAINT: &str = "#666";
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
    let extent = |k: usize, n: usize| n.max(1) as f64 * (PANEL[k] + GAP[k]) - GAP[k];
    let (wide, high) = (extent(0, sizes.len()), extent(1, scenes.len()));
    let [width, height] = [wide + MARGIN[0] + MARGIN[2], high + MARGIN[1] + MARGIN[3]];
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"11\" fill=\"{INK}\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    text(&mut svg, [MARGIN[0], 30.0], "start", 17, INK, "Run time against error");
    let note = "Least (s2, s2f: median) milliseconds of a frame; numbers at the points: steps per frame.";
    text(&mut svg, [MARGIN[0], 44.0], "start", 10, FAINT, note);
    let note = "Error: largest stretch, for s3 that of the period; off scale above 1000 %. Lower left is better.";
    text(&mut svg, [MARGIN[0], 57.0], "start", 10, FAINT, note);
    let mut x = MARGIN[0] + 6.0;
    for (k, solver) in solvers.iter().enumerate() {
        marker(&mut svg, k, [x, 72.0]);
        text(&mut svg, [x + 11.0, 76.0], "start", 12, INK, solver);
        x += 36.0 + 6.3 * solver.len() as f64;
    }
    for (line, scene) in scenes.iter().enumerate() {
        let of_scene = || rows.iter().filter(|r| r.scene == *scene).filter_map(point);
        let y = Log::around(of_scene().map(|p| p[1]), PANEL[1], 0.0);
        for (column, n) in sizes.iter().enumerate() {
            let of_size = rows.iter().filter(|r| r.n == *n).filter_map(point);
            let x = Log::around(of_size.map(|p| p[0]), 0.0, PANEL[0]);
            let corner = [0, 1].map(|d| MARGIN[d] + [column, line][d] as f64 * (PANEL[d] + GAP[d]));
            let _ = writeln!(svg, "<g transform=\"translate({} {})\">", corner[0], corner[1]);
            frame(&mut svg, &format!("{scene}, {n} x {n}"), x, y, column == 0, line + 1 == scenes.len());
            for (k, solver) in solvers.iter().enumerate() {
                let of = |r: &&Row| r.scene == *scene && r.n == *n && r.solver == *solver;
                series(&mut svg, k, &rows.iter().filter(of).collect::<Vec<_>>(), x, y);
            }
            svg += "</g>\n";
        }
    }
    let middle = [MARGIN[0] + 0.5 * wide, MARGIN[1] + 0.5 * high];
    text(&mut svg, [middle[0], height - 14.0], "middle", 13, INK, "time a frame [ms]");
    let _ = writeln!(svg, "<g transform=\"translate(22 {}) rotate(-90)\">", middle[1]);
    text(&mut svg, [0.0, 0.0], "middle", 13, INK, "error [%]");
    svg + "</g>\n</svg>\n"
}

fn text(svg: &mut String, [x, y]: [f64; 2], anchor: &str, size: u32, colour: &str, words: impl Display) {
    let _ = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"{size}\" fill=\"{colour}\">{words}</text>"
    );
}

fn line(svg: &mut String, [a, b]: [f64; 2], [c, d]: [f64; 2], colour: &str) {
    let _ = writeln!(svg, "<path d=\"M{a:.1} {b:.1}L{c:.1} {d:.1}\" stroke=\"{colour}\" stroke-width=\"0.8\"/>");
}

/// A circle, square, diamond or triangle, so that solvers differ without colour too.
fn marker(svg: &mut String, solver: usize, [x, y]: [f64; 2]) {
    let colour = COLOURS[solver % COLOURS.len()];
    let shape = match solver % 4 {
        0 => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.6\""),
        1 => format!("<rect x=\"{:.1}\" y=\"{:.1}\" width=\"6.6\" height=\"6.6\"", x - 3.3, y - 3.3),
        2 => format!("<path d=\"M{x:.1} {:.1}l4.6 4.6l-4.6 4.6l-4.6 -4.6z\"", y - 4.6),
        _ => format!("<path d=\"M{x:.1} {:.1}l4.6 7.9h-9.2z\"", y - 5.0),
    };
    let _ = writeln!(svg, "{shape} fill=\"{colour}\" stroke=\"white\" stroke-width=\"0.8\"/>");
}

/// A panel without its points; errors are labelled at the left and times at the bottom.
fn frame(svg: &mut String, title: &str, x: Log, y: Log, left: bool, bottom: bool) {
    let [w, h] = PANEL;
    x.between().into_iter().for_each(|t| line(svg, [x.at(t), 0.0], [x.at(t), h], "#f3f3f3"));
    y.between().into_iter().for_each(|t| line(svg, [0.0, y.at(t)], [w, y.at(t)], "#f3f3f3"));
    for d in x.decades() {
        let at = x.at(10f64.powi(d));
        line(svg, [at, 0.0], [at, h], "#d4d4d4");
        if bottom {
            text(svg, [at, h + 16.0], "middle", 11, INK, 10f64.powi(d));
        }
    }
    for d in y.decades() {
        let at = y.at(10f64.powi(d));
        line(svg, [0.0, at], [w, at], "#d4d4d4");
        if left {
            text(svg, [-7.0, at + 4.0], "end", 11, INK, 10f64.powi(d));
        }
    }
    let _ = writeln!(svg, "<rect width=\"{w}\" height=\"{h}\" fill=\"none\" stroke=\"#999\"/>");
    text(svg, [1.0, -7.0], "start", 13, INK, title);
}

/// The points of a solver in one panel, joined in the order of their substeps.
fn series(svg: &mut String, solver: usize, rows: &[&Row], x: Log, y: Log) {
    let mut points: Vec<(u32, [f64; 2])> = rows.iter().filter_map(|r| Some((r.substeps, point(r)?))).collect();
    points.sort_by_key(|p| p.0);
    let at: Vec<[f64; 2]> = points.iter().map(|(_, p)| [x.at(p[0]), y.at(p[1])]).collect();
    let path: Vec<String> = at.iter().map(|p| format!("{:.1},{:.1}", p[0], p[1])).collect();
    let (colour, path) = (COLOURS[solver % COLOURS.len()], path.join(" "));
    let _ = writeln!(svg, "<polyline points=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\"/>");
    for ((substeps, _), p) in points.iter().zip(at) {
        marker(svg, solver, p);
        text(svg, [p[0] + 5.0, p[1] - 5.0], "start", 8, colour, substeps);
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
