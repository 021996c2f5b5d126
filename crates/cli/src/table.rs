//! Aligned columns of plain text.

use crate::output::plain;

/// Rows of cells under headings. A heading that starts with `<` stands for a column aligned to the left.
#[derive(Clone, Debug, Default)]
pub struct Table {
    headings: Vec<&'static str>,
    rows: Vec<Vec<String>>,
}

/// The text of a cell without a value.
pub const NOTHING: &str = "-";

impl Table {
    /// A table without rows.
    pub fn new(headings: &[&'static str]) -> Self {
        Table { headings: headings.to_vec(), rows: Vec::new() }
    }

    /// Appends a row; missing cells are empty.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        let mut row: Vec<String> = cells.into_iter().map(|c| plain(&c).replace('\n', " ")).collect();
        row.resize(self.headings.len(), String::new());
        self.rows.push(row);
    }

    /// The table, indented by two spaces. Columns without any value are left out, and so are the headings if all are
    /// empty; a table with nothing beside its first column is nothing.
    pub fn render(&self) -> String {
        let valued = |c: &usize| self.rows.iter().any(|r| !r[*c].is_empty() && r[*c] != NOTHING);
        let columns: Vec<usize> = (0..self.headings.len()).filter(valued).collect();
        if columns.iter().all(|&c| c == 0 && self.headings.len() > 1) {
            return String::new();
        }
        let heading = |c: usize| self.headings[c].trim_start_matches('<');
        let width = |c: usize| self.rows.iter().map(|r| count(&r[c])).max().unwrap_or(0).max(count(heading(c)));
        let widths: Vec<usize> = columns.iter().map(|&c| width(c)).collect();
        let mut text = String::new();
        let mut line = |cells: Vec<&str>| {
            let mut line = String::new();
            for ((cell, &width), &c) in cells.iter().zip(&widths).zip(&columns) {
                let space = " ".repeat(width - count(cell));
                line += "  ";
                line += &if self.headings[c].starts_with('<') {
                    format!("{cell}{space}")
                } else {
                    format!("{space}{cell}")
                };
            }
            text += line.trim_end();
            text.push('\n');
        };
        if columns.iter().any(|&c| !heading(c).is_empty()) {
            line(columns.iter().map(|&c| heading(c)).collect());
        }
        for row in &self.rows {
            line(columns.iter().map(|&c| row[c].as_str()).collect());
        }
        text
    }
}

fn count(text: &str) -> usize {
    text.chars().count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up_and_empty_ones_vanish() {
        let mut table = Table::new(&["<piece", "nothing", "area"]);
        table.row(["body".into(), NOTHING.into(), "1.2 m²".into()]);
        table.row(["left sleeve".into(), String::new(), "12.0 mm²".into()]);
        assert_eq!(table.render(), "  piece            area\n  body           1.2 m²\n  left sleeve  12.0 mm²\n");
    }

    #[test]
    fn names_cannot_steer_the_terminal() {
        let mut table = Table::new(&["<"]);
        table.row(["a\x1b[2Jb\nc".into()]);
        assert_eq!(table.render(), "  a\u{fffd}[2Jb c\n");
    }
}
