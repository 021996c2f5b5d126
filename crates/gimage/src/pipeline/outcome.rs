//! Outcome of each component: an image, images of its parts, or an accessory.

use std::borrow::Cow;

use rayon::prelude::*;

use super::budget::{self, Made};
use super::room::fits;
use crate::base::halfedge;
use crate::base::mesh::{Mesh, Semantic};
use crate::base::surface::Surface;
use crate::base::words;
use crate::error::{Error, Result};
use crate::options::{BuildOptions, ImageSize};
use crate::progress::{Progress, Stage};
use crate::record::Finding;
use crate::stage::assemble::accessory::Rider;
use crate::stage::assemble::{Family, Piece, part_components};
use crate::stage::component::{ALWAYS_PIECE, Component, extract};
use crate::stage::image::judge::Verdict;
use crate::stage::image::ladder::{Rung, Tried, WORTH, badness, is_sound, passes};
use crate::stage::image::{ImageOptions, PieceImage, image};
use crate::stage::split::{PartImage, Parts, image_parts};

/// How much larger than its share the image of a small piece may get to hold its border.
const STRETCH: u32 = 4;

/// The outcome of a component.
pub(super) enum Outcome {
    Piece(Surface, Box<PieceImage>),
    Parts(Parts),
    Accessory(String),
}

/// The parts of every component that was split, as components of their own.
pub(super) fn name_parts(pieces: &[Component], accessories: &[Component], made: &[Outcome]) -> Vec<Vec<Component>> {
    let mut taken = pieces.iter().chain(accessories).map(|c| c.name.to_lowercase()).collect();
    let named = |(whole, outcome): (&Component, &Outcome)| match outcome {
        Outcome::Parts(parts) => part_components(whole, parts, &mut taken),
        _ => Vec::new(),
    };
    pieces.iter().zip(made).map(named).collect()
}

/// An image this many times as large as its budget is too large: the component is split into parts, if those fit.
const TOO_LARGE: f64 = 1.5;

/// The pieces of a bundle in their order, the accessories, and the families of parts.
pub(super) struct Gathered<'a> {
    /// The pieces.
    pub pieces: Vec<Piece<'a>>,
    /// Components that became accessories.
    pub riders: Vec<Rider<'a>>,
    /// Which consecutive pieces are the parts of one component.
    pub families: Vec<Family<'a>>,
}

/// Sorts the outcomes of all components; `named` are the parts of those that were split.
pub(super) fn gather<'a>(components: &'a [Component], made: Vec<Outcome>, named: &'a [Vec<Component>]) -> Gathered<'a> {
    let mut out = Gathered { pieces: Vec::new(), riders: Vec::new(), families: Vec::new() };
    for ((component, outcome), named) in components.iter().zip(made).zip(named) {
        match outcome {
            Outcome::Piece(surface, image) => out.pieces.push(Piece { component, surface, image: *image }),
            Outcome::Parts(Parts { parts, rings }) => {
                let (whole, first, count) = (component, out.pieces.len(), parts.len());
                out.families.push(Family { whole, first, count, rings });
                let piece = |(component, p): (_, PartImage)| Piece { component, surface: p.surface, image: p.image };
                out.pieces.extend(named.iter().zip(parts).map(piece));
            }
            Outcome::Accessory(reason) => out.riders.push(Rider { component, reason }),
        }
    }
    out
}

/// Makes the images of all components, in parallel and within the budget of the options; a finding where they exceed it.
pub(super) fn images(
    mesh: &Mesh,
    components: &[Component],
    options: &BuildOptions,
    progress: &dyn Progress,
) -> Result<(Vec<Outcome>, Option<Finding>)> {
    let total: f64 = components.iter().map(|p| p.area).sum();
    let one = |component: &Component, share, known: Option<(&Surface, Rung)>| {
        if progress.cancelled() {
            return Err(Error::Cancelled);
        }
        let surface = || known.map_or_else(|| Cow::Owned(extract(mesh, component)), |k| Cow::Borrowed(k.0));
        make(mesh, component, surface, total, (share, known.map(|k| k.1)), options)
    };
    let shares = shares(components, options)?;
    let made: Vec<Result<Outcome>> = components
        .par_iter()
        .zip(&shares)
        .map(|(component, &share)| {
            let out = one(component, share, None);
            progress.step(Stage::Image);
            out
        })
        .collect();
    let mut made = made.into_iter().collect::<Result<Vec<_>>>()?;
    let finding = match options.image.size {
        ImageSize::Texels(texels) => keep_budget(components, &shares, &mut made, texels, &one)?,
        _ => None,
    };
    Ok((made, finding))
}

