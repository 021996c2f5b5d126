//! A surface that no single image serves, split along its necks into parts that have an image each.
//!
//! A rectangle of n texels has a border of some 4 sqrt(n) steps, and every hole and limb needs a few of them; k parts of
//! n / k texels have sqrt(k) times as many. The surface is cut in two along a short path ([`bisect`]) until the border of
//! each part fits the image of its share of the texels. Parts share the points of the paths between them: their steps are
//! decided before the images are laid out ([`network`]), so that the texels on both sides are the same points, bit for bit,
//! and rings of duplicates lead across parts. Welding them gives the surface: same Euler number, same boundary loops.

mod bisect;
mod image;
mod network;
mod part;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

use crate::base::graph::EdgeGraph;
use crate::base::surface::Surface;
use crate::base::topology::Topology;
use crate::base::vec3::distance;
use crate::error::{Error, Result};
use crate::options::Seams;
use crate::stage::cut::Cutter;
use crate::stage::cut::disk::{self, NONE};
use crate::stage::cut::grow::{grow, hidden_costs};
use crate::stage::cut::{CutRecord, SEAM_DISCOUNT};
use crate::stage::image::judge::{Verdict, bounds, outside};
use crate::stage::image::ladder::{WORTH, badness, passes};
use crate::stage::image::{ImageOptions, PieceImage};
use crate::stage::parameterize::bend;
use crate::stage::sample::seal::{Expected, Sheet, seal};

use bisect::{Dual, bisect};
pub(crate) use image::PartTexel;
use image::{Failure, Imaged, Loops, images};
use network::{Bordered, Opened, Whole, join};
use part::extract;

/// Most parts that a surface is split into.
pub(crate) const MAX_PARTS: usize = 64;

/// Fewest texels of a part.
const LEAST_TEXELS: f64 = 36.0;

/// The fewest border steps of a part's disk may be this share of those of its image; where they are more the part is split.
const CROWDED: f64 = 0.75;

/// A cut grown into limbs is taken if its fewest border steps are below this share of the image's.
const ROOM_TO_GROW: f64 = 0.3;

/// How often parts without an image, or with a poor one, are split further.
const MAX_ROUNDS: usize = 5;

/// Shares of the budget tried in turn, where the images do not weld as they should.
const SHARES: [f64; 5] = [0.97, 0.93, 0.88, 0.8, 0.7];

/// Most attempts with one set of parts.
const MAX_ATTEMPTS: usize = 8;

/// How far below its budget an attempt aims that follows one above it.
const BELOW: f64 = 0.995;

/// Border texels of all parts over the budget above which no images are tried: their counts are rounded, but not by as much.
const HOPELESS: f64 = 1.5;

/// Texels over the budget, and as a share of those of the attempt before, above which smaller shares do not help: the borders
/// do not get shorter.
const STUCK: (f64, f64) = (2.0, 0.9);

/// Triangles times attempts after which there is no further attempt, and the attempts that any surface has.
const WORK: usize = 2_000_000;
const LEAST_ATTEMPTS: usize = 3;

/// A part of a surface with its image.
pub(crate) struct PartImage {
    /// The part as a manifold of its own: a vertex where it touches itself is there once for each fan.
    pub surface: Surface,
    /// Its links lead to duplicates in the same part only; `loop_of` is of the loops of the whole, whose lengths the first
    /// part has.
    pub image: PieceImage,
    /// Vertices - edges + triangles, and boundary loops, of its triangles in the whole.
    pub euler: i64,
    pub loops: usize,
}

/// A surface as images of its parts.
pub(crate) struct Parts {
    /// The parts, 2 or more.
    pub parts: Vec<PartImage>,
    /// Rings of duplicates of which not all are linked in one grid: every member as (part, texel), sorted. They hold all
    /// duplicates of their points.
    pub rings: Vec<Vec<PartTexel>>,
}

