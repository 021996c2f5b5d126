//! Textures of surfaces.

use std::sync::LazyLock;

use gimage_bundle::Wrap;

use super::raster::{decoded, encoded};
use crate::error::{Result, check};

/// Most pixels on a side of a texture.
const MAX_SIDE: u32 = 16_384;

/// An image with its smaller levels: 4/3 of 4 bytes per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    levels: Vec<Level>,
}

/// Rows of sRGB pixels with alpha, from the top.
#[derive(Clone, Debug, PartialEq)]
struct Level {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 4]>,
}

/// Linear light of each sRGB byte.
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|byte| decoded(byte as f32 / 255.0)));

impl Texture {
    /// An image of sRGB pixels with alpha, row by row from the top. Errors on sides outside 1 to 16,384, and on a list of another length.
    pub fn new(width: u32, height: u32, pixels: Vec<[u8; 4]>) -> Result<Self> {
        for side in [width, height] {
            check("a side of a texture [pixels]", side.into(), "1 to 16384", |s| {
                (1.0..=f64::from(MAX_SIDE)).contains(&s)
            })?;
        }
        let expected = width as usize * height as usize;
        check("the pixels of a texture", pixels.len() as f64, "width times height", |n| n == expected as f64)?;
        let mut levels = vec![Level { width: width as usize, height: height as usize, pixels }];
        while let Some(last) = levels.last().filter(|l| l.width > 1 || l.height > 1) {
            let next = last.half();
            levels.push(next);
        }
        Ok(Texture { levels })
    }

    /// The level whose pixels are nearest to one per sample, for a triangle that covers `area` of the unit square of texture coordinates and
    /// `samples` of a picture.
    pub(super) fn level(&self, area: f32, samples: f32) -> usize {
        let first = &self.levels[0];
        let pixels = area * (first.width * first.height) as f32 / samples.max(1e-6);
        // A level has a quarter of the pixels of the one before.
        (0.5 * pixels.max(1.0).log2()).round().min((self.levels.len() - 1) as f32) as usize
    }

    /// Width, height and pixels of its levels, the largest first.
    #[cfg(feature = "gpu")]
    pub(super) fn levels(&self) -> impl ExactSizeIterator<Item = ([usize; 2], &[[u8; 4]])> {
        self.levels.iter().map(|level| ([level.width, level.height], &level.pixels[..]))
    }

    /// Linear colour and alpha at texture coordinates, between four pixels of a level.
    pub(super) fn at(&self, [u, v]: [f32; 2], level: usize, wrap: [Wrap; 2]) -> [f32; 4] {
        let level = &self.levels[level.min(self.levels.len() - 1)];
        let (x, y) = (place(u, level.width, wrap[0]), place(v, level.height, wrap[1]));
        let row = |y: usize| {
            let [a, b] = [x.0, x.1].map(|x| linear(level.pixels[y * level.width + x]));
            [0, 1, 2, 3].map(|c| a[c] + (b[c] - a[c]) * x.2)
        };
        let (a, b) = (row(y.0), row(y.1));
        [0, 1, 2, 3].map(|c| a[c] + (b[c] - a[c]) * y.2)
    }
}

/// The two pixels beside a coordinate, and the share of the second.
fn place(u: f32, size: usize, wrap: Wrap) -> (usize, usize, f32) {
    let u = if u.is_finite() { u } else { 0.0 };
    let turned = u - 2.0 * (0.5 * u).floor();
    let inside = match wrap {
        Wrap::Repeat => return repeated(u - u.floor(), size),
        Wrap::Clamp => u.clamp(0.0, 1.0),
        Wrap::Mirror if turned > 1.0 => 2.0 - turned,
        Wrap::Mirror => turned,
    };
    let x = inside * size as f32 - 0.5;
    let low = x.floor();
    let pixel = |x: f32| x.clamp(0.0, (size - 1) as f32) as usize;
    (pixel(low), pixel(low + 1.0), x - low)
}

