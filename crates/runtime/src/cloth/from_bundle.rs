//! A loaded bundle as one cloth.

use gimage_bundle::{Bundle, MapKind};

use super::{Backstop, Cloth, Grid, Mass, Parts, Rest};
use crate::error::Result;

/// Mass \[kg\] of a particle where the bundle says nothing. Without other masses only wind depends on it.
const DEFAULT_MASS: f32 = 1e-3;

impl Cloth {
    /// All pieces of a bundle as one cloth; particle indices are those of the bundle. Where every piece with springs has
    /// constant rest lengths (or masses), no image is made for them; a bundle without rest lengths has no springs.
    /// Tethers of the bundle are kept until pins change, its first texture coordinates for materials, and its
    /// joints if every piece has some ([`Cloth::follow_joints`]). Its stitches become [`Cloth::stitches`]. A piece made from fabric with a thickness sets
    /// [`Cloth::thickness`]: of several the largest, so that none enters a collider. Colliders in place of a body set it too: to half the
    /// distance from the body that they were fitted to, so that cloth between them stays off the body. Errors as [`Cloth::new`].
    pub fn from_bundle(name: &str, bundle: &Bundle) -> Result<Self> {
        let pieces = &bundle.manifest.pieces;
        let grids: Vec<Grid> = pieces
            .iter()
            .map(|p| Grid { name: p.name.clone(), first: p.first_particle, width: p.width, height: p.height })
            .collect();
        let mut positions = Vec::new();
        for (index, grid) in grids.iter().enumerate() {
            let image = bundle.image(index, &MapKind::Position);
            let xyz = |k: usize| image.and_then(|i| i.at(k).get(..3)?.try_into().ok()).unwrap_or([0.0; 3]);
            positions.extend((0..grid.texels()).map(xyz));
        }
        let parts = Parts {
            name: name.into(),
            rest: rest(bundle, &grids),
            mass: mass(bundle, &grids),
            particles: bundle.particles()?,
            positions,
            grids,
        };
        let mut cloth = Cloth::new(parts)?;
        cloth.limits = bundle.limits().map(Into::into);
        let backstop = |[distance, radius]: [f32; 2]| Backstop { distance, radius };
        cloth.backstops = bundle.backstops().map(|all| all.into_iter().map(backstop).collect());
        cloth.keep_grain(grain(bundle, cloth.grids()));
        cloth.set_stitches(bundle.stitches())?;
        cloth.keep_tethers(bundle.stored_tethers());
        cloth.keep_skin(bundle)?;
        cloth.keep_body(bundle)?;
        let clearances = pieces.iter().filter_map(|p| Some(p.shell.as_ref()?.clearance() as f32));
        cloth.thickness = clearances.chain(fitted(bundle)).filter(|c| (0.0..=1.0).contains(c)).reduce(f32::max);
        Ok(cloth)
    }

    /// One channel of a map of a bundle, for [`super::Select::Map`]: one value per texel of every piece, in the order of the
    /// particles; NaN, which no selection takes, in pieces without the map or the channel.
    pub fn map_values(bundle: &Bundle, kind: &MapKind, channel: usize) -> Vec<f32> {
        let mut values = Vec::new();
        for (index, piece) in bundle.manifest.pieces.iter().enumerate() {
            let image = bundle.image(index, kind);
            let value = |k: usize| image.and_then(|i| i.at(k).get(channel).copied()).unwrap_or(f32::NAN);
            values.extend((0..piece.width as usize * piece.height as usize).map(value));
        }
        values
    }
}

/// Half the distance \[m\] from the body that the colliders of a bundle were fitted to, if it has any. The whole distance stretches cloth between
/// pins, which lie on the body, twice as much.
fn fitted(bundle: &Bundle) -> Option<f32> {
    let manifest = &bundle.manifest;
    let error = manifest.options.get("collider-error").filter(|_| !manifest.colliders.is_empty())?;
    error.as_f64().map(|error| 0.5 * error as f32)
}

/// The first texture coordinates, if every piece has them.
fn grain(bundle: &Bundle, grids: &[Grid]) -> Option<Vec<[f32; 2]>> {
    let mut uv = Vec::new();
    for (index, grid) in grids.iter().enumerate() {
        let image = bundle.image(index, &MapKind::Uv(0))?;
        uv.extend((0..grid.texels()).map(|k| image.at(k).first_chunk().copied().unwrap_or_default()));
    }
    Some(uv)
}

fn rest(bundle: &Bundle, grids: &[Grid]) -> Rest {
    let images: Vec<_> = (0..grids.len()).map(|g| bundle.image(g, &MapKind::Rest)).collect();
    let constant = |g: usize| bundle.manifest.pieces[g].constants.rest.unwrap_or([0.0; 4]);
    let constants: Vec<_> = (0..grids.len()).map(constant).collect();
    if images.iter().any(Option::is_some) {
        let of = |(g, grid): (usize, &Grid)| -> Vec<[f32; 4]> {
            let at = |k| images[g].and_then(|i| i.at(k).try_into().ok()).unwrap_or(constants[g]);
            (0..grid.texels()).map(at).collect()
        };
        return Rest::Image(grids.iter().enumerate().flat_map(of).collect());
    }
    if constants.iter().flatten().any(|l| *l != 0.0) { Rest::Constant(constants) } else { Rest::None }
}

fn mass(bundle: &Bundle, grids: &[Grid]) -> Mass {
    let images: Vec<_> = (0..grids.len()).map(|g| bundle.image(g, &MapKind::Mass)).collect();
    let constant = |g: usize| bundle.manifest.pieces[g].constants.mass.unwrap_or(DEFAULT_MASS);
    let first = if grids.is_empty() { DEFAULT_MASS } else { constant(0) };
    if images.iter().all(Option::is_none) && (0..grids.len()).all(|g| constant(g) == first) {
        return Mass::Constant(first);
    }
    let of = |(g, grid): (usize, &Grid)| -> Vec<f32> {
        let at = |k| images[g].and_then(|i| i.at(k).first().copied()).unwrap_or(constant(g));
        (0..grid.texels()).map(at).collect()
    };
    Mass::Image(grids.iter().enumerate().flat_map(of).collect())
}