impl Parts {
    /// The surface that the images weld to: stored positions and triangles.
    #[cfg(test)]
    pub(crate) fn welded(&self) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let grids: Vec<_> = self.parts.iter().map(|p| &p.image.grid).collect();
        crate::base::grid::welded(&grids, &self.rings)
    }

    /// How close the images come to the whole surface, and the largest stretch of their maps.
    pub(crate) fn verdict(&self, whole: &Surface) -> (Verdict, f64) {
        let diagonal = |s: &Surface| {
            let [lo, hi] = bounds(s);
            distance(lo, hi)
        };
        let (all, area) = (diagonal(whole).max(1e-300), whole.area().max(1e-300));
        let mut out = Verdict { rms: 0.0, largest: 0.0, outside: 0.0, folded: 0.0, normal_degrees: 0.0 };
        let mut stretch: f64 = 0.0;
        for PartImage { surface, image, .. } in &self.parts {
            let (v, share, part) = (&image.verdict, surface.area() / area, diagonal(surface) / all);
            out.rms += share * (v.rms * part).powi(2);
            out.largest = out.largest.max(v.largest * part);
            out.folded += share * v.folded;
            out.normal_degrees += share * v.normal_degrees;
            out.outside = out.outside.max(outside(bounds(whole), &image.grid.positions));
            stretch = stretch.max(image.distortion.linf);
        }
        out.rms = out.rms.sqrt();
        (out, stretch)
    }

    /// Texels of all images.
    pub(crate) fn texels(&self) -> u64 {
        self.parts.iter().map(|p| u64::from(p.image.width) * u64::from(p.image.height)).sum()
    }
}

/// A surface on its way to parts.
struct Splitter<'a> {
    name: &'a str,
    surface: &'a Surface,
    uv_seam: Option<&'a [bool]>,
    options: &'a ImageOptions,
    graph: EdgeGraph,
    /// The length a unit of length counts for at each vertex, alike in all parts.
    wanted: Vec<f64>,
    rim: Vec<u32>,
    on_rim: Vec<bool>,
    loop_lengths: Vec<f64>,
    expected: Expected,
    dual: Dual,
    weight: f64,
}

/// Splits a connected surface into 2 to [`MAX_PARTS`] parts, as few as serve, whose images have at most `budget` texels
/// together, and makes these. `uv_seam` tells the half-edges on UV seams, if the surface has any. The same
/// surface and options give the same bits whatever the number of threads.
///
/// Parts that have no image, or a poor one, are split further for some rounds. Errors: that of a part without an image;
/// [`Error::TooLarge`] where the borders alone of [`MAX_PARTS`] parts have far more texels than the budget; [`Error::Piece`] where the
/// budget does not hold the parts, or their images do not weld to the surface. O(n log n) for each doubling of the parts,
/// besides the images.
pub(crate) fn image_parts(
    name: &str,
    surface: &Surface,
    uv_seam: Option<&[bool]>,
    options: &ImageOptions,
    budget: u32,
) -> Result<Parts> {
    image_at_least(name, surface, uv_seam, options, budget, 2)
}

/// As [`image_parts`], with a lower bound of the number of parts.
fn image_at_least(
    name: &str,
    surface: &Surface,
    uv_seam: Option<&[bool]>,
    options: &ImageOptions,
    budget: u32,
    least: usize,
) -> Result<Parts> {
    let splitter = Splitter::new(name, surface, uv_seam, options, budget)?;
    let mut sets = vec![(0..surface.triangles.len() as u32).collect::<Vec<u32>>()];
    while sets.len() < least.min(MAX_PARTS) {
        let heaviest = (0..sets.len()).max_by(|&a, &b| {
            let w = |k: usize| splitter.weight_of(&sets[k]);
            w(a).total_cmp(&w(b)).then(b.cmp(&a))
        });
        if !heaviest.is_some_and(|k| splitter.bisect_all(&mut sets, &[k])) {
            break;
        }
    }
    if sets.len() < 2 {
        return Err(splitter.fail("split", "it has too few triangles to be split", "give it more texels"));
    }
    let (mut error, mut best) = (None, None::<(f64, Parts)>);
    let mut attempts = LEAST_ATTEMPTS.max(WORK / surface.triangles.len().max(1));
    for _ in 0..MAX_ROUNDS {
        let opened = splitter.relieve(&mut sets, f64::from(budget))?;
        if sets.len() >= MAX_PARTS {
            let need = splitter.border_texels(&opened);
            if need as f64 > HOPELESS * f64::from(budget) {
                error = Some(splitter.too_large(need, budget));
                break;
            }
        }
        let poor = match splitter.try_shares(&opened, f64::from(budget), &mut attempts) {
            Ok(parts) => {
                let poor = |p: &PartImage| !passes(&p.image.verdict, p.image.distortion.linf);
                let which: Vec<usize> = (0..parts.parts.len()).filter(|&k| poor(&parts.parts[k])).collect();
                let (verdict, stretch) = parts.verdict(surface);
                let badness = badness(&verdict, stretch);
                if best.as_ref().is_none_or(|b| badness < WORTH * b.0) {
                    best = Some((badness, parts));
                }
                which
            }
            Err(failure) => {
                error = Some(failure.error);
                failure.parts
            }
        };
        if poor.is_empty() || attempts == 0 || !splitter.bisect_all(&mut sets, &poor) {
            break;
        }
    }
    match (best, error) {
        (Some((_, parts)), _) => Ok(parts),
        (None, Some(e)) => Err(e),
        _ => Err(splitter.fail("split", "no round was made", "please report it with the input")),
    }
}

