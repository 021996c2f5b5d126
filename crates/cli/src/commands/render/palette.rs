//! The colours of a GIF: a colour of a picture is shown alike in all pictures.
//!
//! Each picture of a GIF has at most 256 colours. Colours chosen for each picture by itself would change what stands
//! still, as ghost patches. Here the first picture chooses most of them, by median cut (Heckbert 1982), later ones add
//! what is too far from these while there is room, and what a colour was once shown as it stays.

use std::collections::HashMap;

/// Colours of a GIF.
const MOST: usize = 256;
/// Of them, those that the first picture may choose.
const FIRST: usize = 176;
/// Distance in RGB from which a later picture's colour is worth one of its own, where all room is left and where none is.
const FAR: [f64; 2] = [8.0, 48.0];

type Rgb = [u8; 3];

/// Colours, and what each colour met so far is shown as.
#[derive(Default)]
pub struct Palette {
    colors: Vec<Rgb>,
    shown: HashMap<Rgb, u8>,
}

impl Palette {
    /// Makes sure that every colour of a picture, or of the part of it that changed, is shown as something.
    pub fn take_in(&mut self, pixels: &[[u8; 4]]) {
        let mut new: Vec<Rgb> = pixels.iter().map(|&p| rgb(p)).filter(|c| !self.shown.contains_key(c)).collect();
        new.sort_unstable();
        // The most frequent first; equally frequent ones in order.
        let mut counted: Vec<(usize, Rgb)> = new.chunk_by(|a, b| a == b).map(|run| (run.len(), run[0])).collect();
        counted.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
        let first = self.colors.is_empty();
        if first {
            self.colors = median_cut(&counted, FIRST);
        }
        for (_, color) in counted {
            let used = self.colors.len().saturating_sub(FIRST) as f64 / (MOST - FIRST) as f64;
            let far = FAR[0] + (FAR[1] - FAR[0]) * used;
            let (nearest, gap) = self.nearest(color);
            let index = if !first && gap > far && self.colors.len() < MOST {
                self.colors.push(color);
                self.colors.len() - 1
            } else {
                nearest
            };
            // There are at most 256.
            self.shown.insert(color, index as u8);
        }
    }

    /// The index that a pixel is shown as, once its colour was taken in.
    pub fn index(&self, pixel: [u8; 4]) -> u8 {
        self.shown.get(&rgb(pixel)).copied().unwrap_or(0)
    }

    /// Red, green and blue of all colours, one after the other.
    pub fn bytes(&self) -> Vec<u8> {
        self.colors.as_flattened().to_vec()
    }

    fn nearest(&self, color: Rgb) -> (usize, f64) {
        let gap2 = |c: &Rgb| (0..3).map(|k| i32::from(c[k].abs_diff(color[k])).pow(2)).sum::<i32>();
        let best = self.colors.iter().map(gap2).enumerate().min_by_key(|&(k, gap)| (gap, k)).unwrap_or((0, i32::MAX));
        (best.0, f64::from(best.1).sqrt())
    }
}

fn rgb([r, g, b, _]: [u8; 4]) -> Rgb {
    [r, g, b]
}

/// At most `most` colours that stand for those counted: the box of colours with the largest squared error is halved at
/// its mean along its longest side, until there are enough.
fn median_cut(counted: &[(usize, Rgb)], most: usize) -> Vec<Rgb> {
    let mut boxes = vec![Part::of(counted.to_vec())];
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

    fn grey(g: u8) -> [u8; 4] {
        [g, g, g, 255]
    }

    #[test]
    fn few_colors_are_exact_and_flat_ones_stay_so_among_many() {
        let mut palette = Palette::default();
        palette.take_in(&[grey(3), grey(200), [9, 8, 7, 255]]);
        assert_eq!(palette.colors.len(), 3);
        assert_eq!(palette.colors[usize::from(palette.index([9, 8, 7, 255]))], [9, 8, 7]);
        // A background of one colour and 60,000 others.
        let mut pixels = vec![[244, 244, 242, 255]; 100_000];
        pixels.extend((0..60_000u32).map(|k| [(k / 256) as u8, (k % 256) as u8, (k % 100) as u8, 255]));
        let mut palette = Palette::default();
        palette.take_in(&pixels);
        assert_eq!(palette.colors[usize::from(palette.index([244, 244, 242, 255]))], [244, 244, 242]);
    }

    #[test]
    fn what_a_color_is_shown_as_stays() {
        let mut palette = Palette::default();
        palette.take_in(&(0..200).map(grey).collect::<Vec<_>>());
        let before: Vec<(u8, Rgb)> =
            (0..200).map(|g| palette.index(grey(g))).map(|i| (i, palette.colors[usize::from(i)])).collect();
        // Reds far from all of them get colours of their own, until there is no room.
        for r in 0..=255u8 {
            palette.take_in(&[[255, r, 0, 255], [r, 0, 255, 255], [0, 255, r, 255]]);
        }
        assert_eq!(palette.colors.len(), MOST);
        let after: Vec<(u8, Rgb)> =
            (0..200).map(|g| palette.index(grey(g))).map(|i| (i, palette.colors[usize::from(i)])).collect();
        assert_eq!(before, after);
        let near = palette.colors[usize::from(palette.index([255, 128, 0, 255]))];
        assert!(near[0] > 200 && near[2] < 60, "{near:?}");
    }
}
