//! One surface -> one geometry image: cut, border, parameterise, resample.

pub mod judge;
pub mod ladder;

use std::collections::BTreeMap;

use self::judge::{Verdict, judge};
use crate::base::grid::Grid;
use crate::base::locate::Locator;
use crate::base::surface::Surface;
use crate::error::{Error, Result};
use crate::options::{BuildOptions, Effort, ImageSize, Sample, Seams};
use crate::stage::border::{Border, Key};
use crate::stage::cut::disk::{self, Disk};
use crate::stage::cut::grow::{GrowOptions, Grown, grow, hidden_costs};
use crate::stage::cut::{Cut, Cutter};
use crate::stage::image::ladder::{Ladder, Rung, Tried};
use crate::stage::layout::{self, Found, Layout, Proxy, SearchOptions, Size};
use crate::stage::parameterize::bend;
use crate::stage::parameterize::distortion::{self, Distortion};
use crate::stage::parameterize::{NewtonOptions, ParameterizeRecord, Way, parameterize, parameterize_by};
use crate::stage::sample::fit::{self, FitOptions};
use crate::stage::sample::resample::{Sample as DiskSample, border_index, resample};
use crate::stage::sample::seal::{Expected, Sheet, seal};

/// What the cut was and cost.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutRecord {
    /// Length of the cut paths \[m\].
    pub length: f64,
    /// Edges cut.
    pub edges: u32,
    /// Points the cut was grown to.
    pub grown: usize,
    /// The cut follows UV seams.
    pub uv_seams: bool,
    /// Mean of ln(density / 4) of a coarse stand-in with the shortest cut, and with the cut grown.
    pub bought: Option<[f64; 2]>,
}

/// Where texels go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sampling {
    /// On the surface, exactly.
    Point,
    /// Where the surface between them comes closest.
    Fit(FitOptions),
}

/// The image of one piece before attributes are sampled.
pub(crate) struct PieceImage {
    pub disk: Disk,
    pub uv: Vec<[f64; 2]>,
    /// Texels across and down.
    pub width: u32,
    pub height: u32,
    /// Where each texel lies on the disk, row by row.
    pub samples: Vec<DiskSample>,
    /// Texel positions \[m\], bit-identical for duplicates, and the rings of duplicates.
    pub grid: Grid,
    /// The image welds to a surface of the same topology.
    pub closed: bool,
    /// For each texel the boundary loop of the surface it lies on (longest first), or [`disk::NONE`].
    pub loop_of: Vec<u32>,
    /// Lengths of the surface's boundary loops \[m\], longest first.
    pub loop_lengths: Vec<f64>,
    /// Texels sampled a little off their place so that it does.
    pub moved: usize,
    pub distortion: Distortion,
    pub parameterize: ParameterizeRecord,
    pub cut: CutRecord,
    /// What became of the fit, if one was asked for.
    pub fit: Option<FitRecord>,
    /// How close the image comes.
    pub verdict: Verdict,
    /// The rungs of the ladder.
    pub tried: Vec<Tried>,
    /// Its share of the texels, if it has one.
    pub budget: Option<u32>,
}

/// What became of the least-squares fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FitRecord {
    /// It came closer than point sampling; so many texels went back to where they were sampled.
    Kept(usize),
    /// It did not come closer: the texels are where they were sampled.
    Dropped,
    /// Its equations could not be solved: the texels are where they were sampled.
    Failed,
}

/// Options of [`image`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ImageOptions {
    pub size: Size,
    pub grow: Option<GrowOptions>,
    pub search: SearchOptions,
    pub newton: NewtonOptions,
    pub passes: usize,
    pub detail: f64,
    pub sampling: Sampling,
    pub seams: Seams,
}

