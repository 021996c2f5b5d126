//! The map of a mesh as it is: the better of two starts, crushed triangles spread, Newton steps.

use super::distortion::energy;
use super::local::spread;
use super::newton::{NewtonOptions, NewtonRecord};
use super::start::{self, Start, StartRecord};
use super::{ParameterizeRecord, Shape, System, scale_to, solve};

/// Energy of a start above which the other start is tried too, and crushed triangles are spread before the first
/// Newton step.
const CRUSHED: f64 = 1e4;
/// Largest number of rounds of spreading.
const MAX_ROUNDS: usize = 200;

/// As [`super::parameterize`], of the mesh as it is. The start has mean-value weights; where its energy is over a bound,
/// uniform weights are tried as well and the lower energy is kept. `None` if neither start is free of flips in f64 with
/// an energy up to `bound`.
pub(super) fn whole(
    shape: Shape<'_>,
    uv: &mut Vec<[f64; 2]>,
    passes: usize,
    options: &NewtonOptions,
    bound: f64,
) -> Option<ParameterizeRecord> {
    let Shape { triangles, fixed, .. } = shape;
    let mut system = System::new(triangles, fixed);
    let begin = |system: &mut System, uv: &mut Vec<[f64; 2]>, uniform| {
        let found = start::weighted(system, shape, uv, Start::Convex { passes }, uniform)?;
        let mut rest = system.rest.take()?;
        scale_to(&mut rest, triangles, uv);
        let e = energy(&rest.shapes, triangles, uv);
        system.rest = Some(rest);
        Some((e, found))
    };
    let mut found = begin(&mut system, uv, false);
    if !found.is_some_and(|f| f.0 <= CRUSHED) {
        let mut other = uv.clone();
        if let Some(uniform) = begin(&mut system, &mut other, true)
            && found.is_none_or(|f| uniform.0 < f.0)
        {
            (found, *uv) = (Some(uniform), other);
        }
    }
    let (before, StartRecord { passes: start_passes, uniform: uniform_start }) = found?;
    if !(before.is_finite() && before <= bound) {
        return None;
    }
    if let Some(rest) = &system.rest {
        spread(triangles, &rest.shapes, fixed, uv, (CRUSHED, MAX_ROUNDS));
    }
    let record = solve(&mut system, shape, uv, Start::Map, options)?;
    let newton = NewtonRecord { start: before, ..record.newton };
    Some(ParameterizeRecord { start_passes, uniform_start, newton, ..record })
}
