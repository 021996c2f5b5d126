//! Pictures as the bytes of a file.

use gif::{DisposalMethod, Encoder, Frame, Repeat};

use super::Kind;
use super::palette::{Counts, Palette, Rgb};
use crate::commands::png;
use crate::exit::Failure;

/// A file in the making.
pub struct Pictures {
    kind: Kind,
    size: (u32, u32),
    fps: u32,
    png: Option<Vec<u8>>,
    gif: Option<(Encoder<Vec<u8>>, Palette)>,
    last: Vec<[u8; 4]>,
    /// Parts that wait until the colours are known, which they have a say in.
    waiting: Vec<Part>,
    counts: Counts,
}

/// The part that differs from the picture before: left, top, width and height, and its pixels.
struct Part {
    place: [u16; 4],
    pixels: Vec<Rgb>,
}

/// Pixels that wait at most, 256 MiB: some 300 pictures of 640 x 480. Those have a say in the colours, later ones do not.
const WAITING: usize = (256 << 20) / 3;

impl Pictures {
    /// Of a kind and size; `fps` pictures per second in a GIF.
    pub fn new(kind: Kind, size: (u32, u32), fps: u32) -> Self {
        let (waiting, counts) = (Vec::new(), Counts::default());
        Pictures { kind, size, fps, png: None, gif: None, last: Vec::new(), waiting, counts }
    }

    /// The next picture.
    pub fn add(&mut self, pixels: Vec<[u8; 4]>) -> Result<(), Failure> {
        let width = self.size.0;
        if self.kind == Kind::Png {
            self.png = Some(png::encode(self.size, &pixels)?);
            return Ok(());
        }
        // Only the part that differs from the picture before is stored.
        let [left, top, right, bottom] = changed(&self.last, &pixels, width as usize);
        let (w, h) = (right - left, bottom - top);
        let rows = pixels.chunks_exact(width as usize).skip(top).take(h);
        let pixels_of = |[r, g, b, _]: &[u8; 4]| [*r, *g, *b];
        let part = rows.flat_map(|row| row[left..right].iter().map(pixels_of)).collect();
        // Cannot be larger: the size of a picture is checked before.
        let side = |n: usize| u16::try_from(n).map_err(|e| wrong(&e));
        let part = Part { place: [side(left)?, side(top)?, side(w)?, side(h)?], pixels: part };
        self.last = pixels;
        if let Some((gif, palette)) = &mut self.gif {
            return write(gif, palette, part, self.fps);
        }
        self.counts.add(&part.pixels);
        self.waiting.push(part);
        if self.waiting.iter().map(|p| p.pixels.len()).sum::<usize>() > WAITING {
            self.choose_colors()?;
        }
        Ok(())
    }

    /// Chooses the colours, and writes what has waited for them.
    fn choose_colors(&mut self) -> Result<(), Failure> {
        let mut palette = Palette::of(&std::mem::take(&mut self.counts));
        let side = |n: u32| u16::try_from(n).map_err(|e| wrong(&e));
        let (width, height) = (side(self.size.0)?, side(self.size.1)?);
        let mut gif = Encoder::new(Vec::new(), width, height, palette.bytes()).map_err(|e| wrong(&e))?;
        gif.set_repeat(Repeat::Infinite).map_err(|e| wrong(&e))?;
        for part in std::mem::take(&mut self.waiting) {
            write(&mut gif, &mut palette, part, self.fps)?;
        }
        self.gif = Some((gif, palette));
        Ok(())
    }

    /// The file.
    pub fn finish(mut self) -> Result<Vec<u8>, Failure> {
        if self.kind == Kind::Png {
            return self.png.ok_or_else(|| wrong(&"there is no picture"));
        }
        if self.gif.is_none() {
            self.choose_colors()?;
        }
        let (gif, _) = self.gif.ok_or_else(|| wrong(&"there is no picture"))?;
        gif.into_inner().map_err(|e| wrong(&e))
    }
}

fn write(gif: &mut Encoder<Vec<u8>>, palette: &mut Palette, part: Part, fps: u32) -> Result<(), Failure> {
    let [left, top, width, height] = part.place;
    let frame = Frame {
        left,
        top,
        width,
        height,
        buffer: part.pixels.iter().map(|&p| palette.index(p)).collect::<Vec<u8>>().into(),
        // Pixels beside the part stay as they were.
        dispose: DisposalMethod::Keep,
        // Hundredths of a second.
        delay: (100.0 / f64::from(fps.max(1))).round().clamp(1.0, 65_535.0) as u16,
        ..Frame::default()
    };
    gif.write_frame(&frame).map_err(|e| wrong(&e))
}

fn wrong(what: &dyn std::fmt::Display) -> Failure {
    gimage::Error::Internal(format!("encoding a picture: {what}")).into()
}