impl ImageOptions {
    /// The settings of a build for a piece with a budget of texels, or of the exact size asked for.
    pub(crate) fn new(options: &BuildOptions, budget: Option<u32>) -> Self {
        let size = match (options.size, budget) {
            (ImageSize::Exact(w, h), _) => Size::Fixed(w, h),
            (ImageSize::Texels(n), None) => Size::Budget(n),
            (_, b) => Size::Budget(b.unwrap_or(LEAST_TEXELS)),
        };
        let (grow, search) = match options.effort {
            Effort::Fast => (None, SearchOptions::FAST),
            Effort::Default => (Some(GrowOptions::default()), SearchOptions::DEFAULT),
            Effort::Best => (Some(GrowOptions::BEST), SearchOptions::BEST),
        };
        Self {
            size,
            grow,
            search,
            newton: NewtonOptions::default(),
            passes: START_PASSES,
            detail: options.detail,
            sampling: match options.sample {
                Sample::Point => Sampling::Point,
                Sample::Fit => Sampling::Fit(FitOptions::default()),
            },
            seams: options.seams,
        }
    }
}

/// Texels of a piece whose share is unknown.
const LEAST_TEXELS: u32 = 64;

/// Largest number of reweighting passes of the start of a map.
const START_PASSES: usize = 8;

/// A mesh of many more triangles than half the cells, and than this, is mapped coarse to fine.
const LEAST_TRIANGLES: usize = 3000;

/// Triangles of which a map of `w` x `h` cells is as good as of all.
fn enough(w: u32, h: u32) -> usize {
    LEAST_TRIANGLES.max((w * h) as usize / 2)
}

/// Cost of an edge on a UV seam, as a share of its length.
pub(crate) const SEAM_DISCOUNT: f64 = 0.15;

/// Sizes tried in turn, as shares of the budget, where an image does not weld as it should or has no flip-free map.
const BUDGETS: [f64; 8] = [1.0, 0.97, 0.93, 0.88, 1.1, 1.3, 1.6, 2.0];

/// Sizes tried where an image welds but comes out poor, as shares of that at which it welds: smaller, so that the budget
/// holds.
const OTHER_BUDGETS: [f64; 2] = [0.96, 0.91];

/// How many texels a side an exact size may be short for a larger one to be named.
const MAX_SHORT: u32 = 24;

/// One way to cut the surface, ready to be laid out.
struct Candidate {
    disk: Disk,
    border: Border,
    cut: CutRecord,
}

/// A surface on its way to an image.
struct Maker<'a> {
    name: &'a str,
    surface: &'a Surface,
    cutter: Cutter<'a>,
    /// For each vertex the boundary loop it lies on, longest first, or [`disk::NONE`].
    rim: Vec<u32>,
    uv_seam: Option<&'a [bool]>,
    options: &'a ImageOptions,
}

/// The cuts of a surface, and how the first was grown.
struct Cuts {
    candidates: Vec<Candidate>,
    grown: Option<Grown>,
}

/// Makes the image of a connected surface. `uv_seam` tells the half-edges on UV seams, if the surface has any.
pub(crate) fn image(
    name: &str,
    surface: &Surface,
    uv_seam: Option<&[bool]>,
    options: &ImageOptions,
) -> Result<PieceImage> {
    let maker = Maker::new(name, surface, uv_seam, options)?;
    let mut cuts = maker.cuts(true)?;
    match options.size {
        Size::Budget(texels) => {
            maker.climb(&cuts, &BUDGETS.map(|share| Size::Budget((f64::from(texels) * share) as u32)))
        }
        Size::Fixed(width, height) => {
            let least = |c: &Cuts| c.candidates.iter().map(|c| c.border.least_steps()).min().unwrap_or(8);
            let holds = |w: u32, h: u32, least: u32| 2 * (w + h - 2) >= least;
            if !holds(width, height, least(&cuts)) {
                // A cut that was grown for quality asks for more texels than one that only has to open the surface.
                cuts = maker.cuts(false)?;
            }
            for more in 0..=MAX_SHORT {
                let (w, h) = (width + more, height + more);
                if !holds(w, h, least(&cuts)) {
                    continue;
                }
                let made = match more {
                    0 => maker.climb(&cuts, &[Size::Fixed(w, h)]),
                    _ => maker.make(&cuts.candidates, Size::Fixed(w, h), None),
                };
                match made {
                    Ok(image) if image.closed && more == 0 => return Ok(image),
                    Ok(image) if image.closed => {
                        let (min_width, min_height) = (w, h);
                        return Err(Error::GridTooSmall {
                            piece: name.to_owned(),
                            width,
                            height,
                            min_width,
                            min_height,
                        });
                    }
                    // A large image that does not weld is no matter of size.
                    Ok(image) if more == 0 && width.min(height) > 2 * MAX_SHORT => return Ok(image),
                    Err(e) if more == MAX_SHORT => return Err(e),
                    _ => {}
                }
            }
            let (w, h) = layout::smallest(least(&cuts));
            let (min_width, min_height) = (w.max(width + 1), h.max(height + 1));
            Err(Error::GridTooSmall { piece: name.to_owned(), width, height, min_width, min_height })
        }
    }
}