impl<'a> Splitter<'a> {
    fn new(
        name: &'a str,
        surface: &'a Surface,
        uv_seam: Option<&'a [bool]>,
        options: &'a ImageOptions,
        budget: u32,
    ) -> Result<Self> {
        let cutter = Cutter::new(surface).ok_or_else(|| Error::Piece {
            piece: name.to_owned(),
            stage: "split",
            problem: "the surface is not a manifold".into(),
            hint: "please report it with the input".into(),
        })?;
        let spacing = (surface.area() / f64::from(budget).max(1.0)).sqrt();
        let wanted = bend::wanted(surface, &cutter.graph, spacing, options.detail);
        let mut rim = vec![NONE; surface.positions.len()];
        for (k, l) in cutter.loops().iter().enumerate() {
            l.iter().for_each(|&v| rim[v as usize] = k as u32);
        }
        let weight = |(t, c): (usize, &[u32; 3])| {
            let mean = c.iter().map(|&v| wanted[v as usize]).sum::<f64>() / 3.0;
            mean * mean * surface.triangle_area(t)
        };
        let weights: Vec<f64> = surface.triangles.iter().enumerate().map(weight).collect();
        let weight = weights.iter().sum::<f64>().max(1e-300);
        let dual = Dual::new(surface, &cutter.graph, weights);
        let expected = Expected { euler: cutter.euler(), loops: cutter.loops().len() };
        Ok(Self {
            name,
            surface,
            uv_seam,
            options,
            wanted,
            on_rim: rim.iter().map(|&l| l != NONE).collect(),
            rim,
            loop_lengths: cutter.loop_lengths(),
            expected,
            dual,
            weight,
            graph: cutter.graph,
        })
    }

    fn fail(&self, stage: &'static str, problem: &str, hint: &str) -> Error {
        Error::Piece { piece: self.name.to_owned(), stage, problem: problem.into(), hint: hint.into() }
    }

    fn too_large(&self, need: u64, budget: u32) -> Error {
        let Expected { euler, loops } = self.expected;
        let shape = format!("Euler number {euler}, {loops} boundary loops, {MAX_PARTS} parts");
        Error::TooLarge {
            what: format!("the cut of piece {} ({shape})", self.name),
            need: format!("at least {need} texels for its border alone"),
            limit: format!("its share of {budget} texels"),
            hint: "give it many more texels, or delete what is inside of it: a garment has few handles and holes"
                .into(),
        }
    }

    /// Texels on the borders of the images of these parts where they have the fewest, whatever the shape of the images.
    fn border_texels(&self, opened: &[Opened]) -> u64 {
        self.join(opened, 0.0).iter().map(|b| u64::from(b.border.least_steps())).sum()
    }

    fn weight_of(&self, triangles: &[u32]) -> f64 {
        triangles.iter().map(|&t| self.dual.weight[t as usize]).sum()
    }

