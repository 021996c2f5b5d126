//! The images of all parts: each laid out and mapped by itself, then made to agree on what they share.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::network::Bordered;
use crate::base::grid::Grid;
use crate::base::locate::Locator;
use crate::base::surface::Surface;
use crate::base::vec3::{add, scale};
use crate::error::{Error, Result};
use crate::stage::border::{BorderTexel, Key};
use crate::stage::cut::disk::{Disk, NONE};
use crate::stage::image::judge::{Verdict, judge};
use crate::stage::image::{FAR, FitRecord, ImageOptions, PieceImage, Sampling};
use crate::stage::layout::{Proxy, Size};
use crate::stage::parameterize::distortion::{self, Distortion};
use crate::stage::parameterize::parameterize;
use crate::stage::sample::fit;
use crate::stage::sample::resample::{border_index, resample};

/// A disk of many more triangles than half the cells, and than this, is mapped coarse to fine.
const LEAST_TRIANGLES: usize = 3000;

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

fn fail(name: &str, stage: &'static str, problem: &str, hint: &str) -> Error {
    Error::Piece { piece: name.to_owned(), stage, problem: problem.into(), hint: hint.into() }
}

/// Lays out and maps one part. Its texels lie where they were sampled.
fn image(name: &str, bordered: Bordered, loops: &Loops<'_>, options: &ImageOptions) -> Result<Imaged> {
    let Bordered { opened, border, texels, .. } = &bordered;
    let found = Proxy::new(&opened.disk, border, options.search).search_map(Size::Budget(*texels as u32), None);
    let layout = found
        .ok_or_else(|| fail(name, "layout", "the border of a part does not fit its image", "give it more texels"))?
        .layout;
    let (w, h) = (layout.w, layout.h);
    let on_rim = |v: u32| loops.rim[opened.part.vertex[v as usize] as usize] != NONE;
    let placed = border
        .place(&opened.disk, &opened.part.surface, &on_rim, w, h, layout.shift, &layout.count)
        .ok_or_else(|| fail(name, "border", "the boundary cannot be shared out", "use a larger image"))?;
    let (disk, mut uv, texels) = (placed.disk, placed.uv, placed.texels);
    let fixed = disk.boundary_mask();
    let enough = LEAST_TRIANGLES.max((w * h) as usize / 2);
    let record =
        parameterize(disk.shape(&fixed), &mut uv, options.passes, &options.newton, enough).ok_or_else(|| {
            fail(name, "parameterize", "no map free of flips was found for a part", "remesh the slivers of this piece")
        })?;
    let samples = resample(&disk, &uv, &texels, w, h)
        .ok_or_else(|| fail(name, "resample", "a texel fell outside the map", "please report it with the input"))?;
    let mut positions: Vec<[f64; 3]> = samples.iter().map(|s| s.position(&disk)).collect();
    let mut loop_of = vec![NONE; positions.len()];
    let mut rings: BTreeMap<Key, Vec<u32>> = BTreeMap::new();
    let mut points = Vec::new();
    for (p, t) in texels.iter().enumerate() {
        let at = border_index(p as u32, w, h);
        positions[at] = t.position;
        loop_of[at] = t.rim.map_or(NONE, |v| loops.rim[opened.part.vertex[v as usize] as usize]);
        rings.entry(t.key).or_default().push(at as u32);
        points.extend(point(&bordered, &layout.count, t).map(|x| (x, at as u32)));
    }
    let mut links = vec![NONE; positions.len()];
    for ring in rings.values_mut().filter(|r| r.len() > 1) {
        ring.sort_unstable();
        for (k, &at) in ring.iter().enumerate() {
            links[at as usize] = ring[(k + 1) % ring.len()];
        }
    }
    let distortion = distortion::measure(&disk.positions, &disk.triangles, &uv);
    let grid = Grid { links, ..Grid::new(w as usize + 1, h as usize + 1, positions) };
    let cut = bordered.opened.cut.clone();
    let image = PieceImage {
        disk,
        uv,
        width: w + 1,
        height: h + 1,
        samples,
        grid,
        closed: false,
        loop_of,
        loop_lengths: Vec::new(),
        moved: 0,
        distortion,
        parameterize: record,
        cut,
        fit: None,
        verdict: Verdict::WORST,
        tried: Vec::new(),
        // The budget is that of all parts together.
        budget: None,
    };
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
pub(crate) type PartTexel = (u32, u32);

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
    let far = distortion.symmetric_dirichlet > FAR || distortion.linf > FAR;
    let locator = far.then(|| Locator::new(disk, uv, grid.width - 1, grid.height - 1));
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
            let rings: Vec<Vec<u32>> = grid.rings().collect();
            let image = fit::Image { columns: grid.width, rows: grid.height, rings: &rings, rim };
            let sampled = grid.positions.clone();
            let surface = &m.bordered.opened.part.surface;
            let before = judged(surface, disk, uv, grid, distortion);
            if !fit::fit(disk, uv, &mut grid.positions, &image, fit_options) {
                m.image.fit = Some(FitRecord::Failed);
                return;
            }
            let back = fit::restrain(&mut grid.positions, &sampled, &image);
            // What differs by less than f32 can hold is equal.
            let kept = judged(surface, disk, uv, grid, distortion).badness() <= before.badness().max(1e-7);
            if !kept {
                grid.positions = sampled;
            }
            m.image.fit = Some(if kept { FitRecord::Kept(back) } else { FitRecord::Dropped });
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