/// Left, top, right and bottom of what differs; all of it where there is no picture before, a pixel where nothing does.
fn changed(before: &[[u8; 4]], now: &[[u8; 4]], width: usize) -> [usize; 4] {
    if before.len() != now.len() {
        return [0, 0, width, now.len() / width];
    }
    let mut part = [usize::MAX, usize::MAX, 0, 0];
    for k in (0..now.len()).filter(|k| before[*k] != now[*k]) {
        let (x, y) = (k % width, k / width);
        part = [part[0].min(x), part[1].min(y), part[2].max(x + 1), part[3].max(y + 1)];
    }
    if part[2] == 0 { [0, 0, 1, 1] } else { part }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    #[test]
    fn a_png_is_what_was_drawn() {
        let drawn: Vec<[u8; 4]> = (0..35u8).map(|k| [7 * k, 255 - k, k, 255]).collect();
        let mut pictures = Pictures::new(Kind::Png, (7, 5), 1);
        pictures.add(drawn.clone()).unwrap();
        // Read by another library.
        let read = image::load_from_memory(&pictures.finish().unwrap()).unwrap().to_rgba8();
        assert_eq!(read.dimensions(), (7, 5));
        assert_eq!(read.as_raw(), drawn.as_flattened());
    }

    #[test]
    fn a_gif_shows_every_picture_whole() {
        let (width, height) = (8, 6);
        let grey = |g: u8| vec![[g, g, g, 255]; 48];
        let mut second = grey(0);
        second[8 * 4 + 6] = [255, 255, 255, 255];
        let mut pictures = Pictures::new(Kind::Gif, (width, height), 20);
        pictures.add(grey(0)).unwrap();
        pictures.add(second.clone()).unwrap();
        let bytes = pictures.finish().unwrap();
        // Read with another library's rules of composition.
        let frames = image::codecs::gif::GifDecoder::new(Cursor::new(bytes)).unwrap();
        let frames = image::AnimationDecoder::into_frames(frames).collect_frames().unwrap();
        let shown: Vec<_> = frames.iter().map(|f| f.buffer().as_raw().clone()).collect();
        assert_eq!(shown, [grey(0).as_flattened().to_vec(), second.as_flattened().to_vec()]);
    }

    /// A shaded square moves over a shaded ground: what stands still keeps its colour, and so does what comes back.
    #[test]
    fn static_objects_show_no_ghost_patches() {
        let (width, height) = (64usize, 48usize);
        let ground = |x: usize, y: usize| [(2 * x + 90) as u8, (3 * y + 60) as u8, (x + y) as u8, 255];
        let square = |x: usize, y: usize| [(255 - 9 * x) as u8, (20 + 11 * y) as u8, (8 * x + 7 * y) as u8, 255];
        let picture = |at: usize| -> Vec<[u8; 4]> {
            let inside = |x: usize, y: usize| (at..at + 12).contains(&x) && (10..22).contains(&y);
            let pixel = |x, y| if inside(x, y) { square(x - at, y - 10) } else { ground(x, y) };
            (0..width * height).map(|k| pixel(k % width, k / width)).collect()
        };
        let taken: Vec<_> = (0..10).map(|k| picture(4 * k)).collect();
        let mut pictures = Pictures::new(Kind::Gif, (width as u32, height as u32), 20);
        taken.iter().for_each(|p| pictures.add(p.clone()).unwrap());
        let bytes = pictures.finish().unwrap();
        let frames = image::codecs::gif::GifDecoder::new(Cursor::new(bytes)).unwrap();
        let frames = image::AnimationDecoder::into_frames(frames).collect_frames().unwrap();
        let shown = |frame: usize, k: usize| frames[frame].buffer().as_raw()[4 * k..4 * k + 3].to_vec();
        for frame in 1..taken.len() {
            for (k, pixel) in taken[frame].iter().enumerate() {
                if *pixel == taken[0][k] {
                    assert_eq!(shown(frame, k), shown(0, k), "picture {frame}, pixel {k}");
                }
                let gap = |c: usize| i32::from(shown(frame, k)[c]) - i32::from(pixel[c]);
                assert!((0..3).all(|c| gap(c).abs() < 32), "picture {frame}, pixel {k}: {pixel:?}");
            }
        }
    }

    #[test]
    fn only_what_differs_is_stored() {
        let mut b = vec![[0, 0, 0, 255]; 12];
        assert_eq!(changed(&[], &b, 4), [0, 0, 4, 3]);
        let a = b.clone();
        assert_eq!(changed(&a, &b, 4), [0, 0, 1, 1]);
        (b[5], b[10]) = ([1, 0, 0, 255], [0, 2, 0, 255]);
        assert_eq!(changed(&a, &b, 4), [1, 1, 3, 3]);
    }
}
