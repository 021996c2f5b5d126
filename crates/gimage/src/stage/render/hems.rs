//! Borders that are sewn to another piece. Stitches give in motion, by up to a thousandth of the diagonal, so vertices on such a border ride on the
//! other piece: no gap opens in the drawn mesh, and the triangles of the border take up the difference.

use std::collections::BTreeMap;

use gimage_bundle::{Bundle, MapKind};

use super::surface::{Spot, Texels};

/// Share of the weights of a point that the ends of a sewn edge of the border have, so that the point is on that edge.
const ON_EDGE: f64 = 0.9;

/// The texels of borders that are sewn.
pub(super) struct Hems {
    /// By bundle-wide texels: the piece that each is sewn to, and how far away that is at rest \[m\].
    sewn: BTreeMap<u32, (usize, f64)>,
}

impl Hems {
    /// Those of a bundle. O(n log n) in its texels.
    pub fn new(bundle: &Bundle, texels: &Texels) -> Self {
        let mut sewn = BTreeMap::new();
        for (index, piece) in bundle.manifest.pieces.iter().enumerate() {
            let Some(image) = bundle.image(index, &MapKind::Stitch) else { continue };
            for k in 0..piece.width * piece.height {
                if let Some(&[to, _, _, distance]) =
                    image.at(k as usize).first_chunk().filter(|v: &&[f32; 4]| v[0] >= 0.0)
                {
                    // Duplicates of a point may have stitches of their own; the first one counts.
                    let point = texels.welded[(piece.first_particle + k) as usize];
                    sewn.entry(point).or_insert((to as usize, f64::from(distance)));
                }
            }
        }
        if !sewn.is_empty() {
            let border = border(texels);
            sewn.retain(|point, _| border.binary_search(point).is_ok());
        }
        Hems { sewn }
    }

    /// The piece that a point of a surface is sewn to, and how far away that is at rest \[m\]; `None` beside sewn borders.
    pub fn target(&self, texels: &Texels, spot: &Spot) -> Option<(usize, f64)> {
        if self.sewn.is_empty() {
            return None;
        }
        let corners = texels.triangles[spot.triangle as usize].map(|k| self.sewn.get(&texels.welded[k as usize]));
        let ends = || corners.iter().zip(spot.weights).filter_map(|(sewn, w)| Some((sewn.copied()?, w)));
        let (piece, _) = ends().max_by(|a, b| a.1.total_cmp(&b.1))?.0;
        let own = || ends().filter(|((to, _), _)| *to == piece);
        let share: f64 = own().map(|(_, w)| w).sum();
        let distance = own().map(|((_, distance), _)| distance).fold(0.0, f64::max);
        (share >= ON_EDGE && own().count() >= 2).then_some((piece, distance))
    }
}

/// The points of edges of a single triangle, in ascending order.
fn border(texels: &Texels) -> Vec<u32> {
    let mut sides: Vec<[u32; 2]> = Vec::with_capacity(3 * texels.triangles.len());
    for t in &texels.triangles {
        let [a, b, c] = t.map(|k| texels.welded[k as usize]);
        sides.extend([[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]));
    }
    sides.sort_unstable();
    let mut points: Vec<u32> =
        sides.chunk_by(|a, b| a == b).filter(|run| run.len() == 1).flat_map(|run| run[0]).collect();
    points.sort_unstable();
    points.dedup();
    points
}
