//! Long, short and uneven steps, and very many of them.

use gimage_runtime::{Options, Result};

use crate::case::{Asked, Case, Stretch, flag, hanging, scene};

/// Steps \[s\] above this cannot hold 17 x 17 particles to 5 % by springs alone: the error grows with their square.
const LONGEST: f64 = 1.0 / 600.0;

pub fn cases(steps: u32) -> Result<Vec<Case>> {
    let mut out = Vec::new();
    for rate in [240, 120, 60, 30, 10] {
        for substeps in [1, 4, 16, 64] {
            let step = 1.0 / f64::from(rate);
            let short = step / f64::from(substeps) <= LONGEST;
            let stretch = if short { Stretch::Judged } else { Stretch::WithTethers };
            let case = Case::new(format!("step 1/{rate} s, {substeps} substeps"), scene(flag()?));
            out.push(Case { step, substeps, ..case }.stretch(stretch));
        }
    }
    let jumps = |s: &mut gimage_runtime::Stepper, frame: u32| {
        let substeps = [1, 64, 7, 32][frame as usize % 4];
        s.set_options(Options { substeps: Some(substeps), ..s.options().clone() })
    };
    let back = |s: &mut gimage_runtime::Stepper| s.set_options(Options { substeps: Some(32), ..s.options().clone() });
    out.push(Case::new("substeps 1, 64, 7, 32 by turns", scene(flag()?)).storm(2.0, jumps).after(back));
    let stutter = |s: &mut gimage_runtime::Stepper, frame: u32| {
        let more = [0.0, 1.0, 0.0001, 0.03, f64::NAN][frame as usize % 5];
        s.advance(more).map(|_| ())
    };
    let frames = Case::new("frames of 0 to 1 s", scene(flag()?)).storm(2.0, stutter);
    out.push(Case { cpu_only: true, ..frames });
    let long = Case::new(format!("{steps} steps at rest"), scene(hanging(1.0)?));
    let asked = Asked { drift: true, ..long.asked };
    let calm = f64::from(steps) * long.step / f64::from(long.substeps);
    out.push(Case { calm: calm.max(17.0), asked, ..long });
    Ok(out)
}
