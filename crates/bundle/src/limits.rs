//! Limits: how far particles may move from their positions at rest, and how far behind them.

use crate::bundle::Bundle;
use crate::map::MapKind;

/// The limit of a particle that has none \[m\].
pub const NO_LIMIT: f32 = -1.0;

impl Bundle {
    /// The largest distance \[m\] of every particle from its position at rest, by bundle-wide index, from `limit` maps and
    /// constants: 0 holds the particle, a negative number means no limit. `None` if no particle has a limit.
    ///
    /// ```
    /// let mut bundle = gimage_bundle::Bundle::new("example 1.0");
    /// bundle.add_piece("collar", 2, 2)?;
    /// bundle.add_piece("tail", 2, 2)?;
    /// assert_eq!(bundle.limits(), None);
    /// bundle.manifest.pieces[0].constants.limit = Some(0.02);
    /// assert_eq!(bundle.limits().unwrap(), [0.02, 0.02, 0.02, 0.02, -1.0, -1.0, -1.0, -1.0]);
    /// # Ok::<(), gimage_bundle::Error>(())
    /// ```
    pub fn limits(&self) -> Option<Vec<f32>> {
        let limited = |index: usize| {
            let image = self.image(index, &MapKind::Limit);
            let constant = self.manifest.pieces[index].constants.limit;
            image.is_some_and(|image| image.data.iter().any(|&x| x >= 0.0)) || constant.is_some_and(|x| x >= 0.0)
        };
        if !(0..self.manifest.pieces.len()).any(limited) {
            return None;
        }
        let texels = |index: usize| {
            let piece = &self.manifest.pieces[index];
            (0..piece.width as usize * piece.height as usize).map(move |k| self.limit(index, k))
        };
        Some((0..self.manifest.pieces.len()).flat_map(texels).collect())
    }

    /// How far every particle may go behind its position at rest \[m\], negative for no backstop, and the radius of the sphere that begins
    /// there \[m\], by bundle-wide index, from `backstop` maps. `None` if no particle has a backstop.
    pub fn backstops(&self) -> Option<Vec<[f32; 2]>> {
        let images: Vec<_> = (0..self.manifest.pieces.len()).map(|k| self.image(k, &MapKind::Backstop)).collect();
        let any = images.iter().flatten().any(|image| image.data.chunks_exact(3).any(|texel| texel[0] >= 0.0));
        let texels = |(image, piece): (&Option<&crate::map::Image>, &crate::manifest::PieceEntry)| {
            let at = |k: usize| image.and_then(|image| image.at(k).first_chunk().copied());
            let texels = piece.width as usize * piece.height as usize;
            (0..texels).map(|k| at(k).unwrap_or([NO_LIMIT, 0.0])).collect::<Vec<[f32; 2]>>()
        };
        any.then(|| images.iter().zip(&self.manifest.pieces).flat_map(texels).collect())
    }

    /// Where the mesh of the source is drawn at every particle, by bundle-wide index, from `blend` maps: 0 on the skin, 1 on the cloth.
    /// `None` if it is on the cloth everywhere.
    pub fn blends(&self) -> Option<Vec<f32>> {
        let images: Vec<_> = (0..self.manifest.pieces.len()).map(|k| self.image(k, &MapKind::Blend)).collect();
        let texels = |(image, piece): (&Option<&crate::map::Image>, &crate::manifest::PieceEntry)| {
            let at = |k: usize| image.and_then(|image| image.at(k).first().copied()).unwrap_or(1.0);
            (0..piece.width as usize * piece.height as usize).map(at).collect::<Vec<f32>>()
        };
        let all: Vec<f32> = images.iter().zip(&self.manifest.pieces).flat_map(texels).collect();
        all.iter().any(|share| *share < 1.0).then_some(all)
    }

    /// The limit of texel `k` of a piece: that of the map, else the constant, else [`NO_LIMIT`].
    pub(crate) fn limit(&self, piece: usize, k: usize) -> f32 {
        let constant = self.manifest.pieces.get(piece).and_then(|p| p.constants.limit);
        let stored = self.image(piece, &MapKind::Limit).and_then(|image| image.at(k).first().copied());
        stored.or(constant).unwrap_or(NO_LIMIT)
    }
}
