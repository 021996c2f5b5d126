//! Where the mesh of the source blends from the skin to the cloth: at borders that cloth shares with parts that are not cloth.
//!
//! There the drawn mesh follows the joints, as the other part does, so that no crack opens; over a width it goes over to the cloth.

mod border;

use std::fmt;
use std::str::FromStr;

use crate::error::Error;
use crate::options::{Range, stage_options};
use crate::record::{Finding, Severity};
use crate::stage::assemble::{Family, Piece};
use crate::stage::hold::{Held, garments, sheet::Sheet};

pub use border::{Edge, border};

/// Width \[m\] of the blend that [`crate::pipeline::dress`] makes by default.
pub const WIDTH: f64 = 0.05;

/// How wide the blend at borders is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BlendWidth {
    /// Borders do not blend.
    None,
    /// Over this distance \[m\] along the cloth.
    Within(f64),
}

impl fmt::Display for BlendWidth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BlendWidth::None => f.write_str("none"),
            BlendWidth::Within(width) => write!(f, "{width}"),
        }
    }
}

impl FromStr for BlendWidth {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let width = || text.parse().ok().filter(|w: &f64| *w > 0.0 && w.is_finite());
        match text {
            "none" => Ok(BlendWidth::None),
            _ => width().map(BlendWidth::Within).ok_or_else(|| Error::Option {
                option: "blend-width".into(),
                problem: format!("`{text}` is neither none nor a distance above 0"),
                hint: "give metres, for example 0.05".into(),
            }),
        }
    }
}

stage_options! {
    /// Options of the blend.
    #[derive(Copy)]
    pub struct BlendOptions of "blend" {
        /// Where cloth shares edges with parts that are not cloth, draw the render mesh on the skin, and blend to the cloth over this
        /// distance; none leaves all of it on the cloth. Default: none, and 0.05 m for gimage dress.
        pub width: Option<BlendWidth> = None => "blend-width" ["m"] Range::Above(0.0);
    }
}

/// Blends the garments with an edge on the border over a width \[m\], and pins their texels there if `pins`. `held` has an entry per
/// piece, or none at all.
///
/// A texel on the border and its neighbours have 0, so that the vertices of the border are on the skin exactly; from there the blend grows
/// to 1 by a smooth step of the distance along the images. O(n log n) in the texels of garments with a border, and border texels times edges.
pub fn blend(
    held: &mut Vec<Held>,
    edges: &[Edge],
    pieces: &[Piece<'_>],
    families: &[Family<'_>],
    width: f64,
    pins: bool,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    if edges.is_empty() {
        return findings;
    }
    if held.is_empty() {
        held.extend(pieces.iter().map(|p| Held::free(p.image.grid.positions.len())));
    }
    for (range, family) in garments(pieces.len(), families) {
        let own = &pieces[range.clone()];
        let sheet = Sheet::new(own, family.map_or(&[], |f| &f.rings));
        let on_border = border::on_border(&sheet, edges);
        if on_border.is_empty() {
            continue;
        }
        let near: Vec<u32> = on_border.iter().flat_map(|&p| sheet.neighbours(p)).chain(on_border.clone()).collect();
        let far = sheet.distances(near.into_iter(), width);
        for (held, points) in held[range].iter_mut().zip(&sheet.points) {
            held.blend = points.iter().map(|&p| smooth(far[p as usize] / width) as f32).collect();
            let is_sewn = points.iter().map(|p| pins && on_border.binary_search(p).is_ok());
            held.pinned.iter_mut().zip(is_sewn).for_each(|(pinned, sewn)| *pinned |= sewn);
        }
        let name = family.map_or(&own[0].component.name, |f| &f.whole.name);
        let message = format!(
            "{name} shares a border of {} points with parts that are not cloth: the render mesh is on the skin there{}, and blends to the cloth \
             over {width} m; --blend-width sets the distance.",
            on_border.len(),
            if pins { ", the border is pinned" } else { "" },
        );
        findings.push(Finding {
            severity: Severity::Note,
            stage: "blend",
            kind: "hint-blend",
            count: on_border.len() as u64,
            examples: Vec::new(),
            message,
        });
    }
    findings
}

/// The smooth step from 0 at 0 to 1 at 1 and beyond.
fn smooth(x: f64) -> f64 {
    let x = x.min(1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_read_back_as_written_and_bad_ones_say_why() {
        for text in ["none", "0.05", "2"] {
            assert_eq!(text.parse::<BlendWidth>().unwrap().to_string(), text);
        }
        for text in ["", "0", "-1", "inf", "auto"] {
            let error = text.parse::<BlendWidth>().unwrap_err().to_string();
            assert!(error.starts_with("option blend-width: ") && error.contains("0.05"), "{error}");
        }
    }

    #[test]
    fn the_blend_is_level_at_both_ends() {
        assert_eq!([0.0, 0.5, 1.0, f64::INFINITY].map(smooth), [0.0, 0.5, 1.0, 1.0]);
        assert!(smooth(0.01) < 0.001 && smooth(0.99) > 0.999);
    }
}