    fn texels(&self, triangles: &[u32], budget: f64) -> f64 {
        (budget * self.weight_of(triangles) / self.weight).max(LEAST_TEXELS)
    }

    /// Cuts some sets in two, in place and after it. `false` if none could be.
    fn bisect_all(&self, sets: &mut Vec<Vec<u32>>, which: &[usize]) -> bool {
        let room = MAX_PARTS.saturating_sub(sets.len());
        let which = &which[..which.len().min(room)];
        let cut: Vec<_> = which.par_iter().map(|&k| bisect(&self.dual, &sets[k])).collect();
        let mut any = false;
        for (&k, halves) in which.iter().zip(cut).rev() {
            if let Some([a, b]) = halves {
                sets.splice(k..=k, [a, b]);
                any = true;
            }
        }
        any
    }

    /// Splits sets whose border is too crowded, the most crowded first, and opens the parts.
    fn relieve(&self, sets: &mut Vec<Vec<u32>>, budget: f64) -> Result<Vec<Opened>> {
        let mut opened: Vec<Opened> = sets.par_iter().map(|s| self.open(s, None)).collect::<Result<_>>()?;
        loop {
            let joined = self.join(&opened, budget);
            let mut crowded: Vec<(f64, usize)> = joined
                .iter()
                .enumerate()
                .map(|(k, b)| (b.crowding(), k))
                .filter(|&(c, k)| c > CROWDED && self.texels(&sets[k], budget) > 2.0 * LEAST_TEXELS)
                .collect();
            crowded.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            crowded.truncate(MAX_PARTS.saturating_sub(sets.len()));
            let mut which: Vec<usize> = crowded.into_iter().map(|x| x.1).collect();
            which.sort_unstable();
            let before = sets.clone();
            if which.is_empty() || !self.bisect_all(sets, &which) {
                break;
            }
            // Those that were not split stay as they are.
            let old: std::collections::BTreeMap<&Vec<u32>, Opened> = before.iter().zip(opened).collect();
            opened = sets
                .par_iter()
                .map(|s| old.get(s).map_or_else(|| self.open(s, None), |o| Ok(o.clone())))
                .collect::<Result<_>>()?;
        }
        // Limbs that a part still has are reached where there is room for it.
        let joined = self.join(&opened, budget);
        let room: Vec<u32> = joined.iter().map(Bordered::perimeter).collect();
        let grown: Vec<Opened> =
            sets.par_iter().zip(&room).map(|(s, &room)| self.open(s, Some(room))).collect::<Result<_>>()?;
        Ok(grown)
    }

    /// Cuts a part to a disk; grown into limbs if that leaves `room` border steps for the rest.
    fn open(&self, triangles: &[u32], room: Option<u32>) -> Result<Opened> {
        let part = extract(self.surface, &self.graph, triangles);
        let mut cutter = Cutter::new(&part.surface)
            .ok_or_else(|| self.fail("split", "a part is not a manifold", "please report it with the input"))?;
        cutter.wanted = part.vertex.iter().map(|&v| self.wanted[v as usize]).collect();
        let grown = room.and(self.options.grow.as_ref()).and_then(|g| grow(&cutter, g));
        let mut cost = hidden_costs(&cutter, None);
        if let Some(seam) = self.uv_seam.filter(|_| self.options.seams == Seams::Uv) {
            for (c, h) in cost.iter_mut().zip(&cutter.graph.halves) {
                let (t, k) = (part.triangles[h[0] as usize / 3], h[0] % 3);
                *c *= if seam[(3 * t + k) as usize] { SEAM_DISCOUNT } else { 1.0 };
            }
        }
        let mut on_rim = vec![false; part.surface.positions.len()];
        cutter.loops().iter().flatten().for_each(|&v| on_rim[v as usize] = true);
        let plain = cutter.cut(&cost, &[]);
        let wide = grown.filter(|g| !g.terminals.is_empty()).filter(|g| {
            let steps = disk::open(&cutter, &g.cut).map_or(f64::INFINITY, |mut d| {
                f64::from(crate::stage::border::Border::new(&mut d, |v| on_rim[v as usize]).least_steps())
            });
            steps <= ROOM_TO_GROW * f64::from(room.unwrap_or(0))
        });
        let cut = wide.as_ref().map_or(&plain, |g| &g.cut);
        let disk = disk::open(&cutter, cut).map_err(|e| {
            self.fail(
                "cut",
                &format!("the cut of a part left Euler number {} and {} loops", e.euler, e.loops),
                "please report it with the input",
            )
        })?;
        let record = CutRecord {
            length: cut.length(&cutter.graph),
            edges: cut.edges.iter().filter(|c| **c).count() as u32,
            grown: wide.as_ref().map_or(0, |g| g.terminals.len()),
            uv_seams: self.uv_seam.is_some() && self.options.seams == Seams::Uv,
            bought: wide.as_ref().and_then(|g| g.bought),
        };
        Ok(Opened { disk, cut: record, part })
    }

