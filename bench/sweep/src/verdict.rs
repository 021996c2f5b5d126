//! The requirements on a build, and which of them it violates.

use crate::child::GATE;
use crate::record::{Piece, Record, Status};

/// PSNR below which a piece needs an error \[dB\].
pub const WRECK_DB: f64 = 30.0;
/// PSNR below which a piece needs a warning \[dB\].
pub const POOR_DB: f64 = 45.0;
/// Hausdorff distance / diagonal above which a piece needs an error, and a warning.
pub const HAUSDORFF: [f64; 2] = [0.3, 0.05];
/// Distance of texels from the source's box / diagonal: needs an error, a warning, is counted.
pub const OUTSIDE: [f64; 3] = [0.3, 0.05, 0.02];

/// How good a piece is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grade {
    /// Nothing to say.
    Good,
    /// It needs a warning.
    Poor,
    /// It needs an error.
    Wreck,
}

/// The grade of a piece by its figures, the worse of the build's and the probe's.
pub fn grade(piece: &Piece) -> Grade {
    let above = |x: Option<f64>, limit: f64| x.is_some_and(|x| x > limit || x.is_nan());
    let below = |x: Option<f64>, limit: f64| x.is_some_and(|x| x < limit || x.is_nan());
    let (psnr, far, outside) = (piece.worst_psnr(), piece.worst_hausdorff(), Some(piece.probe.outside));
    if below(psnr, WRECK_DB) || above(far, HAUSDORFF[0]) || above(outside, OUTSIDE[0]) {
        Grade::Wreck
    } else if below(psnr, POOR_DB) || above(far, HAUSDORFF[1]) || above(outside, OUTSIDE[2]) {
        Grade::Poor
    } else {
        Grade::Good
    }
}

/// Whether a finding of the build warns of this piece, or the gate refused the build.
pub fn warned(record: &Record, piece: &Piece) -> bool {
    matches!(&record.status, Status::Refused { kind, .. } if kind == GATE)
        || record.findings.iter().any(|f| f.warns_of(&piece.name))
}

/// The requirements, in the words of the table.
pub const REQUIREMENTS: [&str; 7] = [
    "refused because no map was found, or by an internal error",
    "panicked",
    "ended by the system (memory, stack)",
    "over the time limit",
    "wreck without an error",
    "poor without a warning",
    "a part of 10 % of the area is an accessory",
];

/// For each requirement whether the build violates it.
pub fn violations(record: &Record, limit_seconds: f64) -> [bool; REQUIREMENTS.len()] {
    let built = record.status == Status::Built;
    let pieces = |wanted: Grade| record.pieces.iter().filter(move |p| built && grade(p) == wanted);
    // With an error there is no bundle: every wreck that was built lacks it, unless a finding of that severity stands.
    let error = |p: &&Piece| record.findings.iter().any(|f| f.severity == "error" && f.warns_of(&p.name));
    [
        matches!(&record.status, Status::Refused { kind, .. } if for_want_of_a_map(kind)),
        matches!(record.status, Status::Panicked(_)),
        record.status == Status::Died,
        record.status == Status::TimedOut || record.cpu > limit_seconds,
        pieces(Grade::Wreck).any(|p| !error(&p)),
        pieces(Grade::Poor).any(|p| !warned(record, p)),
        record.largest_accessory > 0.1,
    ]
}

/// Whether an error says that a stage of the image could not do its work.
fn for_want_of_a_map(kind: &str) -> bool {
    // Masses that 32-bit floats do not hold are a matter of units, which the message states.
    ["internal error", "sweep"].contains(&kind) || (kind.starts_with("piece: ") && kind != "piece: mass")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{Finding, Probe};

    fn piece(psnr: f64, outside: f64, hausdorff: f64) -> Piece {
        let probe = Probe { outside, rms_out: Some(1e-4), rms_back: Some(1e-4), hausdorff: Some(1e-3) };
        Piece { name: "shirt".into(), psnr: Some(psnr), hausdorff: Some(hausdorff), probe, ..Piece::default() }
    }

    #[test]
    fn the_worst_figure_decides() {
        for (psnr, outside, hausdorff, expected) in [
            (80.0, 0.0, 0.01, Grade::Good),
            (44.9, 0.0, 0.01, Grade::Poor),
            (80.0, 0.03, 0.01, Grade::Poor),
            (80.0, 0.0, 0.06, Grade::Poor),
            (29.9, 0.0, 0.01, Grade::Wreck),
            (80.0, 0.31, 0.01, Grade::Wreck),
            (80.0, 0.0, 0.31, Grade::Wreck),
            (f64::NAN, 0.0, 0.0, Grade::Good),
        ] {
            assert_eq!(grade(&piece(psnr, outside, hausdorff)), expected, "{psnr} {outside} {hausdorff}");
        }
        let mut far = piece(80.0, 0.0, 0.0);
        far.probe.rms_back = Some(1e3);
        assert_eq!(grade(&far), Grade::Wreck, "the probe counts as much as the build");
    }

    #[test]
    fn a_silent_wreck_violates_and_a_refused_one_does_not() {
        let mut record = Record { status: Status::Built, pieces: vec![piece(10.0, 0.0, 0.0)], ..Record::default() };
        assert_eq!(violations(&record, 60.0), [false, false, false, false, true, false, false]);
        record.pieces = vec![piece(40.0, 0.0, 0.0)];
        assert!(violations(&record, 60.0)[5]);
        let warning = Finding { severity: "warning".into(), stage: "image".into(), count: 2, ..Finding::default() };
        record.findings.push(warning);
        assert_eq!(violations(&record, 60.0), [false; 7]);
        let refused = |kind: &str| Record {
            status: Status::Refused { kind: kind.into(), message: String::new() },
            pieces: vec![piece(10.0, 0.0, 0.0)],
            ..Record::default()
        };
        assert_eq!(violations(&refused("piece: parameterize"), 60.0), [true, false, false, false, false, false, false]);
        assert_eq!(violations(&refused("piece: mass"), 60.0), [false; 7]);
        for kind in [GATE, "nothing to build"] {
            assert_eq!(violations(&refused(kind), 60.0), [false; 7]);
        }
        assert!(warned(&refused(GATE), &piece(10.0, 0.0, 0.0)));
    }
}
