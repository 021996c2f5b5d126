//! The images of all parts: each laid out and mapped by itself, then made to agree on what they share.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::network::Bordered;
use crate::base::grid::Grid;
use crate::base::surface::Surface;
use crate::base::vec3::{add, scale};
use crate::error::{Error, Result};
use crate::stage::border::{BorderTexel, Key};
use crate::stage::cut::disk::{Disk, NONE};
use crate::stage::image::judge::{Verdict, judge, locator_if_distorted};
use crate::stage::image::{ImageOptions, PieceImage};
use crate::stage::layout::{Proxy, Size};
use crate::stage::parameterize::distortion::Distortion;
use crate::stage::parameterize::{Source, map};
use crate::stage::sample::{Sampling, border_index, fit_where_closer};

/// Which point of the whole surface a border texel is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Point {
    /// A vertex of the whole.
    Vertex(u32),
    /// A step of a path that parts share.
    Shared(u32, u32),
}

/// A part with its image.
pub(super) struct Imaged {
    pub bordered: Bordered,
    pub image: PieceImage,
    /// The points that other parts may have too, and their texels.
    points: Vec<(Point, u32)>,
}

/// The loops of the whole surface.
pub(super) struct Loops<'a> {
    /// For each vertex the boundary loop it lies on, longest first, or [`NONE`].
    pub rim: &'a [u32],
    /// Their lengths \[m\].
    pub lengths: &'a [f64],
}

/// Lays out and maps one part. Its texels lie where they were sampled.
fn image(name: &str, bordered: Bordered, loops: &Loops<'_>, options: &ImageOptions) -> Result<Imaged> {
    let Bordered { opened, border, texels, .. } = &bordered;
    let rim: Vec<u32> = opened.part.vertex.iter().map(|&v| loops.rim[v as usize]).collect();
    let source = Source { name, surface: &opened.part.surface, rim: &rim };
    let found = Proxy::new(&opened.disk, border, options.search).search_map(Size::Budget(*texels as u32), None);
    let layout = found
        .ok_or_else(|| source.fail("layout", "the border of a part does not fit its image", "give it more texels"))?
        .layout;
    let map = map(&source, &opened.disk, border, &layout, None, options)?;
    let mut points = Vec::new();
    for (p, t) in map.border.iter().enumerate() {
        points.extend(point(&bordered, &layout.count, t).map(|x| (x, border_index(p as u32, map.w, map.h) as u32)));
    }
    // Without a budget: that is of all parts together.
    let image = PieceImage::sampled(&source, map, bordered.opened.cut.clone())?;
    Ok(Imaged { bordered, image, points })
}

/// The point of the whole that a border texel is, if another part can have it.
fn point(bordered: &Bordered, count: &[u32], texel: &BorderTexel) -> Option<Point> {
    match texel.key {
        Key::Node(v) if v != NONE => Some(Point::Vertex(bordered.opened.part.vertex[v as usize])),
        Key::Inner(group, step) => {
            let &(path, against) = bordered.shared.get(&(group as usize))?;
            Some(Point::Shared(path, if against { count[group as usize] - step } else { step }))
        }
        _ => None,
    }
}

/// A texel of a part: (part, texel).
pub type PartTexel = (u32, u32);

/// Parts with their images, and the rings of texels of several parts, or of several places in one, that are one point.
type Joined = (Vec<Imaged>, Vec<Vec<PartTexel>>);

/// Why parts did not become images.
pub(super) struct Failure {
    /// The parts that have none; empty if it is not a matter of single parts.
    pub parts: Vec<usize>,
    /// The first of their errors.
    pub error: Error,
}

/// Makes the images of all parts.
pub(super) fn images(
    name: &str,
    parts: Vec<Bordered>,
    loops: &Loops<'_>,
    options: &ImageOptions,
) -> std::result::Result<Joined, Box<Failure>> {
    let made: Vec<Result<Imaged>> = parts.into_par_iter().map(|b| image(name, b, loops, options)).collect();
    let failed: Vec<usize> = (0..made.len()).filter(|&k| made[k].is_err()).collect();
    let mut made = made
        .into_iter()
        .collect::<Result<Vec<Imaged>>>()
        .map_err(|error| Box::new(Failure { parts: failed, error }))?;
    let mut members: BTreeMap<Point, Vec<PartTexel>> = BTreeMap::new();
    for (p, m) in made.iter().enumerate() {
        m.points.iter().for_each(|&(point, at)| members.entry(point).or_default().push((p as u32, at)));
    }
    let mut across: Vec<Vec<PartTexel>> = Vec::new();
    for mut ring in members.into_values() {
        ring.sort_unstable();
        let (p, first) = ring[0];
        // The two sides computed one point each, equal to rounding.
        let position = made[p as usize].image.grid.positions[first as usize];
        for &(q, at) in &ring {
            made[q as usize].image.grid.positions[at as usize] = position;
        }
        if ring.len() > 1 && !linked(&made[p as usize].image.grid, &ring) {
            across.push(ring);
        }
    }
    fit_parts(&mut made, &across, options);
    if let Some(first) = made.first_mut() {
        first.image.loop_lengths = loops.lengths.to_vec();
    }
    Ok((made, across))
}

/// How close the image of a part comes to it.
fn judged(surface: &Surface, disk: &Disk, uv: &[[f64; 2]], grid: &Grid, distortion: &Distortion) -> Verdict {
    let locator = locator_if_distorted(disk, uv, distortion, grid.width - 1, grid.height - 1);
    judge(surface, disk, uv, grid, locator.as_ref())
}

/// Fits every part by itself where that comes closer than sampling, what it shares held as its rims are, and then gives the
/// members of each ring one place: their mean.
fn fit_parts(made: &mut [Imaged], across: &[Vec<PartTexel>], options: &ImageOptions) {
    if let Sampling::Fit(fit_options) = &options.sampling {
        let mut held: Vec<Vec<bool>> =
            made.iter().map(|m| m.image.loop_of.iter().map(|&l| l != NONE).collect()).collect();
        across.iter().flatten().for_each(|&(p, at)| held[p as usize][at as usize] = true);
        made.par_iter_mut().zip(&held).for_each(|(m, rim)| {
            let PieceImage { disk, uv, grid, distortion, .. } = &mut m.image;
            let surface = &m.bordered.opened.part.surface;
            let judged = |grid: &Grid| judged(surface, disk, uv, grid, distortion);
            let mut before = judged(grid);
            m.image.fit = Some(fit_where_closer((disk, uv), grid, rim, fit_options, &mut before, &judged));
        });
        for ring in across {
            let at = |made: &[Imaged], (p, k): PartTexel| made[p as usize].image.grid.positions[k as usize];
            let mean = scale(ring.iter().fold([0.0; 3], |s, &m| add(s, at(made, m))), 1.0 / ring.len() as f64);
            ring.iter().for_each(|&(p, k)| made[p as usize].image.grid.positions[k as usize] = mean);
        }
    }
    made.par_iter_mut().for_each(|m| {
        let PieceImage { disk, uv, grid, distortion, .. } = &m.image;
        m.image.verdict = judged(&m.bordered.opened.part.surface, disk, uv, grid, distortion);
    });
}

/// Whether a sorted ring is one of a single grid's own.
fn linked(grid: &Grid, ring: &[PartTexel]) -> bool {
    let (part, start) = ring[0];
    let mut own = vec![(part, start)];
    let mut at = grid.links[start as usize];
    while at != NONE && at != start && own.len() <= ring.len() {
        own.push((part, at));
        at = grid.links[at as usize];
    }
    own.sort_unstable();
    own == ring
}
