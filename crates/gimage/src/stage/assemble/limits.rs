//! Limits: how far particles may move from their positions at rest, from attributes of the source and from `--limit`.
//!
//! A limit is the motion constraint of NvCloth and Chaos. Several limits of one particle all hold: the smallest counts.

use std::fmt;
use std::str::FromStr;

use gimage_bundle::NO_LIMIT;

use super::texels::Texels;
use crate::base::mesh::Semantic;
use crate::error::Error;
use crate::stage::assemble::pins::Pin;

/// The attributes of the source that hold limits, in units of the file; negative means no limit.
pub const ATTRIBUTES: [&str; 2] = ["_LIMIT", "_MAX_DISTANCE"];

/// A limit for the particles that meet an expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// Which particles.
    pub particles: Pin,
    /// Largest distance \[m\] from the position at rest, at least 0; 0 holds the particle there.
    pub distance: f64,
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.particles, self.distance)
    }
}

impl FromStr for Limit {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let bad = |problem: &str| Error::Option {
            option: "limit".into(),
            problem: format!("`{text}`: {problem}"),
            hint: "use EXPR=METRES, where EXPR is as for --pin, for example above:1.2=0.05".into(),
        };
        let (expression, metres) = text.rsplit_once('=').ok_or_else(|| bad("`=` is missing"))?;
        let particles = expression.parse().map_err(|error| match error {
            Error::Option { problem, .. } => bad(&problem),
            other => other,
        })?;
        let distance = metres.trim().parse::<f64>().ok().filter(|d| (0.0..=f64::from(f32::MAX)).contains(d));
        let distance = distance.ok_or_else(|| bad("the distance is not a number of metres from 0"))?;
        Ok(Limit { particles, distance })
    }
}

/// The limit \[m\] of each texel, infinite for none, equal at all duplicates of a point; `None` if no texel has one. And
/// which of `limits` a texel meets. `unit` is the length \[m\] of a unit of the file.
pub(super) fn limits(texels: &Texels<'_>, limits: &[Limit], unit: f64) -> (Option<Vec<f32>>, Vec<bool>) {
    let mut out = vec![f32::INFINITY; texels.places.len()];
    for name in ATTRIBUTES {
        let painted = painted(texels, name, unit);
        out.iter_mut().zip(painted.iter().flatten()).for_each(|(all, one)| *all = all.min(*one));
    }
    let met = texels.select(limits.iter().map(|limit| &limit.particles), |limit, at| {
        out[at] = out[at].min(limits[limit].distance as f32);
    });
    for ring in texels.image.grid.rings() {
        let least = ring.iter().map(|&k| out[k as usize]).fold(f32::INFINITY, f32::min);
        ring.iter().for_each(|&k| out[k as usize] = least);
    }
    (out.iter().any(|x| x.is_finite()).then_some(out), met)
}

/// The limits that the source has as an attribute, if it has that: the mean over the corners around a texel that have a limit, where those
/// are at least half of it. A mean with the -1 of the others would be a length that nobody asked for.
pub(super) fn painted(texels: &Texels<'_>, name: &str, unit: f64) -> Option<Vec<f32>> {
    let channel = texels.mesh.channel(&Semantic::Custom(name.into()))?;
    let at = |at: usize| {
        let (mut sum, mut limited, mut total) = (0.0, 0.0, 0.0);
        for (b, value) in texels.corners(channel, at) {
            total += b;
            if value[0] >= 0.0 {
                limited += b;
                sum += b * f64::from(value[0]);
            }
        }
        // Adding 0 makes a negative zero positive.
        if limited > 0.0 && 2.0 * limited >= total {
            (unit * sum / limited).max(0.0) as f32 + 0.0
        } else {
            f32::INFINITY
        }
    };
    Some((0..texels.places.len()).map(at).collect())
}

/// Limits as a bundle stores them.
pub(super) enum Stored {
    /// The same at every texel.
    Constant(f32),
    /// One per texel, [`NO_LIMIT`] for none.
    Image(Vec<f32>),
}

impl Stored {
    /// `None` if no texel has a limit.
    pub fn new(mut limits: Vec<f32>) -> Option<Self> {
        limits.iter_mut().filter(|x| !x.is_finite()).for_each(|x| *x = NO_LIMIT);
        let first = *limits.first()?;
        if limits.iter().any(|x| *x != first) {
            return Some(Self::Image(limits));
        }
        (first != NO_LIMIT).then_some(Self::Constant(first))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_read_back_as_written() {
        for text in ["above:1.25=0.05", "box:0,0,0,1,2,3=0", "attr:_A=B>0.5=0.1", "color:g>0.25=1"] {
            assert_eq!(text.parse::<Limit>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn bad_limits_say_why() {
        for text in ["", "above:1", "above:1=", "above:1=-1", "above:1=inf", "above:1=1e39", "above:x=1", "left:3=1"] {
            let error = text.parse::<Limit>().unwrap_err().to_string();
            assert!(error.starts_with("option limit: ") && error.contains(text) && error.contains("EXPR="), "{error}");
        }
    }

    #[test]
    fn equal_limits_are_a_constant_and_none_are_nothing() {
        assert!(Stored::new(vec![f32::INFINITY; 4]).is_none());
        assert!(matches!(Stored::new(vec![0.5; 4]), Some(Stored::Constant(0.5))));
        let Some(Stored::Image(image)) = Stored::new(vec![0.0, f32::INFINITY]) else { panic!("not an image") };
        assert_eq!(image, [0.0, -1.0]);
    }
}