/// Energy or stretch of a map above which its image is judged in both directions: texels may then span what the surface
/// does not fill. Maps of clean garments stay below it.
pub(crate) const FAR: f64 = 15.0;

/// Triangles times rungs after which no further rung is tried: the ladder's share of the time stays bounded.
const MAX_WORK: usize = 4_000_000;

/// What mapping a mesh whole costs, in rungs.
const WHOLE_MESH_RUNGS: usize = 20;

/// Points a cut is grown to where its image came out poor.
const TERMINALS: usize = 6;
/// Least distance of these points, as a share of the diagonal: nearer ones lie in one limb.
const TERMINALS_APART: f64 = 0.05;

/// Badness below which a fit is as good as sampling: what differs by less than f32 can hold is equal, and a flat piece
/// is exact either way.
const EXACT: f64 = 1e-7;

impl<'a> Maker<'a> {
    fn new(
        name: &'a str,
        surface: &'a Surface,
        uv_seam: Option<&'a [bool]>,
        options: &'a ImageOptions,
    ) -> Result<Self> {
        let mut cutter = Cutter::new(surface).ok_or_else(|| Error::Piece {
            piece: name.to_owned(),
            stage: "cut",
            problem: "the surface is not a manifold".into(),
            hint: "please report it with the input".into(),
        })?;
        let texels = match options.size {
            Size::Fixed(w, h) => f64::from(w) * f64::from(h),
            Size::Budget(n) => f64::from(n),
        };
        cutter.wanted = bend::wanted(surface, &cutter.graph, (surface.area() / texels.max(1.0)).sqrt(), options.detail);
        let mut rim = vec![disk::NONE; surface.positions.len()];
        for (k, l) in cutter.loops().iter().enumerate() {
            l.iter().for_each(|&v| rim[v as usize] = k as u32);
        }
        Ok(Self { name, surface, cutter, rim, uv_seam, options })
    }

    fn fail(&self, stage: &'static str, problem: String, hint: &str) -> Error {
        Error::Piece { piece: self.name.to_owned(), stage, problem, hint: hint.to_owned() }
    }

    fn on_rim(&self, v: u32) -> bool {
        self.rim[v as usize] != disk::NONE
    }

    /// The cuts worth laying out: along UV seams or not, as the options say, grown into limbs if `growing`.
    fn cuts(&self, growing: bool) -> Result<Cuts> {
        let cutter = &self.cutter;
        let grown = self.options.grow.as_ref().filter(|_| growing).and_then(|g| grow(cutter, g));
        let terminals: &[u32] = grown.as_ref().map_or(&[], |g| &g.terminals);
        let along_uv: &[bool] = match (self.options.seams, self.uv_seam) {
            (_, None) | (Seams::Short, _) => &[false],
            (Seams::Uv, _) => &[true],
            (Seams::Auto, _) => &[false, true],
        };
        let (mut candidates, mut cuts) = (Vec::new(), Vec::new());
        for &along_uv in along_uv {
            let cut = match (&grown, along_uv) {
                // Without limbs or handles the surface itself knows the shorter way than its stand-in.
                (Some(g), false) if !terminals.is_empty() || cutter.handles() > 0 => g.cut.clone(),
                _ => cutter.cut(&self.costs(grown.as_ref(), along_uv), terminals),
            };
            if cuts.contains(&cut) {
                continue;
            }
            candidates.push(self.candidate(&cut, terminals.len(), along_uv, grown.as_ref())?);
            cuts.push(cut);
        }
        Ok(Cuts { candidates, grown })
    }