    fn join(&self, opened: &[Opened], budget: f64) -> Vec<Bordered> {
        let texels: Vec<f64> = opened.iter().map(|o| self.texels(&o.part.triangles, budget)).collect();
        join(&Whole { graph: &self.graph, rim: &self.on_rim }, opened.to_vec(), &texels)
    }

    /// Makes the images, with fewer texels where they need more than the budget or do not weld. The error names the parts
    /// to be split further.
    fn try_shares(
        &self,
        opened: &[Opened],
        budget: f64,
        attempts: &mut usize,
    ) -> std::result::Result<Parts, Box<Failure>> {
        let loops = Loops { rim: &self.rim, lengths: &self.loop_lengths };
        let whole = |error| Box::new(Failure { parts: Vec::new(), error });
        let (mut last, mut scale, mut share, mut shares) = (None, 1.0, 1.0, SHARES.into_iter());
        let mut reached = f64::INFINITY;
        for _ in 0..MAX_ATTEMPTS.min(*attempts) {
            *attempts -= 1;
            let joined = self.join(opened, budget * share * scale);
            let (made, rings) = images(self.name, joined, &loops, self.options)?;
            let (closed, parts) = self.sealed(made, rings);
            let texels = parts.texels() as f64;
            let before = std::mem::replace(&mut reached, texels);
            if texels > budget {
                let problem = format!("its parts need {texels:.0} texels, its share is {budget:.0}");
                last = Some(whole(self.fail("split", &problem, "give it more texels")));
                if texels > STUCK.0 * budget && texels > STUCK.1 * before {
                    break;
                }
                scale *= BELOW * (budget / texels).max(0.5);
            } else if closed {
                return Ok(parts);
            } else {
                let problem = "the images of its parts do not weld to the surface";
                last = Some(whole(self.fail("split", problem, "give it more texels")));
                match shares.next() {
                    Some(next) => share = next,
                    None => break,
                }
            }
        }
        Err(last.unwrap_or_else(|| whole(self.fail("split", "no size was tried", "give it more texels"))))
    }

    /// Makes sure that the images weld to the surface.
    fn sealed(&self, made: Vec<Imaged>, rings: Vec<Vec<PartTexel>>) -> (bool, Parts) {
        let part = |m: Imaged| {
            let part = m.bordered.opened.part;
            let whole: Vec<[u32; 3]> = part.triangles.iter().map(|&t| self.surface.triangles[t as usize]).collect();
            let t = Topology::of(&whole);
            PartImage { surface: part.surface, image: m.image, euler: t.euler, loops: t.boundary_loops }
        };
        let mut parts: Vec<PartImage> = made.into_iter().map(part).collect();
        let mut sheets: Vec<Sheet<'_>> = parts
            .iter_mut()
            .map(|p| &mut p.image)
            .map(|i| Sheet { grid: &mut i.grid, samples: &mut i.samples, disk: &i.disk, uv: &i.uv })
            .collect();
        let (moved, closed) = seal(&mut sheets, &rings, self.expected);
        for (p, moved) in parts.iter_mut().zip(moved) {
            (p.image.moved, p.image.closed) = (moved, closed);
        }
        (closed, Parts { parts, rings })
    }
}
