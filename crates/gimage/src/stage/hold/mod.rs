//! Where garments rest on a body: particles that are pinned there, and limits that grow with the distance from them.
//!
//! Each garment is held by the first of these that it has: a ring around the body along its highest border (a collar, a waistband), with
//! parts that lie on shoulders beside it; parts that lie on shoulders; its upper edge where that is near the body. A garment with none of
//! them is held by its top. Hems that hide where the body ends have limits as well. All lengths follow the height of the body. Where one garment lies over another one near pins or the body, both keep this order
//! by limits and backstops.

mod ends;
mod over;
mod report;
mod rest;
pub(crate) mod sheet;
mod spread;
mod tuck;
mod wearer;

use rayon::prelude::*;

use crate::record::Finding;
use crate::stage::assemble::{Family, Piece};
use sheet::Sheet;

pub use rest::Rule;
pub use tuck::Tuck;
pub use wearer::Wearer;

/// The pins and limits of a piece, by texels, equal at all duplicates of a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// Whether a texel is pinned.
    pub pinned: Vec<bool>,
    /// Largest distance \[m\] from its place on the skin, infinite for none.
    pub limits: Vec<f32>,
    /// Largest distance \[m\] behind it, infinite for none.
    pub behind: Vec<f32>,
    /// Where the mesh of the source is drawn, 0 on the skin and 1 on the cloth; empty if it is on the cloth everywhere.
    pub blend: Vec<f32>,
}

impl Held {
    /// A piece whose texels are free.
    pub fn free(texels: usize) -> Self {
        let none = vec![f32::INFINITY; texels];
        Held { pinned: vec![false; texels], limits: none.clone(), behind: none, blend: Vec::new() }
    }
}

/// How a garment is held.
#[derive(Clone, Debug, PartialEq)]
pub struct Hold {
    /// The component.
    pub name: String,
    /// The rules that hold it.
    pub rules: Vec<Rule>,
    /// Share of its area that is pinned, above 0 and below 1.
    pub pinned: f64,
    /// Share of its area that is not pinned and has a limit.
    pub limited: f64,
    /// Pins inside of the body, and what was pinned beside them.
    pub tuck: Tuck,
    /// Borders that hide where the body ends, and have limits.
    pub hems: usize,
    /// The garments that lie over it near its pins or the body, by name.
    pub over: Vec<String>,
    /// Share of its area that is covered so, and stays near the skin.
    pub covered: f64,
}

/// Pins and limits of all garments.
#[derive(Clone, Debug, PartialEq)]
pub struct Holds {
    /// By pieces.
    pub pieces: Vec<Held>,
    /// By garments: a component, or the parts of one.
    pub garments: Vec<Hold>,
}

impl Holds {
    /// How each garment is held, for people.
    pub fn findings(&self) -> Vec<Finding> {
        report::findings(&self.garments)
    }
}

/// Finds where garments rest on a body. `pieces` and `families` are those of [`crate::stage::assemble::assemble`]. Some particles of each garment are
/// pinned, never all of them.
///
/// Deterministic. O(n log n) in the texels, with one search for the nearest triangle of the body per texel.
pub fn hold(wearer: &Wearer, pieces: &[Piece<'_>], families: &[Family<'_>]) -> Holds {
    let groups = garments(pieces.len(), families);
    let one = |(range, family): &(std::ops::Range<usize>, Option<&Family<'_>>)| {
        let pieces = &pieces[range.clone()];
        let sheet = Sheet::new(pieces, family.map_or(&[], |f| &f.rings));
        let name = family.map_or(&pieces[0].component.name, |f| &f.whole.name);
        garment(wearer, sheet, name)
    };
    let mut garments: Vec<Garment> = groups.par_iter().map(one).collect();
    over::run(wearer, &mut garments);
    let pieces = garments.iter().flat_map(Garment::held).collect();
    Holds { pieces, garments: garments.into_iter().map(|garment| garment.hold).collect() }
}

/// The pieces of each garment, and its family if it has several.
pub(crate) fn garments<'a, 'b>(
    pieces: usize,
    families: &'a [Family<'b>],
) -> Vec<(std::ops::Range<usize>, Option<&'a Family<'b>>)> {
    let mut groups: Vec<_> = families.iter().map(|f| (f.first..f.first + f.count, Some(f))).collect();
    let alone = |k: &usize| !families.iter().any(|f| (f.first..f.first + f.count).contains(k));
    groups.extend((0..pieces).filter(alone).map(|k| (k..k + 1, None)));
    groups.sort_by_key(|g| g.0.start);
    groups
}

/// A garment, and how it is held, by its points.
struct Garment {
    sheet: Sheet,
    pinned: Vec<bool>,
    /// \[m\], as [`Held::limits`] and [`Held::behind`].
    limits: Vec<f64>,
    behind: Vec<f64>,
    /// How far from pins limits end \[m\].
    reach: f64,
    hold: Hold,
}

impl Garment {
    /// By texels, of each piece.
    fn held(&self) -> impl Iterator<Item = Held> + '_ {
        self.sheet.points.iter().map(|points| Held {
            pinned: points.iter().map(|&p| self.pinned[p as usize]).collect(),
            limits: points.iter().map(|&p| self.limits[p as usize] as f32).collect(),
            behind: points.iter().map(|&p| self.behind[p as usize] as f32).collect(),
            blend: Vec::new(),
        })
    }
}

fn garment(wearer: &Wearer, sheet: Sheet, name: &str) -> Garment {
    let mut rest = rest::rest(wearer, &sheet);
    let mut pinned = spread::pinned(&sheet, &rest);
    if spread::share(&sheet, &pinned) > rest::MOST {
        // A collar or a belt that is narrower than the band.
        rest.narrow();
        pinned = spread::pinned(&sheet, &rest);
    }
    if rest.points.is_empty() || spread::share(&sheet, &pinned) > rest::MOST {
        rest = rest::top(&sheet);
        pinned = spread::pinned(&sheet, &rest);
    }
    let mut deeper = pinned.clone();
    // A garment that is inside for the most part is not held by what is inside.
    let mut tuck = tuck::tuck(wearer, &sheet, &mut deeper);
    if spread::share(&sheet, &deeper) > rest::MOST {
        tuck.added = 0;
    } else {
        pinned = deeper;
    }
    let mut limits = spread::limits(&sheet, &pinned, rest.least, rest.reach);
    let hems = ends::run(wearer, &sheet, (&pinned, &mut limits), rest::height(wearer, sheet.span()));
    let limited: Vec<bool> = limits.iter().zip(&pinned).map(|(l, p)| l.is_finite() && !p).collect();
    let hold = Hold {
        name: name.to_owned(),
        rules: rest.rules,
        pinned: spread::share(&sheet, &pinned),
        limited: spread::share(&sheet, &limited),
        tuck,
        hems,
        over: Vec::new(),
        covered: 0.0,
    };
    let behind = vec![f64::INFINITY; pinned.len()];
    Garment { sheet, pinned, limits, behind, reach: rest.reach, hold }
}

#[cfg(test)]
mod tests;
