//! Pictures as the bytes of a file.

use std::cell::RefCell;
use std::io::{Cursor, Write};
use std::rc::Rc;

use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame, ImageFormat, RgbImage, RgbaImage};

use super::Kind;
use crate::exit::Failure;

/// A file in the making.
pub struct Pictures {
    size: (u32, u32),
    fps: u32,
    png: Option<Vec<u8>>,
    gif: Option<GifEncoder<Shared>>,
    gif_bytes: Shared,
    last: Vec<[u8; 4]>,
}

/// Where the encoder, which does not hand its writer back, and the file meet.
#[derive(Clone, Default)]
struct Shared(Rc<RefCell<Vec<u8>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Speed of the search for a GIF's colours: 1 is the best and slowest, 30 the quickest.
const SPEED: i32 = 10;

impl Pictures {
    /// Of a kind and size; `fps` pictures a second in a GIF.
    pub fn new(kind: Kind, size: (u32, u32), fps: u32) -> Self {
        let gif_bytes = Shared::default();
        let gif = (kind == Kind::Gif).then(|| GifEncoder::new_with_speed(gif_bytes.clone(), SPEED));
        Pictures { size, fps, png: None, gif, gif_bytes, last: Vec::new() }
    }

    /// The next picture.
    pub fn add(&mut self, pixels: Vec<[u8; 4]>) -> Result<(), Failure> {
        let (width, height) = self.size;
        let Some(gif) = &mut self.gif else {
            let rgb = pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
            let picture = RgbImage::from_raw(width, height, rgb).ok_or_else(|| wrong(&"its size"))?;
            let mut bytes = Cursor::new(Vec::new());
            picture.write_to(&mut bytes, ImageFormat::Png).map_err(|e| wrong(&e))?;
            self.png = Some(bytes.into_inner());
            return Ok(());
        };
        if self.last.is_empty() {
            gif.set_repeat(Repeat::Infinite).map_err(|e| wrong(&e))?;
        }
        // Only the part that differs from the picture before is stored.
        let [left, top, right, bottom] = changed(&self.last, &pixels, width as usize);
        let (w, h) = (right - left, bottom - top);
        let rows = pixels.chunks_exact(width as usize).skip(top).take(h);
        let part = rows.flat_map(|row| row[left..right].as_flattened().iter().copied()).collect();
        let part = RgbaImage::from_raw(w as u32, h as u32, part).ok_or_else(|| wrong(&"its size"))?;
        let delay = Delay::from_numer_denom_ms(1000, self.fps);
        gif.encode_frame(Frame::from_parts(part, left as u32, top as u32, delay)).map_err(|e| wrong(&e))?;
        self.last = pixels;
        Ok(())
    }

    /// The file.
    pub fn finish(self) -> Result<Vec<u8>, Failure> {
        let Some(gif) = self.gif else { return self.png.ok_or_else(|| wrong(&"there is no picture")) };
        // Ends the file.
        drop(gif);
        Ok(self.gif_bytes.0.take())
    }
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
    use super::*;

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
