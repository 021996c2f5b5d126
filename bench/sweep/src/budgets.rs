//! Texel budgets: whether a mesh does much worse at one of them than at its neighbours.

use std::fmt::Write;

use crate::record::{Record, Status};
use crate::table::short;

/// Fewest and most texels of the sweep.
const TEXELS: [f64; 2] = [1_000.0, 40_000.0];

/// How far a budget may lie below its neighbours \[dB\].
pub const DIP_DB: f64 = 3.0;

/// `n` budgets, evenly spread in their logarithm.
pub fn budgets(n: u32) -> Vec<u32> {
    let step = |k: u32| f64::from(k) / f64::from(n.max(2) - 1);
    (0..n).map(|k| (TEXELS[0] * (TEXELS[1] / TEXELS[0]).powf(step(k))).round() as u32).collect()
}

/// The budgets of one mesh and sample that fall below a neighbour, with by how much \[dB\]. More texels are better, so
/// that the smaller neighbour counts as it is and the larger one less what the step between them brings (at most 6 dB
/// for twice the texels, as the error goes down with their number at most).
pub fn dips(psnr: &[(u32, f64)]) -> Vec<(u32, f64)> {
    let mut out = Vec::new();
    for k in 0..psnr.len() {
        let (texels, here) = psnr[k];
        let before = (k > 0).then(|| psnr[k - 1].1);
        let after = psnr.get(k + 1).map(|&(more, x)| x - 20.0 * (f64::from(more) / f64::from(texels)).log10());
        let dip = [before, after].into_iter().flatten().map(|x| x - here).fold(f64::NEG_INFINITY, f64::max);
        if dip > DIP_DB {
            out.push((texels, dip));
        }
    }
    out
}

/// The table of a sweep of budgets, and whether no mesh dips.
pub fn summary(records: &[Record]) -> (String, bool) {
    let mut out = String::from("texel budgets: lowest, highest and largest step down of the worst piece\n");
    let mut sound = true;
    let mut names: Vec<(&str, &str)> = records.iter().map(|r| (r.mesh.as_str(), r.sample.as_str())).collect();
    names.dedup();
    for (mesh, sample) in names {
        let mine: Vec<&Record> = records.iter().filter(|r| r.mesh == mesh && r.sample == sample).collect();
        let worst = |r: &Record| r.pieces.iter().filter_map(|p| p.worst_psnr()).reduce(f64::min);
        let psnr: Vec<(u32, f64)> = mine.iter().filter_map(|r| Some((r.texels, worst(r)?))).collect();
        let missing = mine.iter().filter(|r| r.status != Status::Built).count();
        let range = psnr.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x.1), h.max(x.1)));
        let dips = dips(&psnr);
        sound &= dips.is_empty() && missing == 0;
        let word = if dips.is_empty() && missing == 0 { "even " } else { "FAILS" };
        let _ =
            write!(out, "  {word} {mesh} ({sample}): {} .. {} dB, {missing} not built", short(range.0), short(range.1));
        for (texels, dip) in dips {
            let _ = write!(out, "; {texels} texels: {dip:.1} dB below its neighbour");
        }
        out.push('\n');
    }
    (out + "\n", sound)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_run_from_end_to_end() {
        let b = budgets(36);
        assert_eq!((b.len(), b[0], b[35]), (36, 1_000, 40_000));
        assert!(b.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn a_dip_is_found_and_a_rise_is_none() {
        let rise: Vec<(u32, f64)> = budgets(36).into_iter().map(|b| (b, 20.0 * f64::from(b).log10())).collect();
        assert!(dips(&rise).is_empty());
        let mut dip = rise.clone();
        dip[20].1 = -15.0;
        let found = dips(&dip);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].0, dip[20].0);
        let mut ends = rise;
        (ends[0].1, ends[35].1) = (0.0, 0.0);
        assert_eq!(dips(&ends).len(), 2);
    }
}
