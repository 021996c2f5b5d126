//! One surface -> one geometry image: cut, border, parameterise, resample.

use std::collections::BTreeMap;

use crate::bend;
use crate::border::{Border, Key};
use crate::cut::Cutter;
use crate::disk::{self, Disk};
use crate::error::{Error, Result};
use crate::fit::{self, FitOptions};
use crate::grid::Grid;
use crate::grow::{GrowOptions, grow, hidden_costs};
use crate::layout::{self, Found, Layout, Proxy, SearchOptions, Size};
use crate::options::{BuildOptions, Effort, ImageSize, Sample, Seams};
use crate::parameterize::distortion::{self, Distortion};
use crate::parameterize::{NewtonOptions, ParameterizeRecord, parameterize};
use crate::resample::{Sample as DiskSample, border_index, resample};
use crate::seal::{Expected, seal};
use crate::surface::Surface;

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
            (_, b) => Size::Budget(b.unwrap_or(LEAST)),
        };
        let normal = SearchOptions {
            triangles: 600,
            shifts: 12,
            rough: 3,
            passes: 2,
            steps: [1, 2, 3],
            keep: [3, 1],
            refine: true,
            snap: 3,
        };
        let (grow, search) = match options.effort {
            Effort::Fast => (None, SearchOptions { shifts: 6, keep: [2, 1], refine: false, snap: 2, ..normal }),
            Effort::Default => (Some(GrowOptions::default()), normal),
            Effort::Best => {
                let grow = GrowOptions { triangles: 3000, points: 32, gain: 0.005 };
                (
                    Some(grow),
                    SearchOptions {
                        triangles: 3000,
                        shifts: 24,
                        rough: 24,
                        steps: [2, 4, 8],
                        keep: [12, 6],
                        snap: 6,
                        ..normal
                    },
                )
            }
        };
        Self {
            size,
            grow,
            search,
            newton: NewtonOptions::default(),
            passes: 8,
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
const LEAST: u32 = 64;

/// A mesh of many more triangles than half the cells, and than this, is mapped coarse to fine.
const LEAST_TRIANGLES: usize = 3000;

/// Cost of an edge on a UV seam, as a share of its length.
const SEAM_DISCOUNT: f64 = 0.15;

/// Sizes tried in turn, as shares of the budget, where an image does not weld as it should or has no flip-free map.
const BUDGETS: [f64; 8] = [1.0, 0.97, 0.93, 0.88, 1.1, 1.3, 1.6, 2.0];

/// How many texels a side an exact size may be short for a larger one to be named.
const SHORT: u32 = 24;

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
    options: &'a ImageOptions,
}

/// Makes the image of a connected surface. `uv_seam` tells the half-edges on UV seams, if the surface has any.
pub(crate) fn image(
    name: &str,
    surface: &Surface,
    uv_seam: Option<&[bool]>,
    options: &ImageOptions,
) -> Result<PieceImage> {
    let maker = Maker::new(name, surface, options)?;
    let mut candidates = maker.candidates(uv_seam, true)?;
    match options.size {
        Size::Budget(texels) => {
            let mut kept: Option<Result<PieceImage>> = None;
            for share in BUDGETS {
                let size = Size::Budget((f64::from(texels) * share) as u32);
                let made = maker.make(&candidates, size);
                if made.as_ref().is_ok_and(|i| i.closed) {
                    return made;
                }
                // The first that came out at all, else the first error.
                if kept.as_ref().is_none_or(|k| k.is_err() && made.is_ok()) {
                    kept = Some(made);
                }
            }
            kept.unwrap_or_else(|| Err(maker.fail("layout", "no size was tried".into(), "give more texels")))
        }
        Size::Fixed(width, height) => {
            let least = |c: &[Candidate]| c.iter().map(|c| c.border.least_steps()).min().unwrap_or(8);
            let holds = |w: u32, h: u32, least: u32| 2 * (w + h - 2) >= least;
            if !holds(width, height, least(&candidates)) {
                // A cut that was grown for quality asks for more texels than one that only has to open the surface.
                candidates = maker.candidates(uv_seam, false)?;
            }
            for more in 0..=SHORT {
                let (w, h) = (width + more, height + more);
                if !holds(w, h, least(&candidates)) {
                    continue;
                }
                match maker.make(&candidates, Size::Fixed(w, h)) {
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
                    Ok(image) if more == 0 && width.min(height) > 2 * SHORT => return Ok(image),
                    Err(e) if more == SHORT => return Err(e),
                    _ => {}
                }
            }
            let (w, h) = layout::smallest(least(&candidates));
            let (min_width, min_height) = (w.max(width + 1), h.max(height + 1));
            Err(Error::GridTooSmall { piece: name.to_owned(), width, height, min_width, min_height })
        }
    }
}

