//! Paints and their textures as shaders/draw_surface.wgsl reads them.

use std::sync::Arc;

use gimage_bundle::Wrap;

use super::rows::PaintRow;
use super::surface::{Alpha, Paint};
use super::texture::Texture;

/// A row per paint and one for facets without a paint, and the textures of all: each once, its largest levels left out as far as all of them
/// would take more than `most` bytes.
pub fn rows(paints: &[Paint], most: u64) -> (Vec<PaintRow>, Vec<u32>) {
    let mut textures: Vec<&Arc<Texture>> = Vec::new();
    for texture in paints.iter().filter_map(|p| p.texture.as_ref()) {
        if !textures.iter().any(|known| Arc::ptr_eq(known, texture)) {
            textures.push(texture);
        }
    }
    let begins = begins(&textures, most);
    let (mut texels, mut places) = (Vec::new(), Vec::new());
    for (texture, begin) in textures.iter().zip(&begins) {
        let levels: Vec<_> = texture.levels().skip(*begin).collect();
        places.push((texels.len() as u32, levels.len() as u32));
        let mut first = (texels.len() + 3 * levels.len()) as u32;
        for ([width, height], pixels) in &levels {
            texels.extend([first, *width as u32, *height as u32]);
            first += pixels.len() as u32;
        }
        texels.extend(levels.iter().flat_map(|(_, pixels)| pixels.iter().map(|p| u32::from_le_bytes(*p))));
    }
    let row = |paint: &Paint| {
        let place = paint.texture.as_ref().and_then(|t| textures.iter().position(|known| Arc::ptr_eq(known, t)));
        let (first, levels) = place.map_or((0, 0), |n| places[n]);
        let (alpha, cutoff) = match paint.alpha {
            Alpha::Opaque => (0, 0.0),
            Alpha::Mask(cutoff) => (1, cutoff),
            Alpha::Blend => (2, 0.0),
        };
        let [u, v] = paint.wrap.map(|wrap| match wrap {
            Wrap::Repeat => 0,
            Wrap::Clamp => 1,
            Wrap::Mirror => 2,
        });
        let (pad_a, pad_b, pad_c) = (0, 0, 0);
        PaintRow { color: paint.color, alpha, cutoff, wrap: u + 4 * v, first, levels, pad_a, pad_b, pad_c }
    };
    let list = paints.iter().map(row).chain([row(&Paint::default())]).collect();
    // A buffer has at least one number.
    texels.resize(texels.len().max(1), 0);
    (list, texels)
}

/// The first level of each texture that is kept: the largest ones go first.
fn begins(textures: &[&Arc<Texture>], most: u64) -> Vec<usize> {
    let sizes: Vec<Vec<u64>> =
        textures.iter().map(|t| t.levels().map(|(_, pixels)| 4 * pixels.len() as u64 + 12).collect()).collect();
    let mut begins = vec![0; textures.len()];
    let mut total: u64 = sizes.iter().flatten().sum();
    while total > most {
        let last = |k: usize| begins[k] + 1 >= sizes[k].len();
        let largest = (0..sizes.len()).filter(|k| !last(*k)).max_by_key(|k| (sizes[*k][begins[*k]], usize::MAX - *k));
        let Some(k) = largest else { break };
        total -= sizes[k][begins[k]];
        begins[k] += 1;
    }
    begins
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_are_there_once_and_lose_levels_where_they_are_too_large() {
        let texture =
            |side: u32| Arc::new(Texture::new(side, side, vec![[side as u8; 4]; (side * side) as usize]).unwrap());
        let (large, small) = (texture(16), texture(4));
        let paint = |t: &Arc<Texture>, alpha| Paint { texture: Some(t.clone()), alpha, ..Paint::default() };
        let paints = [paint(&large, Alpha::Opaque), paint(&small, Alpha::Blend), paint(&large, Alpha::Mask(0.25))];
        let (rows, texels) = rows(&paints, u64::MAX);
        assert_eq!(rows.iter().map(|r| r.levels).collect::<Vec<_>>(), [5, 3, 5, 0]);
        assert_eq!((rows[0].first, rows[2].first, rows[2].alpha, rows[2].cutoff), (rows[2].first, 0, 1, 0.25));
        assert_eq!(texels.len(), 3 * 8 + 256 + 64 + 16 + 4 + 1 + 16 + 4 + 1);
        let head = rows[1].first as usize;
        assert_eq!((texels[head + 1], texels[texels[head] as usize]), (4, 0x0404_0404));
        let (fewer, less) = super::rows(&paints, 400);
        assert_eq!((fewer[0].levels, fewer[1].levels, less[1]), (3, 3, 4));
        assert!(4 * less.len() <= 400);
    }
}