/// The size that a component's image may have, or that it gets none.
#[derive(Clone, Copy)]
enum Share {
    /// An exact size, whatever the area.
    Exact,
    /// A number of texels.
    Texels(u32),
    /// Too few for an image.
    TooSmall,
}

/// The share of each component, in their order.
fn shares(components: &[Component], options: &BuildOptions) -> Result<Vec<Share>> {
    let total: f64 = components.iter().map(|c| c.area).sum();
    match options.image.size {
        ImageSize::Exact(width, height) => {
            let texels = f64::from(width) * f64::from(height) * components.len() as f64;
            let what =
                || format!("{} of {width} x {height} texels", words::counted(components.len(), "image", "images"));
            fits(texels, what, "give a smaller size, or select fewer parts with --cloth")?;
            Ok(vec![Share::Exact; components.len()])
        }
        ImageSize::Texels(n) => {
            fits(f64::from(n), || "the images".into(), "give fewer texels")?;
            let areas: Vec<f64> = components.iter().map(|c| c.area).collect();
            let share = |s: Option<u32>| s.map_or(Share::TooSmall, Share::Texels);
            Ok(budget::share_out(&areas, n).into_iter().map(share).collect())
        }
        ImageSize::Spacing(d) => {
            let share = |component: &Component| {
                let texels = component.area / (d * d);
                fits(texels, || format!("piece {} at a spacing of {d} m", component.name), LARGER)?;
                let small = texels.ceil() < f64::from(budget::LEAST_SHARE) && component.area < ALWAYS_PIECE * total;
                Ok(if small { Share::TooSmall } else { Share::Texels(texels.ceil() as u32) })
            };
            let shares = components.iter().map(share).collect::<Result<Vec<_>>>()?;
            let texels = shares.iter().map(|s| if let Share::Texels(n) = s { f64::from(*n) } else { 0.0 }).sum();
            fits(
                texels,
                || format!("{} at a spacing of {d} m", words::counted(components.len(), "piece", "pieces")),
                LARGER,
            )?;
            Ok(shares)
        }
    }
}

const LARGER: &str = "give a larger spacing";

fn make<'a>(
    mesh: &Mesh,
    component: &Component,
    surface: impl FnOnce() -> Cow<'a, Surface>,
    total: f64,
    (share, rung): (Share, Option<Rung>),
    options: &BuildOptions,
) -> Result<Outcome> {
    let texels = match share {
        Share::Exact => None,
        Share::Texels(n) => Some(n),
        Share::TooSmall => {
            let least = budget::LEAST_SHARE;
            return Ok(Outcome::Accessory(format!("its share of the texels is under {least}, too small for a grid")));
        }
    };
    let surface = surface();
    let seam = uv_seams(mesh, &surface);
    let image_options = ImageOptions { rung, ..ImageOptions::new(options, texels) };
    let mut image = image(&component.name, &surface, seam.as_deref(), &image_options);
    // The last rung of the ladder: where one image does not hold the surface at its size, or comes out poor.
    let fits = |i: &PieceImage, b: u32| i.closed && f64::from(i.width * i.height) <= TOO_LARGE * f64::from(b);
    // Stretch alone does not count: parts of a needle are needles.
    let good = |i: &PieceImage, b: u32| fits(i, b) && is_sound(&i.verdict);
    if let Some(b) = texels.filter(|&b| image.as_ref().map_or(true, |i| !good(i, b))) {
        let parts = match image_parts(&component.name, &surface, seam.as_deref(), &image_options, b) {
            // It says how many texels the border needs that does not fit one image.
            Err(e @ Error::TooLarge { .. }) if matches!(image, Err(Error::Piece { stage: "layout", .. })) => {
                return Err(e);
            }
            parts => parts.ok(),
        };
        let verdict = parts.as_ref().map(|p| p.verdict(&surface));
        let tried = |kept: bool| Tried { rung: Rung::Split, psnr: verdict.map(|v| v.0.psnr()), kept };
        let better = |i: &PieceImage| {
            let worth = |v: &Verdict, stretch| badness(v, stretch) < WORTH * badness(&i.verdict, i.distortion.linf);
            !fits(i, b) || verdict.is_some_and(|(v, stretch)| passes(&v, stretch) || worth(&v, stretch))
        };
        match (parts, &mut image) {
            (Some(mut parts), image) if image.as_ref().map_or(true, better) => {
                let mut record: Vec<Tried> = image.as_ref().map_or_else(|_| Vec::new(), |i| i.tried.clone());
                record.iter_mut().for_each(|t| t.kept = false);
                record.push(tried(true));
                parts.parts.iter_mut().for_each(|p| p.image.tried.clone_from(&record));
                return Ok(Outcome::Parts(parts));
            }
            (_, Ok(image)) => image.tried.push(tried(false)),
            _ => {}
        }
    }
    let image = image?;
    if let Some(b) = texels
        && component.area < ALWAYS_PIECE * total
        && image.width * image.height > STRETCH * b.max(budget::LEAST_SHARE)
    {
        return Ok(Outcome::Accessory(format!(
            "its border needs {} x {} texels, its share is {b}",
            image.width, image.height
        )));
    }
    Ok(Outcome::Piece(surface.into_owned(), Box::new(image)))
}

