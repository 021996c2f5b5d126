//! One surface -> one geometry image: cut, border, parameterise, resample.

use std::collections::HashMap;

use crate::border::{Border, Key};
use crate::cut::Cutter;
use crate::disk::{self, Disk};
use crate::error::{Error, Result};
use crate::fit::{FitOptions, fit};
use crate::grid::Grid;
use crate::grow::{GrowOptions, grow};
use crate::layout::{self, Layout, Proxy, SearchOptions, Size};
use crate::options::{BuildOptions, ImageSize, Sample, Seams};
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
        Self {
            size,
            grow: Some(GrowOptions::default()),
            search: SearchOptions { triangles: 1000, shifts: 12, passes: 3, steps: 5, refine: true },
            newton: NewtonOptions::default(),
            passes: 8,
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

/// Makes the image of a connected surface. `uv_seam` tells the half-edges on UV seams, if the surface has any.
pub(crate) fn image(
    name: &str,
    surface: &Surface,
    uv_seam: Option<&[bool]>,
    options: &ImageOptions,
) -> Result<PieceImage> {
    let fail = |stage: &'static str, problem: String, hint: &str| Error::Piece {
        piece: name.to_owned(),
        stage,
        problem,
        hint: hint.to_owned(),
    };
    let cutter = Cutter::new(surface)
        .ok_or_else(|| fail("cut", "the surface is not a manifold".into(), "this is a fault of the repair stage"))?;
    let mut rim = vec![disk::NONE; surface.positions.len()];
    for (k, l) in cutter.loops().iter().enumerate() {
        l.iter().for_each(|&v| rim[v as usize] = k as u32);
    }
    let grown = options.grow.as_ref().and_then(|g| grow(&cutter, g));
    let terminals: &[u32] = grown.as_ref().map_or(&[], |g| &g.terminals);
    // The candidates: every set of edge costs, laid out on its own stand-in; the least energy wins.
    let mut best: Option<(Layout, Disk, Border, CutRecord)> = None;
    let mut smallest = u32::MAX;
    let candidates: &[bool] = match (options.seams, uv_seam) {
        (_, None) | (Seams::Short, _) => &[false],
        (Seams::Uv, _) => &[true],
        (Seams::Auto, _) => &[false, true],
    };
    for &along_uv in candidates {
        let mut cost = cutter.graph.length.clone();
        if let Some(seam) = uv_seam.filter(|_| along_uv) {
            for (c, h) in cost.iter_mut().zip(&cutter.graph.halves) {
                if seam[h[0] as usize] {
                    *c *= SEAM_DISCOUNT;
                }
            }
        }
        let cut = match (&grown, along_uv) {
            (Some(g), false) if !terminals.is_empty() || cutter.handles() > 0 => g.cut.clone(),
            _ => cutter.cut(&cost, terminals),
        };
        let mut disk = disk::open(&cutter, &cut).map_err(|e| {
            fail(
                "cut",
                format!("the cut left Euler number {} and {} loops", e.euler, e.loops),
                "please report it with the input",
            )
        })?;
        let border = Border::new(&mut disk, |v| rim[v as usize] != disk::NONE);
        smallest = smallest.min(border.least_steps());
        let mut proxy = Proxy::new(&disk, &border, options.search);
        let Some(layout) = proxy.search(options.size) else { continue };
        drop(proxy);
        let record = CutRecord {
            length: cut.length(&cutter.graph),
            edges: cut.edges.iter().filter(|c| **c).count() as u32,
            grown: terminals.len(),
            uv_seams: along_uv,
        };
        if best.as_ref().is_none_or(|b| layout.score < b.0.score) {
            best = Some((layout, disk, border, record));
        }
    }
    let Some((layout, disk, border, cut)) = best else {
        let (min_width, min_height) = layout::smallest(smallest);
        let (width, height) = match options.size {
            Size::Fixed(w, h) => (w, h),
            Size::Budget(_) => (0, 0),
        };
        return Err(Error::GridTooSmall { piece: name.to_owned(), width, height, min_width, min_height });
    };
    let Layout { w, h, shift, count, .. } = layout;
    let placed = border
        .place(&disk, surface, &|v| rim[v as usize] != disk::NONE, w, h, shift, &count)
        .ok_or_else(|| fail("border", "the boundary cannot be shared out".into(), "use a larger image"))?;
    let (disk, mut uv, texels) = (placed.disk, placed.uv, placed.texels);
    let fixed = disk.boundary_mask();
    let record = parameterize(&disk.positions, &disk.triangles, &fixed, &mut uv, options.passes, &options.newton)
        .ok_or_else(|| {
            fail("parameterize", "no map free of flips was found".into(), "repair or remesh the slivers of this piece")
        })?;
    let mut samples = resample(&disk, &uv, &texels, w, h)
        .ok_or_else(|| fail("resample", "a texel fell outside the map".into(), "please report it with the input"))?;
    let mut points: Vec<[f64; 3]> = samples.iter().map(|s| s.position(&disk)).collect();
    let mut rings: HashMap<Key, Vec<u32>> = HashMap::new();
    let mut loop_of = vec![disk::NONE; points.len()];
    for (p, t) in texels.iter().enumerate() {
        let at = border_index(p as u32, w, h);
        points[at] = t.position;
        loop_of[at] = t.rim.map_or(disk::NONE, |v| rim[v as usize]);
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
    if let Sampling::Fit(fit_options) = &options.sampling {
        fit(&disk, &uv, &mut points, columns, rows, fit_options);
    }
    let mut grid = Grid { links, ..Grid::new(columns, rows, points) };
    let expected = Expected { euler: cutter.euler(), loops: cutter.loops().len() };
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
        loop_lengths: cutter.loop_lengths(),
        moved,
        distortion,
        parameterize: record,
        cut,
    })
}

/// Cost of an edge on a UV seam, as a share of its length.
const SEAM_DISCOUNT: f64 = 0.15;
