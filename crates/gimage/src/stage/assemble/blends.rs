//! The map `blend`: where the mesh of the source is drawn, from 0 on the skin to 1 on the cloth.
//!
//! It is that of the attribute of the source, else that of borders with other parts; `--blend` sets it.

use std::fmt;
use std::str::FromStr;

use gimage_bundle::{Bundle, Image, MapKind};

use super::texels::Texels;
use crate::base::mesh::Semantic;
use crate::error::{Error, Result};
use crate::stage::assemble::pins::Pin;

/// The attribute of the source that holds the blend; it is clamped to 0 and 1.
pub const ATTRIBUTE: &str = "_BLEND";

/// A blend for the particles that meet an expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Blend {
    /// Which particles.
    pub particles: Pin,
    /// 0 on the skin, 1 on the cloth.
    pub share: f64,
}

impl fmt::Display for Blend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.particles, self.share)
    }
}

impl FromStr for Blend {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let bad = |problem: &str| Error::Option {
            option: "blend".into(),
            problem: format!("`{text}`: {problem}"),
            hint:
                "use EXPR=SHARE, where EXPR is as for --pin and SHARE is 0 (skin) to 1 (cloth), for example loop:top=0"
                    .into(),
        };
        let (expression, share) = text.rsplit_once('=').ok_or_else(|| bad("`=` is missing"))?;
        let particles = expression.parse().map_err(|error| match error {
            Error::Option { problem, .. } => bad(&problem),
            other => other,
        })?;
        let share = share.trim().parse::<f64>().ok().filter(|x| (0.0..=1.0).contains(x));
        Ok(Blend { particles, share: share.ok_or_else(|| bad("the share is not a number from 0 to 1"))? })
    }
}

/// The blend of each texel, `found` where neither the attribute nor an expression has one; `None` if it is 1 everywhere. And which of
/// `blends` a texel meets; the last one counts.
pub(super) fn blends(texels: &Texels<'_>, blends: &[Blend], found: &[f32]) -> (Option<Vec<f32>>, Vec<bool>) {
    let mut out = if found.is_empty() { vec![1.0; texels.places.len()] } else { found.to_vec() };
    let attribute = Semantic::Custom(ATTRIBUTE.into());
    for (at, own) in out.iter_mut().enumerate() {
        if let Some(painted) = texels.value(&attribute, 0, at).filter(|x| x.is_finite()) {
            // Adding 0 makes a negative zero positive.
            *own = painted.clamp(0.0, 1.0) as f32 + 0.0;
        }
    }
    let met = texels.select(blends.iter().map(|blend| &blend.particles), |n, at| {
        out[at] = blends[n].share as f32 + 0.0;
    });
    (out.iter().any(|x| *x < 1.0).then_some(out), met)
}

/// Adds the maps of the pieces that blend to a bundle that has their positions; duplicates of a point get the smallest one. Errors as
/// [`Bundle::rings`].
pub(super) fn write(bundle: &mut Bundle, made: Vec<Option<Vec<f32>>>) -> Result<()> {
    if made.iter().all(Option::is_none) {
        return Ok(());
    }
    let sizes: Vec<(u32, u32)> = bundle.manifest.pieces.iter().map(|p| (p.width, p.height)).collect();
    let filled =
        |((w, h), own): (&(u32, u32), Option<Vec<f32>>)| own.unwrap_or_else(|| vec![1.0; *w as usize * *h as usize]);
    let mut all: Vec<f32> = sizes.iter().zip(made).flat_map(filled).collect();
    for ring in bundle.rings()?.iter() {
        let least = ring.iter().map(|k| all[*k as usize]).fold(1.0, f32::min);
        ring.iter().for_each(|k| all[*k as usize] = least);
    }
    let mut first = 0;
    for (index, (width, height)) in sizes.into_iter().enumerate() {
        let data = all[first..first + width as usize * height as usize].to_vec();
        first += data.len();
        if data.iter().any(|share| *share < 1.0) {
            bundle.insert(index, MapKind::Blend, Image { width, height, channels: 1, data })?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blends_read_back_as_written_and_bad_ones_say_why() {
        for text in ["above:1.25=0.5", "loop:top=0", "(above:1) and (attr:_A=B>0.5)=1"] {
            assert_eq!(text.parse::<Blend>().unwrap().to_string(), text);
        }
        for text in ["", "above:1", "above:1=", "above:1=-0.1", "above:1=1.1", "above:1=NaN", "left:3=1"] {
            let error = text.parse::<Blend>().unwrap_err().to_string();
            assert!(error.starts_with("option blend: ") && error.contains(text) && error.contains("EXPR="), "{error}");
        }
    }
}