/// Makes the image of a component, of its surface and by the rung that served it before where these are known.
type One<'a> = dyn Fn(&Component, Share, Option<(&Surface, Rung)>) -> Result<Outcome> + Sync + 'a;

/// Makes images again, smaller, until all together have no more texels than asked for; a warning where that fails.
fn keep_budget(
    components: &[Component],
    shares: &[Share],
    outcomes: &mut [Outcome],
    texels: u32,
    one: &One<'_>,
) -> Result<Option<Finding>> {
    let total: f64 = components.iter().map(|c| c.area).sum();
    let size = |o: &Outcome| match o {
        Outcome::Piece(_, i) => i.width * i.height,
        Outcome::Parts(parts) => parts.texels() as u32,
        Outcome::Accessory(_) => 0,
    };
    let pieces: Vec<usize> = (0..outcomes.len()).filter(|&k| size(&outcomes[k]) > 0).collect();
    let mut made: Vec<Made> = pieces
        .iter()
        .map(|&k| {
            let asked = if let Share::Texels(n) = shares[k] { n } else { 0 };
            Made::new(asked, size(&outcomes[k]), components[k].area / total)
        })
        .collect();
    for _ in 0..budget::ROUNDS {
        let again = budget::again(&made, texels);
        if again.is_empty() {
            break;
        }
        let known = |k: usize| match &outcomes[k] {
            Outcome::Piece(surface, image) => Some((surface, image.rung())),
            _ => None,
        };
        let smaller: Vec<Result<Outcome>> = again
            .par_iter()
            .map(|&(m, asked)| one(&components[pieces[m]], Share::Texels(asked), known(pieces[m])))
            .collect();
        for ((m, asked), outcome) in again.into_iter().zip(smaller) {
            let outcome = match outcome {
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                // There is an image of it already.
                other => other.ok(),
            };
            let keep = made[m].made_again(asked, outcome.as_ref().map(size));
            if let Some(outcome) = outcome.filter(|_| keep) {
                outcomes[pieces[m]] = outcome;
            }
        }
    }
    let names: Vec<&str> = pieces.iter().map(|&k| components[k].name.as_str()).collect();
    Ok(budget::exceeded(&made, &names, texels))
}

/// For each half-edge of the surface whether the first UV set differs across it; `None` without UVs, without seams, or
/// where seams are everywhere and so tell nothing.
fn uv_seams(mesh: &Mesh, surface: &Surface) -> Option<Vec<bool>> {
    let uv = mesh.channel(&Semantic::TexCoord(0))?;
    let twin = halfedge::twins(&surface.triangles).ok()?;
    let value = |h: u32| {
        let t = h as usize / 3;
        uv.at(surface.source_triangle[t] as usize, surface.source_corner(t, h as usize % 3))
    };
    let mut seam = vec![false; twin.len()];
    let (mut inner, mut many) = (0usize, 0usize);
    for h in 0..twin.len() as u32 {
        let w = twin[h as usize];
        if w == halfedge::BOUNDARY {
            continue;
        }
        inner += 1;
        let next = halfedge::next;
        let same_way =
            surface.triangles[h as usize / 3][h as usize % 3] == surface.triangles[w as usize / 3][w as usize % 3];
        let (a, b) = if same_way { (w, next(w)) } else { (next(w), w) };
        seam[h as usize] = value(h) != value(a) || value(next(h)) != value(b);
        many += usize::from(seam[h as usize]);
    }
    (many > 0 && 3 * many < inner).then_some(seam)
}
