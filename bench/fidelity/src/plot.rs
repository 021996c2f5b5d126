//! The plot of a run: CPU time against error, a panel a mesh, a colour a family of settings, both axes logarithmic.

use gimage_bench_plot::{FAINT, Log, Page, Panel};

use crate::Failure;
use crate::args::PlotArgs;
use crate::row::{Row, parse};

/// Panels side by side.
const COLUMNS: usize = 4;
/// Width and height of a panel in pixels.
const PANEL: [f64; 2] = [250.0, 200.0];

/// Draws the plot of a table beside it.
pub fn run(args: &PlotArgs) -> Result<(), Failure> {
    let rows = parse(&std::fs::read_to_string(&args.csv)?)?;
    std::fs::write(args.csv.with_extension("svg"), draw(&rows))?;
    Ok(())
}

/// The point of a row: CPU time and error, where both are known.
fn point(row: &Row) -> Option<[f64; 2]> {
    let at = |name: &str| row.values.get(name).copied().filter(|x| *x > 0.0 && x.is_finite());
    Some([at("cpu_s_median")?, at("rms_rel")?])
}

/// Distinct values of the rows, in the order of the table.
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
    let points = || rows.iter().filter_map(point);
    let x = Log::around(points().map(|p| p[0]), 0.0, PANEL[0]);
    // A peer that failed on one mesh must not squeeze every panel: it is drawn at the edge, with its value.
    let own = rows.iter().filter(|r| r.method == "gimage").filter_map(point);
    let worst = 3.0 * own.map(|p| p[1]).fold(0.0, f64::max);
    let shown = points().map(|p| p[1]).filter(|&e| worst == 0.0 || e <= worst);
    let y = Log::around(shown, PANEL[1], 0.0);
    let notes = [
        "Median CPU seconds, file to bundle (peers: their map alone); numbers at the points: texels a side.",
        "Lower left is better.",
    ];
    let grid = [columns, meshes.len().div_ceil(columns)];
    let mut page = Page::new(PANEL, grid, "What a build costs, and how faithful it is", &notes);
    page.legend(&families);
    for (k, mesh) in meshes.iter().enumerate() {
        let y_labels = |d: i32| vec![format!("1e{d}"), format!("{} dB", -20 * d)];
        let (left, bottom) = (k % columns == 0, k + columns >= meshes.len());
        page.panel([k % columns, k / columns], &Panel { title: mesh, x, y, y_labels, left, bottom });
        for (f, family) in families.iter().enumerate() {
            let of = |r: &&Row| r.mesh == *mesh && r.family() == *family;
            series(&mut page, f, &rows.iter().filter(of).collect::<Vec<_>>(), x, y);
        }
    }
    page.finish("CPU time [s]", "RMS error / bounding-box diagonal (PSNR)")
}

/// The points of a family in one panel, joined in the order of their texels.
fn series(page: &mut Page, family: usize, rows: &[&Row], x: Log, y: Log) {
    let mut points: Vec<(u32, [f64; 2])> = rows.iter().filter_map(|r| Some((r.texels, point(r)?))).collect();
    points.sort_by_key(|p| p.0);
    let at: Vec<[f64; 2]> = points.iter().map(|(_, p)| [x.at(p[0]), y.at(p[1]).max(0.0)]).collect();
    page.curve(family, &at);
    for ((texels, value), p) in points.iter().zip(at) {
        page.marker(family, p);
        if p[1] == 0.0 {
            let label = format!("off scale, {:.0} dB", -20.0 * value[1].log10());
            page.text([p[0] - 8.0, 13.0], "end", 9, FAINT, label);
        }
        // One family's labels do for all: the same texels lie on about one level.
        if family == 0 {
            let (x, anchor) = if p[0] > PANEL[0] - 30.0 { (p[0] - 7.0, "end") } else { (p[0] + 7.0, "start") };
            page.text([x, p[1] - 5.0], anchor, 9, FAINT, texels);
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
        assert_eq!((svg.matches("<circle").count(), svg.matches("height=\"6.6\"").count()), (2, 2));
        assert!(svg.contains("a&lt;b") && !svg.contains("NaN") && !svg.contains("inf"));
        assert_eq!(svg.matches("<g ").count(), svg.matches("</g>").count());
    }

    #[test]
    fn a_table_without_points_still_draws() {
        assert!(draw(&[]).ends_with("</svg>\n"));
    }
}
