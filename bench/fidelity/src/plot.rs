//! The plot of a run: CPU time against error, a panel a mesh, a colour a family of settings, both axes logarithmic.

use std::fmt::Write;

use crate::Failure;
use crate::args::PlotArgs;
use crate::row::{Row, parse};
use crate::scale::Log;

const COLUMNS: usize = 4;
const PANEL: [f64; 2] = [250.0, 200.0];
const GAP: [f64; 2] = [18.0, 40.0];
/// Left, top, right, bottom.
const MARGIN: [f64; 4] = [92.0, 104.0, 22.0, 62.0];
/// Colours that also differ for colour-blind readers (Okabe, Ito 2008).
const COLOURS: [&str; 8] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000", "#9A8C00"];
const INK: &str = "#222";
const FAINT: &str = "#666";

/// Draws the plot of a table beside it.
pub fn run(args: &PlotArgs) -> Result<(), Failure> {
    let rows = parse(&std::fs::read_to_string(&args.csv)?)?;
    std::fs::write(args.csv.with_extension("svg"), draw(&rows))?;
    Ok(())
}

/// What a row shows: CPU time and error, where both are known.
fn point(row: &Row) -> Option<[f64; 2]> {
    let at = |name: &str| row.values.get(name).copied().filter(|x| *x > 0.0 && x.is_finite());
    Some([at("cpu_s_median")?, at("rms_rel")?])
}

/// What differs between rows, each once, in the order of the table.
fn distinct(rows: &[Row], of: impl Fn(&Row) -> String) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for value in rows.iter().filter(|r| point(r).is_some()).map(of) {
        if !out.contains(&value) {
            out.push(value);
        }
    }
    out
}

/// The plot as SVG.
pub fn draw(rows: &[Row]) -> String {
    let (meshes, families) = (distinct(rows, |r| r.mesh.clone()), distinct(rows, Row::family));
    let columns = meshes.len().clamp(1, COLUMNS);
    let lines = meshes.len().div_ceil(columns).max(1);
    let extent = |k: usize, n: usize| n as f64 * (PANEL[k] + GAP[k]) - GAP[k];
    let [width, height] = [extent(0, columns) + MARGIN[0] + MARGIN[2], extent(1, lines) + MARGIN[1] + MARGIN[3]];
    let points = || rows.iter().filter_map(point);
    let x = Log::around(points().map(|p| p[0]), 0.0, PANEL[0]);
    // A peer that failed on one mesh must not squeeze every panel: it is drawn at the edge, with its value.
    let own = rows.iter().filter(|r| r.method == "gimage").filter_map(point);
    let worst = 3.0 * own.map(|p| p[1]).fold(0.0, f64::max);
    let shown = points().map(|p| p[1]).filter(|&e| worst == 0.0 || e <= worst);
    let y = Log::around(shown, PANEL[1], 0.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"11\" fill=\"{INK}\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    text(&mut svg, [MARGIN[0], 30.0], "start", 17, INK, "What a build costs, and how faithful it is");
    let note = "Median CPU seconds, file to bundle (peers: their map alone); numbers at the points: texels a side. \
                Lower left is better.";
    text(&mut svg, [MARGIN[0], 49.0], "start", 11, FAINT, note);
    legend(&mut svg, &families);
    for (k, mesh) in meshes.iter().enumerate() {
        let corner = [0, 1].map(|d| MARGIN[d] + [k % columns, k / columns][d] as f64 * (PANEL[d] + GAP[d]));
        let _ = writeln!(svg, "<g transform=\"translate({} {})\">", corner[0], corner[1]);
        frame(&mut svg, mesh, x, y, k % columns == 0, k + columns >= meshes.len());
        for (f, family) in families.iter().enumerate() {
            let of = |r: &&Row| r.mesh == *mesh && r.family() == *family;
            series(&mut svg, f, &rows.iter().filter(of).collect::<Vec<_>>(), x, y);
        }
        svg += "</g>\n";
    }
    let middle = [MARGIN[0] + 0.5 * extent(0, columns), MARGIN[1] + 0.5 * extent(1, lines)];
    text(&mut svg, [middle[0], height - 14.0], "middle", 13, INK, "CPU time [s]");
    let _ = writeln!(svg, "<g transform=\"translate(22 {}) rotate(-90)\">", middle[1]);
    text(&mut svg, [0.0, 0.0], "middle", 13, INK, "RMS error / bounding-box diagonal (PSNR)");
    svg + "</g>\n</svg>\n"
}

fn text(svg: &mut String, at: [f64; 2], anchor: &str, size: u32, colour: &str, words: &str) {
    let words = words.replace('&', "&amp;").replace('<', "&lt;");
    let [x, y] = at;
    let _ = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"{size}\" fill=\"{colour}\">{words}</text>"
    );
}

fn line(svg: &mut String, from: [f64; 2], to: [f64; 2], colour: &str) {
    let ([a, b], [c, d]) = (from, to);
    let _ = writeln!(svg, "<path d=\"M{a:.1} {b:.1}L{c:.1} {d:.1}\" stroke=\"{colour}\" stroke-width=\"0.8\"/>");
}

