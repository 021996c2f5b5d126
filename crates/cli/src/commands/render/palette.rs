//! The colours of a GIF, the same for all its pictures.
//!
//! Each picture of a GIF has at most 256 colours. Colours chosen for each picture by itself change what stands still, as
//! ghost patches. Here all pictures share theirs, found by median cut (Heckbert 1982; the box of the largest squared
//! error is cut, at its mean), and a colour is shown alike wherever it occurs.

use std::collections::HashMap;

/// Colours of a GIF.
const MOST: usize = 256;

/// Red, green and blue, sRGB.
pub type Rgb = [u8; 3];

/// How often each colour occurs.
#[derive(Default)]
pub struct Counts(HashMap<Rgb, usize>);

impl Counts {
    /// Counts the colours of a picture, or of a part of it.
    pub fn add(&mut self, pixels: &[Rgb]) {
        pixels.iter().for_each(|&p| *self.0.entry(p).or_insert(0) += 1);
    }
}

/// At most 256 colours.
pub struct Palette {
    colors: Vec<Rgb>,
    /// Colours looked up already.
    shown: HashMap<Rgb, u8>,
}

impl Palette {
    /// The colours that stand best for those counted.
    pub fn of(counts: &Counts) -> Self {
        let mut counted: Vec<(usize, Rgb)> = counts.0.iter().map(|(&color, &n)| (n, color)).collect();
        // The order of a hash map is chance.
        counted.sort_unstable_by_key(|c| c.1);
        Palette { colors: median_cut(counted, MOST), shown: HashMap::new() }
    }

    /// The index of the nearest colour.
    pub fn index(&mut self, color: Rgb) -> u8 {
        let colors = &self.colors;
        *self.shown.entry(color).or_insert_with(|| {
            let gap2 = |c: &Rgb| (0..3).map(|k| u32::from(c[k].abs_diff(color[k])).pow(2)).sum::<u32>();
            // There are at most 256.
            colors.iter().map(gap2).enumerate().min_by_key(|&(k, gap)| (gap, k)).map_or(0, |(k, _)| k as u8)
        })
    }

    /// Red, green and blue of all colours, one after the other.
    pub fn bytes(&self) -> &[u8] {
        self.colors.as_flattened()
    }
}

/// At most `most` colours that stand for those counted, at least one.
fn median_cut(counted: Vec<(usize, Rgb)>, most: usize) -> Vec<Rgb> {
    let mut boxes = vec![Part::of(counted)];
    while boxes.len() < most {
        let worst = (0..boxes.len()).max_by(|&a, &b| boxes[a].error.total_cmp(&boxes[b].error).then(b.cmp(&a)));
        let Some(k) = worst.filter(|&k| boxes[k].error > 0.0) else { break };
        let Part { colors, mean, axis, .. } = boxes.swap_remove(k);
        let (low, high) = colors.into_iter().partition(|(_, c)| f64::from(c[axis]) <= mean[axis]);
        boxes.extend([Part::of(low), Part::of(high)]);
    }
    boxes.iter().map(|b| b.mean.map(|x| x.round() as u8)).collect()
}

/// Some colours and how often each occurs.
struct Part {
    colors: Vec<(usize, Rgb)>,
    mean: [f64; 3],
    /// Along which they spread most.
    axis: usize,
    /// Sum of the squared distances from the mean, 0 for a single colour.
    error: f64,
}

impl Part {
    fn of(colors: Vec<(usize, Rgb)>) -> Self {
        let count = colors.iter().map(|c| c.0 as f64).sum::<f64>().max(1.0);
        let sum = |f: &dyn Fn(&Rgb) -> f64| colors.iter().map(|(n, c)| *n as f64 * f(c)).sum::<f64>();
        let mean = [0, 1, 2].map(|k| sum(&|c| f64::from(c[k])) / count);
        let spread = [0, 1, 2].map(|k| sum(&|c| (f64::from(c[k]) - mean[k]).powi(2)));
        let axis = (0..3).fold(0, |best, k| if spread[k] > spread[best] { k } else { best });
        let error = if colors.len() > 1 { spread.iter().sum() } else { 0.0 };
        Part { colors, mean, axis, error }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(palette: &mut Palette, color: Rgb) -> Rgb {
        let index = palette.index(color);
        palette.colors[usize::from(index)]
    }

    #[test]
    fn few_colors_are_exact_and_a_flat_ground_stays_so_among_many() {
        let mut counts = Counts::default();
        counts.add(&[[3, 3, 3], [200, 200, 200], [9, 8, 7]]);
        let mut palette = Palette::of(&counts);
        assert_eq!((palette.colors.len(), shown(&mut palette, [9, 8, 7])), (3, [9, 8, 7]));
        // A ground of one colour and 60,000 others.
        counts.add(&vec![[244, 244, 242]; 100_000]);
        let many: Vec<Rgb> = (0..60_000u32).map(|k| [(k / 256) as u8, (k % 256) as u8, (k % 100) as u8]).collect();
        counts.add(&many);
        let mut palette = Palette::of(&counts);
        assert_eq!((palette.colors.len(), shown(&mut palette, [244, 244, 242])), (MOST, [244, 244, 242]));
        let gap = |(a, b): (Rgb, Rgb)| (0..3).map(|k| u32::from(a[k].abs_diff(b[k])).pow(2)).sum::<u32>();
        let mean = many.iter().map(|&c| gap((c, shown(&mut palette, c)))).sum::<u32>() as f64 / many.len() as f64;
        assert!(mean < 500.0, "{mean}");
    }

    #[test]
    fn no_color_at_all_is_survived() {
        let mut palette = Palette::of(&Counts::default());
        assert_eq!(palette.index([1, 2, 3]), 0);
    }
}
