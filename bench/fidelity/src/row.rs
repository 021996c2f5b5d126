//! The table: one row a mesh, method and setting, as CSV.

use std::collections::BTreeMap;

use crate::Failure;
use crate::args::DETAIL;

/// The columns with words; those with numbers follow.
const WORDS: [&str; 8] = ["mesh", "method", "texels", "sample", "seams", "effort", "detail", "sizes"];

/// The columns with numbers, empty where nothing is known. `bench/README.md` says what they mean.
pub const NUMBERS: [&str; 46] = [
    "triangles",
    "repeats",
    "cpu_s_min",
    "cpu_s_median",
    "wall_s_min",
    "wall_s_median",
    "import_wall_s",
    "repair_wall_s",
    "component_wall_s",
    "image_wall_s",
    "maps_wall_s",
    "encode_wall_s",
    "write_wall_s",
    "import_cpu_s",
    "repair_cpu_s",
    "component_cpu_s",
    "image_cpu_s",
    "maps_cpu_s",
    "encode_cpu_s",
    "write_cpu_s",
    "cut_cpu_s",
    "peak_mib",
    "bytes_per_triangle",
    "psnr_db",
    "rms_rel",
    "hausdorff_rel",
    "normal_deg",
    "l2_stretch",
    "flips",
    "fold_area",
    "seam_gap_rel",
    "spring_anisotropy",
    "spring_p99_to_p1",
    "spring_angle_deg",
    "mass_p99_to_p1",
    "cut_rel",
    "cut_bought",
    "scorer_psnr_db",
    "scorer_rms_rel",
    "scorer_hausdorff_rel",
    "scorer_normal_deg",
    "scorer_l2_grid",
    "scorer_fold_area",
    "scorer_seam_gap_rel",
    "scorer_ring_gap",
    "scorer_euler_off",
];

/// Numbers by the name of their column.
pub type Values = BTreeMap<String, f64>;

/// One row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// The mesh by name.
    pub mesh: String,
    /// `gimage` or a peer.
    pub method: String,
    /// Side of the square that sets the texel budget.
    pub texels: u32,
    /// Where texels go; empty for peers.
    pub sample: String,
    /// Which edges the cut prefers; empty for peers.
    pub seams: String,
    /// How hard the search tries; empty for peers.
    pub effort: String,
    /// How far texels go where the surface bends; empty for peers.
    pub detail: String,
    /// Width x height of each image.
    pub sizes: String,
    /// The numbers.
    pub values: Values,
    /// The failure, if the row has no numbers.
    pub error: String,
}

impl Row {
    /// Name of rows of this kind in the plot and the legend.
    pub fn family(&self) -> String {
        match self.sample.as_str() {
            "" => self.method.clone(),
            sample => {
                let mut text = format!("{} {sample}, {} seams", self.method, self.seams);
                if !matches!(self.effort.as_str(), "" | "default") {
                    text += &format!(", {}", self.effort);
                }
                if !matches!(self.detail.as_str(), "" | DETAIL) {
                    text += &format!(", detail {}", self.detail);
                }
                text
            }
        }
    }

    fn line(&self) -> String {
        let texels = self.texels.to_string();
        let words =
            [&self.mesh, &self.method, &texels, &self.sample, &self.seams, &self.effort, &self.detail, &self.sizes]
                .map(|w| word(w));
        let numbers = NUMBERS.iter().map(|&n| self.values.get(n).map_or(String::new(), |&x| digits(x)));
        let all: Vec<String> = words.into_iter().chain(numbers).chain([word(&self.error)]).collect();
        all.join(",") + "\n"
    }
}

/// Five significant digits, which is more than two runs agree on.
fn digits(x: f64) -> String {
    if !x.is_finite() {
        return String::new();
    }
    let rounded: f64 = format!("{x:.4e}").parse().unwrap_or(x);
    if rounded != 0.0 && rounded.abs() < 1e-3 { format!("{rounded:e}") } else { format!("{rounded}") }
}

/// A text that needs no quotes.
fn word(text: &str) -> String {
    text.replace(',', ";").replace(['"', '\n', '\r'], " ")
}

/// The whole table.
pub fn csv(rows: &[Row]) -> String {
    let head: Vec<&str> = WORDS.into_iter().chain(NUMBERS).chain(["error"]).collect();
    rows.iter().fold(head.join(",") + "\n", |text, row| text + &row.line())
}

/// Reads a table that [`csv`] wrote, with the columns in any order.
pub fn parse(text: &str) -> Result<Vec<Row>, Failure> {
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().ok_or("the table is empty")?.split(',').collect();
    let row = |line: &str| -> Result<Row, Failure> {
        let mut row = Row::default();
        for (&name, cell) in head.iter().zip(line.split(',')) {
            match name {
                "mesh" => row.mesh = cell.into(),
                "method" => row.method = cell.into(),
                "texels" => row.texels = cell.parse()?,
                "sample" => row.sample = cell.into(),
                "seams" => row.seams = cell.into(),
                "effort" => row.effort = cell.into(),
                "detail" => row.detail = cell.into(),
                "sizes" => row.sizes = cell.into(),
                "error" => row.error = cell.into(),
                _ if cell.is_empty() => {}
                _ => row.values.extend([(name.to_owned(), cell.parse()?)]),
            }
        }
        Ok(row)
    };
    lines.map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_reads_back_as_it_was_written() {
        let mut row = Row { mesh: "cape".into(), method: "gimage".into(), texels: 65, ..Row::default() };
        (row.sample, row.seams, row.sizes) = ("fit".into(), "auto".into(), "70x60 9x9".into());
        row.values.insert("psnr_db".into(), 71.5);
        row.values.insert("rms_rel".into(), 2.5e-5);
        let failed = Row { error: "what; ever".into(), method: "slim".into(), ..row.clone() };
        let failed = Row { sample: String::new(), seams: String::new(), values: Values::new(), ..failed };
        assert_eq!(parse(&csv(&[row.clone(), failed.clone()])).unwrap(), [row, failed]);
    }

    #[test]
    fn numbers_are_short_and_texts_need_no_quotes() {
        assert_eq!([digits(1.234_567), digits(0.0), digits(1e-7), digits(66049.0)], ["1.2346", "0", "1e-7", "66049"]);
        assert_eq!(digits(f64::NAN), "");
        assert_eq!(word("a,b\n\"c"), "a;b  c");
    }
}