    /// What it costs to cut each edge.
    fn costs(&self, grown: Option<&Grown>, along_uv: bool) -> Vec<f64> {
        let mut cost = hidden_costs(&self.cutter, grown.and_then(|g| g.mirror.as_ref()));
        if let Some(seam) = self.uv_seam.filter(|_| along_uv) {
            for (c, h) in cost.iter_mut().zip(&self.cutter.graph.halves) {
                if seam[h[0] as usize] {
                    *c *= SEAM_DISCOUNT;
                }
            }
        }
        cost
    }

    /// The disk that a cut opens the surface to, and its border.
    fn candidate(&self, cut: &Cut, points: usize, uv_seams: bool, grown: Option<&Grown>) -> Result<Candidate> {
        let mut disk = disk::open(&self.cutter, cut).map_err(|e| {
            let problem = format!("the cut left Euler number {} and {} loops", e.euler, e.loops);
            self.fail("cut", problem, "please report it with the input")
        })?;
        let border = Border::new(&mut disk, |v| self.on_rim(v));
        let cut = CutRecord {
            length: cut.length(&self.cutter.graph),
            edges: cut.edges.iter().filter(|c| **c).count() as u32,
            grown: points,
            uv_seams,
            bought: grown.and_then(|g| g.bought),
        };
        Ok(Candidate { disk, border, cut })
    }

    /// Climbs the ladder: the first of `sizes` at which the image welds, then whatever else there is to try until an image
    /// passes. The error is that of the first rung, if none makes an image.
    fn climb(&self, cuts: &Cuts, sizes: &[Size]) -> Result<PieceImage> {
        let mut ladder = Ladder::default();
        let mut failure = None;
        let mut size = sizes.first().copied().unwrap_or(self.options.size);
        for (k, &tried) in sizes.iter().enumerate() {
            if ladder.best().is_some_and(|b| b.closed) {
                break;
            }
            let made = self.make(&cuts.candidates, tried, None);
            if made.as_ref().is_ok_and(|m| m.closed) {
                size = tried;
            }
            let rung = if k == 0 { Rung::First } else { Rung::OtherSize };
            ladder.take(rung, made.map_err(|e| failure.get_or_insert(e)).ok());
        }
        let rungs = [Rung::WholeMesh, Rung::NextCut, Rung::ShortestCut, Rung::OtherSize, Rung::MoreTerminals];
        for rung in rungs {
            if ladder.done() || ladder.len() * self.surface.triangles.len() > MAX_WORK {
                break;
            }
            self.rung(rung, cuts, size, &mut ladder);
        }
        ladder.finish().ok_or_else(|| {
            failure.unwrap_or_else(|| self.fail("layout", "no size was tried".into(), "give more texels"))
        })
    }