impl<'a> Maker<'a> {
    fn new(name: &'a str, surface: &'a Surface, options: &'a ImageOptions) -> Result<Self> {
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
        Ok(Self { name, surface, cutter, rim, options })
    }

    fn fail(&self, stage: &'static str, problem: String, hint: &str) -> Error {
        Error::Piece { piece: self.name.to_owned(), stage, problem, hint: hint.to_owned() }
    }

    fn on_rim(&self, v: u32) -> bool {
        self.rim[v as usize] != disk::NONE
    }

    /// The cuts worth laying out: along UV seams or not, as the options say, grown into limbs if `growing`.
    fn candidates(&self, uv_seam: Option<&[bool]>, growing: bool) -> Result<Vec<Candidate>> {
        let cutter = &self.cutter;
        let grown = self.options.grow.as_ref().filter(|_| growing).and_then(|g| grow(cutter, g));
        let terminals: &[u32] = grown.as_ref().map_or(&[], |g| &g.terminals);
        let along_uv: &[bool] = match (self.options.seams, uv_seam) {
            (_, None) | (Seams::Short, _) => &[false],
            (Seams::Uv, _) => &[true],
            (Seams::Auto, _) => &[false, true],
        };
        let (mut out, mut cuts) = (Vec::new(), Vec::new());
        for &along_uv in along_uv {
            let mut cost = hidden_costs(cutter, grown.as_ref().and_then(|g| g.mirror.as_ref()));
            if let Some(seam) = uv_seam.filter(|_| along_uv) {
                for (c, h) in cost.iter_mut().zip(&cutter.graph.halves) {
                    if seam[h[0] as usize] {
                        *c *= SEAM_DISCOUNT;
                    }
                }
            }
            let cut = match (&grown, along_uv) {
                // Without limbs or handles the surface itself knows the shorter way than its stand-in.
                (Some(g), false) if !terminals.is_empty() || cutter.handles() > 0 => g.cut.clone(),
                _ => cutter.cut(&cost, terminals),
            };
            if cuts.contains(&cut) {
                continue;
            }
            let mut disk = disk::open(cutter, &cut).map_err(|e| {
                let problem = format!("the cut left Euler number {} and {} loops", e.euler, e.loops);
                self.fail("cut", problem, "please report it with the input")
            })?;
            let border = Border::new(&mut disk, |v| self.on_rim(v));
            let record = CutRecord {
                length: cut.length(&cutter.graph),
                edges: cut.edges.iter().filter(|c| **c).count() as u32,
                grown: terminals.len(),
                uv_seams: along_uv,
                bought: grown.as_ref().and_then(|g| g.bought),
            };
            out.push(Candidate { disk, border, cut: record });
            cuts.push(cut);
        }
        Ok(out)
    }

    /// Lays out every candidate on its stand-in, keeps the least distorted, and makes its image.
    fn make(&self, candidates: &[Candidate], size: Size) -> Result<PieceImage> {
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
        self.finish(candidate, &layout)
    }

    /// Parameterises and resamples the disk in a layout.
    fn finish(&self, candidate: &Candidate, layout: &Layout) -> Result<PieceImage> {
        let Layout { w, h, shift, ref count, .. } = *layout;
        let placed = candidate
            .border
            .place(&candidate.disk, self.surface, &|v| self.on_rim(v), w, h, shift, count)
            .ok_or_else(|| self.fail("border", "the boundary cannot be shared out".into(), "use a larger image"))?;
        let (disk, mut uv, texels) = (placed.disk, placed.uv, placed.texels);
        let fixed = disk.boundary_mask();
        let options = self.options;
        let enough = LEAST_TRIANGLES.max((w * h) as usize / 2);
        let record =
            parameterize(disk.shape(&fixed), &mut uv, options.passes, &options.newton, enough).ok_or_else(|| {
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
        if let Sampling::Fit(fit_options) = &options.sampling {
            let rings: Vec<Vec<u32>> = grid.rings().collect();
            let rim: Vec<bool> = loop_of.iter().map(|&l| l != disk::NONE).collect();
            let image = fit::Image { columns, rows, rings: &rings, rim: &rim };
            fit::fit(&disk, &uv, &mut grid.positions, &image, fit_options);
        }
        let expected = Expected { euler: self.cutter.euler(), loops: self.cutter.loops().len() };
        let (moved, closed) = seal(&mut grid, &mut samples, &disk, &uv, expected);
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
            moved,
            distortion,
            parameterize: record,
            cut: candidate.cut.clone(),
        })
    }
}
