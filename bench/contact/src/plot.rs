//! The plot: time per frame against the contact distance, the particles per side and the number of cloths; a row of panels per scene.

use gimage_bench_plot::{INK, Log, Page, Panel};

use crate::run::{Failure, Row};

/// Width and height of a panel in pixels.
const PANEL: [f64; 2] = [230.0, 170.0];
/// The curves.
const TIERS: [&str; 3] = ["off", "particles", "safe"];
/// The setting that varies in each column of panels: its column of the table, and its name.
const AXES: [(&str, &str); 3] =
    [("distance", "distance / spacing"), ("n", "particles per side"), ("cloths", "number of cloths")];

/// A row of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    scene: String,
    tier: usize,
    /// By [`AXES`]; the distance of a run without contact is 0.
    at: [f64; 3],
    /// Mean time of a frame \[ms\].
    ms: f64,
}

/// The rows of a table of this program.
pub fn read(table: &str) -> Result<Vec<Point>, Failure> {
    let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names = lines.next().unwrap_or_default();
    let column = |name: &str| {
        let missing = || format!("not a table of this program: no column {name}; it has the columns {}", Row::HEAD);
        names.iter().position(|n| *n == name).ok_or_else(missing)
    };
    let (scene, tier, ms) = (column("scene")?, column("tier")?, column("ms_mean")?);
    let axes = [column(AXES[0].0)?, column(AXES[1].0)?, column(AXES[2].0)?];
    let point = |line: Vec<&str>| {
        let text = |k: usize| line.get(k).copied().unwrap_or_default();
        let number = |k: usize| {
            text(k).parse::<f64>().map_err(|_| format!("column {}: `{}` is not a number", names[k], text(k)))
        };
        let tier = TIERS.iter().position(|t| *t == text(tier)).ok_or_else(|| format!("no tier `{}`", text(tier)))?;
        let at = [number(axes[0])?, number(axes[1])?, number(axes[2])?];
        Ok(Point { scene: text(scene).into(), tier, at, ms: number(ms)? })
    };
    lines.filter(|line| line.len() > 1).map(point).collect()
}

/// The plot as SVG.
pub fn draw(points: &[Point]) -> String {
    let mut scenes: Vec<&str> = Vec::new();
    points.iter().for_each(|p| {
        if !scenes.contains(&&*p.scene) {
            scenes.push(&p.scene)
        }
    });
    let notes = [
        "Mean milliseconds of a frame. Each panel varies one setting; the others are those of the most runs of the scene.",
    ];
    let mut page = Page::new(PANEL, [AXES.len(), scenes.len()], "Time of contact of cloth with cloth", &notes);
    page.legend(&TIERS.map(String::from));
    for (line, scene) in scenes.iter().enumerate() {
        let here: Vec<&Point> = points.iter().filter(|p| p.scene == *scene).collect();
        let y = Log::around(here.iter().map(|p| p.ms), PANEL[1], 0.0);
        for (axis, (_, words)) in AXES.iter().enumerate() {
            let shown = varied(&here, axis);
            let x = Log::around(shown.iter().map(|p| p.at[axis]), 0.0, PANEL[0]);
            let (title, y_labels) = (&format!("{scene}: {words}"), |d| vec![10f64.powi(d).to_string()]);
            page.panel([axis, line], &Panel { title, x, y, y_labels, left: axis == 0, bottom: false });
            values(&shown, axis)
                .into_iter()
                .for_each(|at| page.text([x.at(at), PANEL[1] + 16.0], "middle", 11, INK, at));
            (0..TIERS.len()).for_each(|tier| curve(&mut page, &shown, (tier, axis), (x, y)));
        }
    }
    page.finish("setting", "time per frame [ms]")
}

/// The points that differ in one setting only, by the most frequent other ones. Runs without contact have no distance: they
/// belong to all.
fn varied<'a>(points: &[&'a Point], axis: usize) -> Vec<&'a Point> {
    let others = |p: &Point| [0, 1, 2].map(|k| if k == axis || (k == 0 && p.tier == 0) { None } else { Some(p.at[k]) });
    let fits = |p: &Point, of: &[Option<f64>; 3]| (0..3).all(|k| others(p)[k].zip(of[k]).is_none_or(|(a, b)| a == b));
    let mut best: (usize, Vec<&Point>) = (0, Vec::new());
    for of in points.iter().filter(|p| p.tier > 0).map(|p| others(p)) {
        let all: Vec<&Point> = points.iter().copied().filter(|p| fits(p, &of)).collect();
        let count = values(&all, axis).len();
        if count > best.0 {
            best = (count, all);
        }
    }
    best.1
}

/// The different values of a setting in runs with contact, ascending.
fn values(points: &[&Point], axis: usize) -> Vec<f64> {
    let mut values: Vec<f64> = points.iter().filter(|p| p.tier > 0).map(|p| p.at[axis]).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// The points of a tier, joined. Without contact, the time holds for every distance.
fn curve(page: &mut Page, shown: &[&Point], (tier, axis): (usize, usize), (x, y): (Log, Log)) {
    let of = |tier: usize| shown.iter().filter(move |p| p.tier == tier);
    let place = |at: f64, p: &Point| [x.at(at), y.at(p.ms)];
    let mut places: Vec<[f64; 2]> = if tier == 0 && axis == 0 {
        let reach = shown.iter().filter(|p| p.tier > 0).map(|p| p.at[0]);
        let ends = reach.fold([f64::INFINITY, 0.0], |[low, high], d| [low.min(d), high.max(d)]);
        of(0).take(1).flat_map(|p| ends.map(|end| place(end, p))).collect()
    } else {
        of(tier).map(|p| place(p.at[axis], p)).collect()
    };
    places.sort_by(|a, b| a[0].total_cmp(&b[0]));
    page.curve(tier, &places);
    places.into_iter().for_each(|p| page.marker(tier, p));
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "scene,n,distance,tier,cloths,ms_mean\nfold,32,0,off,1,0.1\nfold,32,0.5,particles,1,0.2\n\
        fold,32,1,particles,1,0.3\nfold,64,1,particles,1,1.2\nfold,64,0,off,1,0.4\nfold,64,1,safe,1,2\nlayers,24,1,safe,10,30\n";

    #[test]
    fn each_panel_varies_one_setting() {
        let points = read(TABLE).unwrap();
        let fold: Vec<&Point> = points.iter().filter(|p| p.scene == "fold").collect();
        let numbers = |axis: usize| varied(&fold, axis).iter().map(|p| p.ms).collect::<Vec<_>>();
        assert_eq!(numbers(0), [0.1, 0.2, 0.3], "two distances with 32 particles per side");
        assert_eq!(numbers(1), [0.1, 0.3, 1.2, 0.4, 2.0], "two sizes with a distance of 1");
        let svg = draw(&points);
        assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        assert!(svg.contains("layers: number of cloths"));
    }

    #[test]
    fn other_tables_are_refused() {
        assert!(read("a,b\n1,2\n").unwrap_err().to_string().contains("no column scene"));
        assert!(read(&TABLE.replace("0.3", "x")).unwrap_err().to_string().contains("`x`"));
        assert!(read(&TABLE.replace("safe", "surface")).is_err());
        assert!(draw(&[]).ends_with("</svg>\n"));
    }
}