    /// Tries a rung, if there is anything to it.
    fn rung(&self, rung: Rung, cuts: &Cuts, size: Size, ladder: &mut Ladder) {
        match rung {
            Rung::WholeMesh => {
                let affordable = WHOLE_MESH_RUNGS * self.surface.triangles.len() <= MAX_WORK;
                if affordable && ladder.best().is_some_and(|b| b.parameterize.way == Way::CoarseToFine) {
                    ladder.take(rung, self.make(&cuts.candidates, size, Some(Way::Whole)).ok());
                }
            }
            Rung::Embedded if ladder.best().is_some_and(|b| b.parameterize.way != Way::Embedded) => {
                ladder.take(rung, self.make(&cuts.candidates, size, Some(Way::Embedded)).ok());
            }
            Rung::NextCut => {
                for candidate in &cuts.candidates {
                    // The one that the first rung chose is known already.
                    if !ladder.done() && ladder.best().is_none_or(|b| b.cut != candidate.cut) {
                        ladder.take(rung, self.alone(candidate, size).ok());
                    }
                }
            }
            Rung::ShortestCut => {
                let cut = self.cutter.cut(&self.costs(cuts.grown.as_ref(), false), &[]);
                if let Ok(candidate) = self.candidate(&cut, 0, false, None)
                    && cuts.candidates.iter().all(|c| c.cut.edges != candidate.cut.edges)
                {
                    ladder.take(rung, self.alone(&candidate, size).ok());
                }
            }
            Rung::OtherSize => {
                let Size::Budget(texels) = size else { return };
                for share in OTHER_BUDGETS {
                    if !ladder.done() {
                        let size = Size::Budget((f64::from(texels) * share) as u32);
                        ladder.take(rung, self.make(&cuts.candidates, size, None).ok());
                    }
                }
            }
            Rung::MoreTerminals => {
                let Some(terminals) = ladder.best().map(|b| self.more_terminals(b, cuts.grown.as_ref())) else {
                    return;
                };
                let cut = self.cutter.cut(&self.costs(cuts.grown.as_ref(), false), &terminals);
                if let Ok(candidate) = self.candidate(&cut, terminals.len(), false, None) {
                    ladder.take(rung, self.alone(&candidate, size).ok());
                }
            }
            _ => {}
        }
    }

    /// The points the cut was grown to, and those that an image stretches most.
    fn more_terminals(&self, image: &PieceImage, grown: Option<&Grown>) -> Vec<u32> {
        let disk = &image.disk;
        let mut on_cut = vec![false; self.surface.positions.len()];
        let origin = |v: u32| disk.origin[v as usize];
        disk.boundary.iter().map(|&v| origin(v)).filter(|&o| o != disk::NONE).for_each(|o| on_cut[o as usize] = true);
        let [lo, hi] = judge::bounds(self.surface);
        let apart = TERMINALS_APART * crate::base::vec3::distance(lo, hi);
        let allowed = |v: u32| origin(v) != disk::NONE && !on_cut[origin(v) as usize];
        let worst = layout::most_stretched(&disk.positions, &disk.triangles, &image.uv, TERMINALS, apart, allowed);
        let mut terminals = grown.map_or_else(Vec::new, |g| g.terminals.clone());
        for v in worst.into_iter().map(origin) {
            if !terminals.contains(&v) {
                terminals.push(v);
            }
        }
        terminals
    }

    /// The image of one cut.
    fn alone(&self, candidate: &Candidate, size: Size) -> Result<PieceImage> {
        self.make(std::slice::from_ref(candidate), size, None)
    }

    /// Lays out every candidate on its stand-in, keeps the least distorted, and makes its image.
    fn make(&self, candidates: &[Candidate], size: Size, way: Option<Way>) -> Result<PieceImage> {
        let mut best: Option<(Found, &Candidate)> = None;
        for candidate in candidates {
            let than = best.as_ref().map(|b| b.0.early);
            let found = Proxy::new(&candidate.disk, &candidate.border, self.options.search).search_map(size, than);
            if let Some(found) = found.filter(|f| best.as_ref().is_none_or(|b| f.layout.score < b.0.layout.score)) {
                best = Some((found, candidate));
            }
        }
        let (Found { layout, .. }, candidate) =
            best.ok_or_else(|| self.fail("layout", "the border does not fit the image".into(), "give it more texels"))?;
        self.finish(candidate, &layout, way)
    }

