//! A page of panels.

use std::fmt::{Display, Write};

use crate::axis::Log;

/// Space between panels, across and down.
const GAP: [f64; 2] = [18.0, 40.0];
/// Left, top, right, bottom.
const MARGIN: [f64; 4] = [92.0, 104.0, 22.0, 62.0];
/// Colours; the first eight also differ for colour-blind readers (Okabe, Ito 2008).
const COLOURS: [&str; 12] = [
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000", "#9A8C00", "#8C564B", "#5E4FA2",
    "#7FB800", "#A0A0A0",
];
/// Colour of titles and labels.
pub const INK: &str = "#222";
/// Colour of notes.
pub const FAINT: &str = "#666";

/// The colour of a series, by its index in the legend.
pub fn colour(series: usize) -> &'static str {
    COLOURS[series % COLOURS.len()]
}

/// A page that is being drawn. Coordinates are pixels, of the current panel once there is one.
pub struct Page {
    svg: String,
    panel: [f64; 2],
    grid: [usize; 2],
    open: bool,
}

/// The title, axes and labels of a panel.
pub struct Panel<'a> {
    /// Its title.
    pub title: &'a str,
    /// Its axes.
    pub x: Log,
    /// Upwards.
    pub y: Log,
    /// The lines of a label at a power of ten on the y axis, largest first.
    pub y_labels: fn(i32) -> Vec<String>,
    /// Label the y axis: it is the first panel of its line.
    pub left: bool,
    /// Label the x axis: there is no panel below it.
    pub bottom: bool,
}

impl Page {
    /// A page of `grid` (columns, lines) panels of a size in pixels, with a title and notes below it.
    pub fn new(panel: [f64; 2], grid: [usize; 2], title: &str, notes: &[&str]) -> Self {
        let mut page = Self { svg: String::new(), panel, grid: grid.map(|n| n.max(1)), open: false };
        let [width, height] = page.size();
        page.svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
             height=\"{height}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"11\" fill=\"{INK}\">\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
        );
        page.text([MARGIN[0], 30.0], "start", 17, INK, title);
        for (k, note) in notes.iter().enumerate() {
            page.text([MARGIN[0], 44.0 + 13.0 * k as f64], "start", 10, FAINT, note);
        }
        page
    }

    fn extent(&self, k: usize) -> f64 {
        self.grid[k] as f64 * (self.panel[k] + GAP[k]) - GAP[k]
    }

    fn size(&self) -> [f64; 2] {
        [self.extent(0) + MARGIN[0] + MARGIN[2], self.extent(1) + MARGIN[1] + MARGIN[3]]
    }

    /// Names the series, in the order of their indices. Call it before the first panel.
    pub fn legend(&mut self, names: &[String]) {
        let mut x = MARGIN[0] + 6.0;
        for (k, name) in names.iter().enumerate() {
            self.marker(k, [x, 72.0]);
            self.text([x + 11.0, 76.0], "start", 12, INK, name);
            x += 36.0 + 6.3 * name.len() as f64;
        }
    }

    /// Begins the panel in a column and line.
    pub fn panel(&mut self, place: [usize; 2], panel: &Panel<'_>) {
        self.close();
        let corner = [0, 1].map(|d| MARGIN[d] + place[d] as f64 * (self.panel[d] + GAP[d]));
        let _ = writeln!(self.svg, "<g transform=\"translate({} {})\">", corner[0], corner[1]);
        self.open = true;
        let ([w, h], x, y) = (self.panel, panel.x, panel.y);
        x.between().into_iter().for_each(|t| self.line([x.at(t), 0.0], [x.at(t), h], "#f3f3f3"));
        y.between().into_iter().for_each(|t| self.line([0.0, y.at(t)], [w, y.at(t)], "#f3f3f3"));
        for d in x.decades() {
            let at = x.at(10f64.powi(d));
            self.line([at, 0.0], [at, h], "#d4d4d4");
            if panel.bottom {
                self.text([at, h + 16.0], "middle", 11, INK, 10f64.powi(d));
            }
        }
        for d in y.decades() {
            let at = y.at(10f64.powi(d));
            self.line([0.0, at], [w, at], "#d4d4d4");
            let labels = if panel.left { (panel.y_labels)(d) } else { Vec::new() };
            for (k, label) in labels.iter().enumerate() {
                let (size, colour) = if k == 0 { (11, INK) } else { (9, FAINT) };
                self.text([-7.0, at + 4.0 + 11.0 * k as f64], "end", size, colour, label);
            }
        }
        let _ = writeln!(self.svg, "<rect width=\"{w}\" height=\"{h}\" fill=\"none\" stroke=\"#999\"/>");
        self.text([1.0, -7.0], "start", 13, INK, panel.title);
    }

    fn close(&mut self) {
        if std::mem::take(&mut self.open) {
            self.svg += "</g>\n";
        }
    }

    /// Text at a point, `anchor`ed as SVG says: start, middle or end.
    pub fn text(&mut self, [x, y]: [f64; 2], anchor: &str, size: u32, colour: &str, words: impl Display) {
        let words = words.to_string().replace('&', "&amp;").replace('<', "&lt;");
        let _ = writeln!(
            self.svg,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"{size}\" fill=\"{colour}\">{words}</text>"
        );
    }

    fn line(&mut self, [a, b]: [f64; 2], [c, d]: [f64; 2], colour: &str) {
        let _ =
            writeln!(self.svg, "<path d=\"M{a:.1} {b:.1}L{c:.1} {d:.1}\" stroke=\"{colour}\" stroke-width=\"0.8\"/>");
    }

    /// The curve of a series through points, without markers.
    pub fn curve(&mut self, series: usize, points: &[[f64; 2]]) {
        let path: Vec<String> = points.iter().map(|p| format!("{:.1},{:.1}", p[0], p[1])).collect();
        let (colour, path) = (colour(series), path.join(" "));
        let _ =
            writeln!(self.svg, "<polyline points=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\"/>");
    }

    /// A circle, square, diamond or triangle, so that series differ without colour too.
    pub fn marker(&mut self, series: usize, [x, y]: [f64; 2]) {
        let colour = colour(series);
        let shape = match series % 4 {
            0 => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.6\""),
            1 => format!("<rect x=\"{:.1}\" y=\"{:.1}\" width=\"6.6\" height=\"6.6\"", x - 3.3, y - 3.3),
            2 => format!("<path d=\"M{x:.1} {:.1}l4.6 4.6l-4.6 4.6l-4.6 -4.6z\"", y - 4.6),
            _ => format!("<path d=\"M{x:.1} {:.1}l4.6 7.9h-9.2z\"", y - 5.0),
        };
        let _ = writeln!(self.svg, "{shape} fill=\"{colour}\" stroke=\"white\" stroke-width=\"0.8\"/>");
    }

    /// The page as SVG, with the names of its axes.
    pub fn finish(mut self, x: &str, y: &str) -> String {
        self.close();
        let middle = [MARGIN[0] + 0.5 * self.extent(0), MARGIN[1] + 0.5 * self.extent(1)];
        let height = self.size()[1];
        self.text([middle[0], height - 14.0], "middle", 13, INK, x);
        let _ = writeln!(self.svg, "<g transform=\"translate(22 {}) rotate(-90)\">", middle[1]);
        self.text([0.0, 0.0], "middle", 13, INK, y);
        self.svg + "</g>\n</svg>\n"
    }
}
