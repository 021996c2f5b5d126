//! Backstops: how far particles may go behind their positions at rest, from an attribute of the source and from `--backstop`.
//!
//! Several backstops of one particle: the one of the smallest distance counts.

use std::fmt;
use std::str::FromStr;

use gimage_bundle::{Bundle, Image, MapKind, NO_LIMIT};

use super::limits::painted;
use super::texels::Texels;
use crate::error::{Error, Result};
use crate::stage::assemble::pins::Pin;

/// The attribute of the source that holds distances, in units of the file; negative means no backstop. Radii are [`RADIUS`].
pub const ATTRIBUTE: &str = "_BACKSTOP";

/// Radius \[m\] of the sphere of a backstop by default: about that of a limb or a waist.
pub const RADIUS: f64 = 0.1;

/// A backstop for the particles that meet an expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Backstop {
    /// Which particles.
    pub particles: Pin,
    /// Largest distance \[m\] behind the position at rest, at least 0.
    pub distance: f64,
    /// Radius \[m\] of the sphere that begins there, above 0.
    pub radius: f64,
}

impl fmt::Display for Backstop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={},{}", self.particles, self.distance, self.radius)
    }
}

impl FromStr for Backstop {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let bad = |problem: &str| Error::Option {
            option: "backstop".into(),
            problem: format!("`{text}`: {problem}"),
            hint: "use EXPR=METRES or EXPR=METRES,RADIUS, where EXPR is as for --pin, for example below:1=0.01,0.2"
                .into(),
        };
        let (expression, numbers) = text.rsplit_once('=').ok_or_else(|| bad("`=` is missing"))?;
        let particles = expression.parse().map_err(|error| match error {
            Error::Option { problem, .. } => bad(&problem),
            other => other,
        })?;
        let (distance, radius) = numbers.split_once(',').unwrap_or((numbers, ""));
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| (0.0..=f64::from(f32::MAX)).contains(x));
        let distance = number(distance).ok_or_else(|| bad("the distance is not a number of metres from 0"))?;
        let radius = if radius.is_empty() { Some(RADIUS) } else { number(radius).filter(|r| *r as f32 > 0.0) };
        let radius = radius.ok_or_else(|| bad("the radius is not a number of metres above 0"))?;
        Ok(Backstop { particles, distance, radius })
    }
}

/// Distance and radius \[m\] of each texel, a negative distance for none; `None` if no texel has one. And which of `backstops` a texel meets.
/// `unit` is the length \[m\] of a unit of the file.
pub(super) fn backstops(texels: &Texels<'_>, backstops: &[Backstop], unit: f64) -> (Option<Vec<[f32; 2]>>, Vec<bool>) {
    let mut out = vec![[f32::INFINITY, RADIUS as f32]; texels.places.len()];
    for (own, distance) in out.iter_mut().zip(painted(texels, ATTRIBUTE, unit).into_iter().flatten()) {
        own[0] = distance;
    }
    let met = texels.select(backstops.iter().map(|backstop| &backstop.particles), |n, at| {
        let Backstop { distance, radius, .. } = backstops[n];
        out[at] = nearer(out[at], [distance as f32, radius as f32]);
    });
    (out.iter().any(|x| x[0].is_finite()).then_some(out), met)
}

/// Backstops with those of other distances \[m\] behind each texel, infinite for none; `None` if no texel has one.
pub(super) fn nearest(backstops: Option<Vec<[f32; 2]>>, behind: &[f32]) -> Option<Vec<[f32; 2]>> {
    if behind.iter().all(|x| x.is_infinite()) {
        return backstops;
    }
    let mut out = backstops.unwrap_or_else(|| vec![[f32::INFINITY, RADIUS as f32]; behind.len()]);
    out.iter_mut().zip(behind).for_each(|(all, one)| *all = nearer(*all, [*one, RADIUS as f32]));
    Some(out)
}

/// The one of the smaller distance, or of the smaller radius.
fn nearer(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    if b < a { b } else { a }
}

/// Adds the maps of all pieces to a bundle that has their positions, if any piece has a backstop; duplicates of a point get the one of the
/// smallest distance. Errors as [`Bundle::rings`].
pub(super) fn write(bundle: &mut Bundle, made: Vec<Option<Vec<[f32; 2]>>>) -> Result<()> {
    if made.iter().all(Option::is_none) {
        return Ok(());
    }
    let none = [f32::INFINITY, 0.0];
    let size = |(piece, own): (&gimage_bundle::manifest::PieceEntry, Option<Vec<[f32; 2]>>)| {
        own.unwrap_or_else(|| vec![none; piece.width as usize * piece.height as usize])
    };
    let mut all: Vec<[f32; 2]> = bundle.manifest.pieces.iter().zip(made).flat_map(size).collect();
    for ring in bundle.rings()?.iter() {
        let least = ring.iter().map(|k| all[*k as usize]).fold(none, nearer);
        ring.iter().for_each(|k| all[*k as usize] = least);
    }
    for index in 0..bundle.manifest.pieces.len() {
        let piece = &bundle.manifest.pieces[index];
        let (width, height, first) = (piece.width, piece.height, piece.first_particle as usize);
        let texel = |[distance, radius]: &[f32; 2]| match distance.is_finite() {
            true => [*distance, *radius, 0.0],
            false => [NO_LIMIT, 0.0, 0.0],
        };
        let data = all[first..first + width as usize * height as usize].iter().flat_map(texel).collect();
        bundle.insert(index, MapKind::Backstop, Image { width, height, channels: 3, data })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backstops_read_back_as_written() {
        for text in ["above:1.25=0.05,0.1", "box:0,0,0,1,2,3=0,2", "attr:_A=B>0.5=0.1,0.5"] {
            assert_eq!(text.parse::<Backstop>().unwrap().to_string(), text);
        }
        assert_eq!("above:1=0.5".parse::<Backstop>().unwrap().to_string(), "above:1=0.5,0.1");
    }

    #[test]
    fn bad_backstops_say_why() {
        for text in
            ["", "above:1", "above:1=", "above:1=-1", "above:1=1,0", "above:1=1,x", "above:1=1,1e-60", "left:3=1"]
        {
            let error = text.parse::<Backstop>().unwrap_err().to_string();
            assert!(
                error.starts_with("option backstop: ") && error.contains(text) && error.contains("EXPR="),
                "{error}"
            );
        }
    }
}