fn legend(svg: &mut String, families: &[String]) {
    let mut x = MARGIN[0] + 6.0;
    for (k, family) in families.iter().enumerate() {
        marker(svg, k, [x, 72.0]);
        text(svg, [x + 11.0, 76.0], "start", 12, INK, family);
        x += 36.0 + 6.3 * family.len() as f64;
    }
}

/// A circle, square, diamond or triangle, so that families differ without colour too.
fn marker(svg: &mut String, family: usize, [x, y]: [f64; 2]) {
    let colour = COLOURS[family % COLOURS.len()];
    let shape = match family % 4 {
        0 => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.8\""),
        1 => format!("<rect x=\"{:.1}\" y=\"{:.1}\" width=\"7\" height=\"7\"", x - 3.5, y - 3.5),
        2 => format!("<path d=\"M{x:.1} {:.1}l4.8 4.8l-4.8 4.8l-4.8 -4.8z\"", y - 4.8),
        _ => format!("<path d=\"M{x:.1} {:.1}l4.8 8.2h-9.6z\"", y - 5.2),
    };
    let _ = writeln!(svg, "{shape} fill=\"{colour}\" stroke=\"white\" stroke-width=\"0.8\"/>");
}

/// A panel without its points; ticks are labelled at the outer panels only.
fn frame(svg: &mut String, mesh: &str, x: Log, y: Log, left: bool, bottom: bool) {
    let [w, h] = PANEL;
    x.between().into_iter().for_each(|t| line(svg, [x.at(t), 0.0], [x.at(t), h], "#f3f3f3"));
    y.between().into_iter().for_each(|t| line(svg, [0.0, y.at(t)], [w, y.at(t)], "#f3f3f3"));
    for d in x.decades() {
        let at = x.at(10f64.powi(d));
        line(svg, [at, 0.0], [at, h], "#d4d4d4");
        if bottom {
            text(svg, [at, h + 16.0], "middle", 11, INK, &format!("{}", 10f64.powi(d)));
        }
    }
    for d in y.decades() {
        let at = y.at(10f64.powi(d));
        line(svg, [0.0, at], [w, at], "#d4d4d4");
        if left {
            text(svg, [-7.0, at + 1.0], "end", 11, INK, &format!("1e{d}"));
            text(svg, [-7.0, at + 13.0], "end", 9, FAINT, &format!("{} dB", -20 * d));
        }
    }
    let _ = writeln!(svg, "<rect width=\"{w}\" height=\"{h}\" fill=\"none\" stroke=\"#999\"/>");
    text(svg, [1.0, -7.0], "start", 13, INK, mesh);
}

/// The points of a family in one panel, joined in the order of their texels.
fn series(svg: &mut String, family: usize, rows: &[&Row], x: Log, y: Log) {
    let mut points: Vec<(u32, [f64; 2])> = rows.iter().filter_map(|r| Some((r.texels, point(r)?))).collect();
    points.sort_by_key(|p| p.0);
    let at: Vec<[f64; 2]> = points.iter().map(|(_, p)| [x.at(p[0]), y.at(p[1]).max(0.0)]).collect();
    let path: Vec<String> = at.iter().map(|p| format!("{:.1},{:.1}", p[0], p[1])).collect();
    let colour = COLOURS[family % COLOURS.len()];
    let _ = writeln!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\"/>",
        path.join(" ")
    );
    for ((texels, value), p) in points.iter().zip(at) {
        marker(svg, family, p);
        if p[1] == 0.0 {
            let label = format!("off scale, {:.0} dB", -20.0 * value[1].log10());
            text(svg, [p[0] - 8.0, 13.0], "end", 9, FAINT, &label);
        }
        // One family's labels do for all: the same texels lie on about one level.
        if family == 0 {
            let (x, anchor) = if p[0] > PANEL[0] - 30.0 { (p[0] - 7.0, "end") } else { (p[0] + 7.0, "start") };
            text(svg, [x, p[1] - 5.0], anchor, 9, FAINT, &texels.to_string());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(mesh: &str, method: &str, cpu: f64, rms: f64) -> Row {
        let mut row = Row { mesh: mesh.into(), method: method.into(), texels: 65, ..Row::default() };
        row.values.insert("cpu_s_median".into(), cpu);
        row.values.insert("rms_rel".into(), rms);
        row
    }

    #[test]
    fn every_point_is_drawn_and_nothing_is_not_a_number() {
        let rows = [row("a<b", "gimage", 0.1, 1e-4), row("c", "slim", 3.0, 1e-3), row("c", "gimage", f64::NAN, 1.0)];
        let svg = draw(&rows);
        // Each family once in the legend and once in its panel.
        assert_eq!((svg.matches("<circle").count(), svg.matches("height=\"7\"").count()), (2, 2));
        assert!(svg.contains("a&lt;b") && !svg.contains("NaN") && !svg.contains("inf"));
        assert_eq!(svg.matches("<g ").count(), svg.matches("</g>").count());
    }

    #[test]
    fn a_table_without_points_still_draws() {
        assert!(draw(&[]).ends_with("</svg>\n"));
    }
}