/// The same for a coordinate of 0 to 1, where the last pixel is beside the first.
fn repeated(u: f32, size: usize) -> (usize, usize, f32) {
    let x = u * size as f32 - 0.5;
    let low = x.floor();
    let first = if low < 0.0 { size - 1 } else { (low as usize).min(size - 1) };
    (first, (first + 1) % size, x - low)
}

fn linear([r, g, b, a]: [u8; 4]) -> [f32; 4] {
    let [r, g, b] = [r, g, b].map(|c| LINEAR[usize::from(c)]);
    [r, g, b, f32::from(a) / 255.0]
}

impl Level {
    /// Half the size: the mean of four pixels in linear light, weighed by alpha, so that colours of holes do not show at their rims.
    fn half(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mean = |k: usize| {
            let (x, y) = (2 * (k % width), 2 * (k / width));
            let at = |dx: usize, dy: usize| {
                let (x, y) = ((x + dx).min(self.width - 1), (y + dy).min(self.height - 1));
                linear(self.pixels[y * self.width + x])
            };
            let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
            let alpha: f32 = four.iter().map(|p| p[3]).sum();
            let weight = |p: &[f32; 4]| if alpha > 0.0 { p[3] / alpha } else { 0.25 };
            let byte = |x: f32| (x * 255.0 + 0.5) as u8;
            let [r, g, b] = [0, 1, 2].map(|c| byte(encoded(four.iter().map(|p| p[c] * weight(p)).sum())));
            [r, g, b, byte(alpha / 4.0)]
        };
        Level { width, height, pixels: (0..width * height).map(mean).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REPEAT: [Wrap; 2] = [Wrap::Repeat; 2];

    #[test]
    fn beyond_its_borders_a_texture_repeats_goes_on_or_is_mirrored() {
        let pixels = [0, 255, 0, 255].map(|x| [x, x, x, 255]);
        let texture = Texture::new(4, 1, pixels.to_vec()).unwrap();
        let at = |u: f32, wrap| texture.at([u, 0.5], 0, [wrap, Wrap::Clamp])[0];
        for k in -9..9 {
            let (u, inside) = (0.25 * k as f32 + 0.125, |k: i32| [0.0, 1.0, 0.0, 1.0][k as usize]);
            assert_eq!(at(u, Wrap::Repeat), inside(i32::rem_euclid(k, 4)), "{k}");
            assert_eq!(at(u, Wrap::Clamp), inside(k.clamp(0, 3)), "{k}");
            let turned = i32::rem_euclid(k, 8);
            assert_eq!(at(u, Wrap::Mirror), inside(turned.min(7 - turned)), "{k}");
        }
        // At the border itself only a repeating texture mixes both ends.
        assert!((at(0.0, Wrap::Repeat) - 0.5).abs() < 1e-6);
        assert_eq!(
            [at(0.0, Wrap::Clamp), at(0.0, Wrap::Mirror), at(1.0, Wrap::Clamp), at(1.0, Wrap::Mirror)],
            [0.0, 0.0, 1.0, 1.0]
        );
    }

    #[test]
    fn pixels_are_mixed_between_their_middles_and_repeat() {
        let texture = Texture::new(2, 1, vec![[0, 0, 0, 255], [255, 255, 255, 0]]).unwrap();
        assert_eq!(texture.at([0.25, 0.5], 0, REPEAT), [0.0, 0.0, 0.0, 1.0]);
        assert_eq!(texture.at([0.75, 0.5], 0, REPEAT), [1.0, 1.0, 1.0, 0.0]);
        for u in [0.5, 0.0, 1.0, -3.0] {
            assert!((texture.at([u, 0.3], 0, REPEAT)[0] - 0.5).abs() < 1e-5, "{u}");
        }
        assert!(texture.at([f32::NAN, f32::INFINITY], 9, REPEAT).iter().all(|x| x.is_finite()));
    }

    #[test]
    fn a_texture_that_does_not_exist_is_refused() {
        assert!(Texture::new(0, 1, vec![]).is_err() && Texture::new(2, 2, vec![[0; 4]; 3]).is_err());
    }
}
