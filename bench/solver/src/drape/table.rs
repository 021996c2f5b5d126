//! The table of means.

use super::Rest;

/// Columns of a fabric: the truth, then the grids, coarsest first.
pub fn markdown(rests: &[Rest]) -> String {
    let (mut fabrics, mut columns): (Vec<&str>, Vec<(&str, [u32; 2])>) = (Vec::new(), Vec::new());
    for rest in rests {
        if !fabrics.contains(&&*rest.fabric) {
            fabrics.push(&rest.fabric);
        }
        if !columns.contains(&(rest.solver, rest.cells)) {
            columns.push((rest.solver, rest.cells));
        }
    }
    let heads = columns.iter().map(|(solver, [around, along])| format!(" {solver}, {around} x {along} |"));
    let mut out = format!("| fabric |{}\n|---|{}\n", heads.collect::<String>(), "---|".repeat(columns.len()));
    for fabric in fabrics {
        out += &format!("| {fabric} |");
        for column in &columns {
            let of = rests.iter().filter(|r| r.fabric == fabric && (r.solver, r.cells) == *column);
            out += &cell(&of.collect::<Vec<_>>());
        }
        out += "\n";
    }
    out
}

/// Mean and range of the drape coefficient, folds, height of the hem and substeps.
fn cell(rests: &[&Rest]) -> String {
    let (Some(first), count) = (rests.first(), rests.len() as f64) else { return " |".into() };
    let mean = |of: &dyn Fn(&Rest) -> f64| rests.iter().map(|r| of(r)).sum::<f64>() / count;
    let low = rests.iter().map(|r| r.drape).fold(f64::INFINITY, f64::min);
    let high = rests.iter().map(|r| r.drape).fold(0.0, f64::max);
    format!(
        " {:.0} % ({:.0}-{:.0}), {:.1} folds, {:.0} mm, {} |",
        100.0 * mean(&|r| r.drape),
        100.0 * low,
        100.0 * high,
        mean(&|r| r.folds as f64),
        mean(&|r| r.hem_mm),
        first.substeps
    )
}