    /// Parameterises and resamples the disk in a layout.
    fn finish(&self, candidate: &Candidate, layout: &Layout, way: Option<Way>) -> Result<PieceImage> {
        let Layout { w, h, shift, ref count, .. } = *layout;
        let placed = candidate
            .border
            .place(&candidate.disk, self.surface, &|v| self.on_rim(v), w, h, shift, count)
            .ok_or_else(|| self.fail("border", "the boundary cannot be shared out".into(), "use a larger image"))?;
        let (disk, mut uv, texels) = (placed.disk, placed.uv, placed.texels);
        let fixed = disk.boundary_mask();
        let options = self.options;
        let (shape, enough) = (disk.shape(&fixed), enough(w, h));
        let record = match way {
            None => parameterize(shape, &mut uv, options.passes, &options.newton, enough),
            Some(way) => parameterize_by(way, shape, &mut uv, options.passes, &options.newton, enough),
        }
        .ok_or_else(|| {
            let hint = "remesh the slivers of this piece, or give it more texels";
            self.fail("parameterize", "no map free of flips was found".into(), hint)
        })?;
        let mut samples = resample(&disk, &uv, &texels, w, h).ok_or_else(|| {
            self.fail("resample", "a texel fell outside the map".into(), "please report it with the input")
        })?;
        let mut points: Vec<[f64; 3]> = samples.iter().map(|s| s.position(&disk)).collect();
        let mut rings: BTreeMap<Key, Vec<u32>> = BTreeMap::new();
        let mut loop_of = vec![disk::NONE; points.len()];
        for (p, t) in texels.iter().enumerate() {
            let at = border_index(p as u32, w, h);
            points[at] = t.position;
            loop_of[at] = t.rim.map_or(disk::NONE, |v| self.rim[v as usize]);
            rings.entry(t.key).or_default().push(at as u32);
        }
        let mut links = vec![disk::NONE; points.len()];
        for ring in rings.values_mut().filter(|r| r.len() > 1) {
            ring.sort_unstable();
            for (k, &at) in ring.iter().enumerate() {
                links[at as usize] = ring[(k + 1) % ring.len()];
            }
        }
        let distortion = distortion::measure(&disk.positions, &disk.triangles, &uv);
        let (columns, rows) = (w as usize + 1, h as usize + 1);
        let mut grid = Grid { links, ..Grid::new(columns, rows, points) };
        let far = distortion.symmetric_dirichlet > FAR || distortion.linf > FAR;
        let locator = far.then(|| Locator::new(&disk, &uv, w as usize, h as usize));
        let judged = |grid: &Grid| judge(self.surface, &disk, &uv, grid, locator.as_ref());
        let mut verdict = judged(&grid);
        let fit = match &options.sampling {
            Sampling::Fit(fit) => Some(self.fit(&disk, &uv, &mut grid, &loop_of, fit, &mut verdict, &judged)),
            Sampling::Point => None,
        };
        let expected = Expected { euler: self.cutter.euler(), loops: self.cutter.loops().len() };
        let sheet = Sheet { grid: &mut grid, samples: &mut samples, disk: &disk, uv: &uv };
        let (moved, closed) = seal(&mut [sheet], &[], expected);
        Ok(PieceImage {
            disk,
            uv,
            width: w + 1,
            height: h + 1,
            samples,
            grid,
            closed,
            loop_of,
            loop_lengths: self.cutter.loop_lengths(),
            moved: moved[0],
            distortion,
            parameterize: record,
            cut: candidate.cut.clone(),
            fit,
            verdict,
            tried: Vec::new(),
            budget: if let Size::Budget(n) = options.size { Some(n) } else { None },
        })
    }

    /// Fits the texels where that comes closer than sampling, as `judged`. `verdict` is that of the sampled texels.
    fn fit(
        &self,
        disk: &Disk,
        uv: &[[f64; 2]],
        grid: &mut Grid,
        loop_of: &[u32],
        options: &FitOptions,
        verdict: &mut Verdict,
        judged: &dyn Fn(&Grid) -> Verdict,
    ) -> FitRecord {
        let rings: Vec<Vec<u32>> = grid.rings().collect();
        let rim: Vec<bool> = loop_of.iter().map(|&l| l != disk::NONE).collect();
        let image = fit::Image { columns: grid.width, rows: grid.height, rings: &rings, rim: &rim };
        let sampled = grid.positions.clone();
        if !fit::fit(disk, uv, &mut grid.positions, &image, options) {
            return FitRecord::Failed;
        }
        let back = fit::restrain(&mut grid.positions, &sampled, &image);
        let fitted = judged(grid);
        if fitted.badness() <= verdict.badness().max(EXACT) {
            *verdict = fitted;
            FitRecord::Kept(back)
        } else {
            grid.positions = sampled;
            FitRecord::Dropped
        }
    }
}
